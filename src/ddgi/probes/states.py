"""Probe states: which probes are worth an update.

A probe far from all surfaces lights none, and one inside a wall should not; neither is traced or blended,
and neither gives light (SCALE 6; CTU 6.1). The six states are SCALE's; CTU's ALIVE, SLEEPING and DEAD are
AWAKE, SLEEPING and OFF. Ours needs no distance to choose, and no faces to trust: a probe is worth an update
if it sees a lit surface in one of its own cells, as only points in those read it.

Probes are classified when the field is fitted. Now and then sleepers look around again with a few rays, which
find distances and shade nothing, and wake up where something has come near. Those rays are always the
same: what stands still looks the same every time, and states settle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal

import drjit as dr
import mitsuba as mi
import numpy as np
from annotated_types import Interval
from typing_extensions import Doc

from ddgi.box import Box
from ddgi.own_memory import own_numbers
from ddgi.probes import receivers
from ddgi.probes.awake import AWAKE, NEWLY_AWAKE, NEWLY_VIGILANT, OFF, SLEEPING, Awake, States
from ddgi.probes.grid import ProbeGrid
from ddgi.probes.region import Seen
from ddgi.probes.relocation import INSIDE
from ddgi.probes.surroundings import look_around
from ddgi.probes.volume import ProbeVolume
from ddgi.settings_group import settings_group
from ddgi.trace.tracer import Tracer

if TYPE_CHECKING:
    from ddgi.settings import RenderSettings

MOSTLY_BACKS = 0.5
"""Share of back faces among what is near above which a probe is dead (CTU 6.1)."""
WITHIN = 0.999
"""Of a spacing: so far from the place of a probe points read it, rounding aside. Walls just outside a grid lie, for the
second plane of probes, on the far side of its cells exactly.
"""
ROUND = 32
"""Lists of probes are filled up with sleepers to a multiple of that: kernels are compiled for their length, and one that
wakes up should not have all compiled anew.
"""
LENGTHS = 16
"""Of lists, at most, for fields whose probes wake and sleep again."""


@settings_group("states")
class Settings:
    """Which probes are updated."""

    method: Annotated[
        Literal["cells", "scale", "ctu", "off"],
        Doc(
            "those that see a lit surface in their own cells; that have a front nearer than a spacing (SCALE 6); or anything "
            "within a cell's diagonal (CTU 6.1); or all, as for smoke and fog"
        ),
    ] = "cells"
    rays: Annotated[
        int, Interval(ge=8, le=4096), Doc("rays by which probes are classified when the field is fitted")
    ] = 512
    every: Annotated[
        int,
        Interval(ge=0, le=10_000),
        Doc(
            "updates from one look of sleeping probes to the next; in ctu they are updated then, too (CTU 6.1: 10); 0: they sleep on"
        ),
    ] = 10
    look_rays: Annotated[int, Interval(ge=1, le=1024), Doc("rays of each such look")] = 32
    alive: Annotated[
        int,
        Interval(ge=0, le=100_000),
        Doc("ctu: updates that a probe stays alive for since it last met anything near (CTU 6.1, no number)"),
    ] = 60


def classify(vol: ProbeVolume, tracer: Tracer, seen: Seen, s: Settings, warm_up: int) -> ProbeVolume:
    """The volume with the states of its probes found anew (SCALE listing 5).

    Args:
        vol: Its probes stand where they are to stand. Those that are up already are not new again.
        tracer: The scene.
        seen: Surfaces that light reaches on its way to the cameras (`region.look`).
        s: How.
        warm_up: Updates before means begin (`blend.warm_up`).
    """
    size = vol.grid.size
    everyone = replace(vol, states=None, awake=Awake(size), grid=vol.grid.giving_light(np.ones(size, bool)))
    if s.method == "off":
        return everyone
    useful, dead = _judged(tracer, vol.grid, np.ones(vol.grid.size, bool), s.rays, s)
    if s.method == "cells":
        # What cameras see may be too thin for rays in all directions to meet.
        useful |= receivers.served(tracer, vol.grid, seen)
        dead &= ~useful
    up = AWAKE if s.method == "ctu" else NEWLY_VIGILANT
    code = np.where(dead, OFF, np.where(useful, up, SLEEPING))
    if (code <= SLEEPING).all():
        return everyone  # nothing that a probe could light: all show what little there is
    if vol.states is not None:
        before = np.array(vol.states.code).astype(int)
        code = np.where((before > SLEEPING) & (code > SLEEPING), before, code)
    return _with(vol, code, np.zeros_like(code), s, warm_up)


def attend(vol: ProbeVolume, tracer: Tracer, tick: int, settings: RenderSettings) -> ProbeVolume:
    """What is done before an update: every so often, sleepers look around, and CTU's take part in the update.

    Args:
        vol: The volume.
        tracer: The scene.
        tick: Number of the frame.
        settings: How often, and how.
    """
    s = settings.states
    if vol.states is None or s.every == 0:
        return vol
    states, phase = vol.states, tick % s.every
    if phase != s.every - 1:
        # The update after those in which CTU's sleepers took part is for the others alone again.
        return _listed(vol, s) if s.method == "ctu" and phase == 0 else vol
    code, quiet = (np.array(x).astype(int) for x in (states.code, states.quiet))
    looks = (code == SLEEPING) | ((code == AWAKE) & (s.method == "ctu"))
    if looks.any():
        useful, _ = _judged(tracer, vol.grid, looks, s.look_rays, s)
        after = _after(code[looks], quiet[looks] + s.every, useful, s)
        if (after[0] != code[looks]).any():
            code[looks], quiet[looks] = after
            vol = _with(vol, code, quiet, s, settings.blend.warm_up)
        else:
            quiet[looks] = after[1]
            vol = replace(vol, states=replace(states, quiet=own_numbers(quiet)))
    return _listed(vol, s, sleepers=True) if s.method == "ctu" else vol


def wake(vol: ProbeVolume, boxes: Sequence[Box], settings: RenderSettings) -> ProbeVolume:
    """Wake the sleepers around things that move, and let those sleep that woke for things which are gone (SCALE 6.3).

    CTU's fall asleep by themselves, some time after (`alive`).

    Args:
        vol: The volume.
        boxes: Around the things [m], in the coordinates of probes; they are enlarged by a cell.
        settings: Of the frame.
    """
    if vol.states is None:
        return vol
    code, place = np.array(vol.states.code).astype(int), _where(vol.grid.place, vol.grid)
    cell = np.ravel(vol.grid.spacing)
    inside = np.zeros(len(code), bool)
    for low, high in boxes:
        inside |= ((place >= np.array(low) - cell) & (place <= np.array(high) + cell)).all(-1)
    gone = ((code == AWAKE) | (code == NEWLY_AWAKE)) & ~inside & (settings.states.method != "ctu")
    new = np.where(inside & (code == SLEEPING), NEWLY_AWAKE, np.where(gone, SLEEPING, code))
    if (new == code).all():
        return vol
    quiet = np.where(new == NEWLY_AWAKE, 0, np.array(vol.states.quiet).astype(int))
    return _with(vol, new, quiet, settings.states, settings.blend.warm_up)


def _judged(
    tracer: Tracer, grid: ProbeGrid, which: np.ndarray, rays: int, s: Settings
) -> tuple[np.ndarray, np.ndarray]:
    """Which of some probes are worth an update, and which are dead. (p,) each.

    Args:
        tracer: The scene.
        grid: All probes.
        which: (P,) bool, the p that are asked about.
        rays: By which they look around.
        s: The rule.
    """
    position = _where(grid.position, grid)[which]
    around = look_around(tracer, position, rays)
    match s.method:
        case "scale":
            _, front = around.nearest(back=False)
            return np.less(front, np.ravel(grid.spacing).max()), np.greater(around.behind, INSIDE)
        case "ctu":
            near = around.distance < float(grid.diagonal[0])
            backs = (near & around.back).sum(0)
            useful, dead = np.asarray(near.any(0)), backs > MOSTLY_BACKS * np.maximum(near.sum(0), 1)
            return useful, dead
    place = _where(grid.place, grid)
    low, high = place.min(0), place.max(0)
    met = np.isfinite(around.distance)
    hit = position + around.directions[:, None] * np.where(met, around.distance, 0)[..., None]
    # What lies outside the grid reads its outermost cells. On the far side of a cell a probe counts for nothing.
    own = met & (np.abs(np.clip(hit, low, high) - place[which]) < WITHIN * np.ravel(grid.spacing)).all(-1)
    lit: np.ndarray = np.any(own & around.lit, axis=0)
    unlit: np.ndarray = np.any(own, axis=0) & ~lit
    return lit, unlit


def _after(
    code: np.ndarray, quiet: np.ndarray, useful: np.ndarray, s: Settings
) -> tuple[np.ndarray, np.ndarray]:
    """States of probes after a look, and for how long they have met nothing. (p,) each."""
    quiet = np.where(useful, 0, quiet)
    tired = (code == AWAKE) & (quiet > s.alive)
    woken = (code == SLEEPING) & useful
    up = NEWLY_AWAKE if s.method == "ctu" else NEWLY_VIGILANT
    after: np.ndarray = np.where(woken, up, np.where(tired, SLEEPING, code))
    return after, quiet


def _with(vol: ProbeVolume, code: np.ndarray, quiet: np.ndarray, s: Settings, warm_up: int) -> ProbeVolume:
    """The volume with other states of its probes. code, quiet: (P,)."""
    gives_light = code > (OFF if s.method == "ctu" else SLEEPING)
    states = States(own_numbers(code), own_numbers(quiet), own_numbers(_stand_ins(vol.grid, gives_light)))
    new = (code == NEWLY_AWAKE) | (code == NEWLY_VIGILANT)
    vol = replace(vol.renewed(new, warm_up), states=states, grid=vol.grid.giving_light(gives_light))
    return _listed(vol, s)


def _listed(vol: ProbeVolume, s: Settings, *, sleepers: bool = False) -> ProbeVolume:
    """The volume with the list of probes that its next update is for."""
    assert vol.states is not None
    code = np.array(vol.states.code)
    up = code >= (SLEEPING if sleepers else NEWLY_AWAKE)
    missing = min(_length(int(up.sum()), vol, s), len(code)) - up.sum()
    # The first of the others, sleepers before those that are off.
    order = np.lexsort((np.arange(len(code)), -code.astype(int), up))
    up[order[:missing]] = True
    numbers = np.flatnonzero(up)
    whole = len(numbers) == len(code)
    return replace(vol, awake=Awake(len(numbers), None if whole else own_numbers(numbers)))


def _length(needed: int, vol: ProbeVolume, s: Settings) -> int:
    """Of a list that has room for so many probes: the one before if it will do, else one of few lengths.

    What moves wakes probes and lets them sleep all the time.
    """
    step = max(1, vol.grid.size // (LENGTHS * ROUND)) * ROUND
    before = 0 if vol.awake.numbers is None or s.method == "ctu" else vol.awake.count
    if needed <= before < needed + 2 * step:
        return before
    step = step if before else ROUND
    return max(1, -(-needed // step)) * step


def _where(place, grid: ProbeGrid) -> np.ndarray:
    """`grid.place` or `grid.position` of all probes. (P, 3) [m]."""
    return np.array(place(dr.arange(mi.UInt32, grid.size)), np.float32).T


def _stand_ins(grid: ProbeGrid, gives_light: np.ndarray) -> np.ndarray:
    """For every probe the nearest that gives light, in steps from neighbour to neighbour. gives_light, result: (P,)."""
    number = np.where(gives_light, np.arange(grid.size), -1).reshape(grid.counts[::-1])
    while (number < 0).any():
        before = number.copy()
        for axis in range(3):
            for shift in (1, -1):
                near = np.roll(before, shift, axis)
                edge = [slice(None)] * 3
                edge[axis] = slice(0, 1) if shift > 0 else slice(-1, None)
                near[tuple(edge)] = -1  # nothing comes in from the other side
                number = np.where(number < 0, near, number)
        if (number == before).all():
            return np.arange(grid.size)  # none does
    return number.ravel()
