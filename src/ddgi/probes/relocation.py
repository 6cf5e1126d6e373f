"""Relocation: probes leave the places that the grid gives them for better ones nearby.

As published, SCALE 5 moves a probe that sees many back faces through the nearest of them, and one close
to a front away from it; MFF 3.3.1 tries places along the axes of the grid, and knows of the geometry only
whether a probe is inside. Both trust that surfaces face outwards. Ours does not: `placement.py`.

Only what stands still moves probes, so they are placed when the field is fitted, and again when it is asked for
(`IrradianceField.relocate`).
"""

from __future__ import annotations

from typing import Annotated, Literal

import drjit as dr
import mitsuba as mi
import numpy as np
from annotated_types import Interval
from typing_extensions import Doc

from ddgi import sampling
from ddgi.probes import placement
from ddgi.probes.grid import ProbeGrid
from ddgi.probes.region import Seen
from ddgi.probes.surroundings import Surroundings, look_around
from ddgi.settings_group import settings_group
from ddgi.trace.tracer import Tracer


@settings_group("relocation")
class Settings:
    """Where probes go whose places are bad."""

    method: Annotated[
        Literal["receivers", "scale", "mff", "off"],
        Doc(
            "to where surfaces that light reaches see them and have as much room ahead; out of what they see from behind, and away from near fronts "
            "(SCALE 5); along the axes until they are out (MFF 3.3.1); or nowhere"
        ),
    ] = "receivers"
    limit: Annotated[
        float,
        Interval(gt=0, lt=0.5),
        Doc("farthest move along each axis [spacings]; below a half, so that none crosses to a neighbour"),
    ] = 0.45
    clearance: Annotated[
        float,
        Interval(ge=0, le=1),
        Doc("surfaces closer to a probe than that are too near, in the smallest spacing"),
    ] = 0.05
    iterations: Annotated[
        int, Interval(ge=1, le=1024), Doc("how often each probe may move; 5 in SCALE, one a frame in MFF")
    ] = 2
    rays: Annotated[
        int, Interval(ge=6, le=4096), Doc("rays by which scale and mff look around, per probe and iteration")
    ] = 64
    certainty_hysteresis: Annotated[
        float,
        Interval(ge=0, lt=1),
        Doc("mff: share of the old certainty that a probe is dead which stays at each iteration (MFF 3.4)"),
    ] = 0.5
    rejects: Annotated[
        float,
        Interval(ge=0, le=1),
        Doc(
            "a probe that `IrradianceField.relocate` moves farther than that, along any axis, keeps nothing of what it gathered where it stood [spacings]"
        ),
    ] = 0.05


INSIDE = 0.25
"""Share of back faces above which a probe is taken to be inside something (SCALE listing 4)."""
OVERSHOOT = 2.0
"""How far a probe is moved through the nearest back face at most, in distances to it (SCALE listing 4)."""
AWAY = 0.2
"""How far it is moved from a front at a time, in smallest spacings; SCALE listing 4 has 0.2, without a unit."""
ONE_SURFACE = 0.5
"""Cosine between the nearest and the farthest front above which they are one surface (SCALE listing 4)."""
MOSTLY_INSIDE = 0.5
"""Share of back faces above which a probe is dead (MFF 3.3.1)."""
CERTAIN = 0.5
"""Certainty above which a dead probe moves on: more likely dead than not."""
RINGS = 4
"""Places that MFF's search has along each of the six directions, up to the limit."""
JUST = 0.999
"""Share of a limit that is below it."""


def relocate(tracer: Tracer, grid: ProbeGrid, seen: Seen, s: Settings) -> ProbeGrid:
    """The grid with its probes where they are to stand.

    Args:
        tracer: The scene.
        grid: Of probes in their places.
        seen: Surfaces that light reaches on its way to the cameras (`region.look`).
        s: How.
    """
    if s.method == "off":
        return grid
    spacing = np.ravel(grid.spacing).astype(float)
    if s.method == "receivers":
        clearance = s.clearance * spacing.min()
        return grid.moved_by(placement.place(tracer, grid, seen, s.limit, clearance, s.iterations))
    place = np.array(grid.place(dr.arange(mi.UInt32, grid.size)), float).T
    return grid.moved_by({"scale": _scale, "mff": _mff}[s.method](tracer, place, spacing, s))


def _scale(tracer: Tracer, place: np.ndarray, spacing: np.ndarray, s: Settings) -> np.ndarray:
    """Offsets after SCALE 5, its prose. place: (P, 3) [m]; spacing: (3,) [m]; result: (P, 3) [m]."""
    offset, limit, unit = np.zeros_like(place), s.limit * spacing, spacing.min()
    for _ in range(s.iterations):
        around = look_around(tracer, place + offset, s.rays)
        out, away = _through(around, offset, limit), _away(around, offset, s.clearance * unit, AWAY * unit)
        wanted = np.where((around.behind > INSIDE)[:, None], out, away)
        fits = (np.abs(wanted) < limit).all(-1, keepdims=True)
        offset = np.where(fits, wanted, offset)
    return offset


def _through(around: Surroundings, offset: np.ndarray, limit: np.ndarray) -> np.ndarray:
    """Offsets through the nearest back face, as far beyond it as it is away or the limit lets them."""
    direction, distance = around.nearest(back=True)
    step = direction * np.where(np.isfinite(distance), distance, 0)[:, None]
    # The largest factor that keeps each axis below the limit.
    with np.errstate(divide="ignore", invalid="ignore"):
        room = (np.sign(step) * limit - offset) / step
    factor = np.minimum(OVERSHOOT, np.where(step != 0, room * JUST, np.inf).min(-1))
    return offset + step * np.where(factor > 1, factor, 0)[:, None]


def _away(around: Surroundings, offset: np.ndarray, clearance: float, most: float) -> np.ndarray:
    """Offsets away from fronts that are too near, towards the farthest."""
    near, distance = around.nearest(back=False)
    far, length = around.farthest_front()
    moves = (distance < clearance) & ((near * far).sum(-1) <= ONE_SURFACE) & (length > 0)
    return offset + far * np.where(moves, np.minimum(most, length), 0)[:, None]


def _mff(tracer: Tracer, place: np.ndarray, spacing: np.ndarray, s: Settings) -> np.ndarray:
    """Offsets after MFF 3.3.1; arguments as of `_scale`.

    A probe that is dead with certainty goes to the next place of its search, and stays where it lives.
    """
    steps = _search(s.limit * spacing)
    number, certainty = np.zeros(len(place), int), np.zeros(len(place))
    for turn in range(s.iterations):
        around = look_around(tracer, place + steps[number], s.rays, sampling.clock(0, turn))
        close = around.distance.min(0) < s.clearance * spacing.min()
        dead = (around.behind > MOSTLY_INSIDE) | close
        certainty = certainty * s.certainty_hysteresis + dead * (1 - s.certainty_hysteresis)
        moves = certainty > CERTAIN
        number, certainty = np.where(moves, (number + 1) % len(steps), number), np.where(moves, 0, certainty)
    return steps[number]


def _search(limit: np.ndarray) -> np.ndarray:
    """Where a dead probe looks for a place, in turn: its own, then along the axes, ever farther. (N, 3) [m]."""
    axes = np.concatenate([np.eye(3), -np.eye(3)]) * limit * JUST
    return np.concatenate([np.zeros((1, 3)), *(axes * ring / RINGS for ring in range(1, RINGS + 1))])
