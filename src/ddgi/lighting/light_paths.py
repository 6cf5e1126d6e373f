"""Paths of light from point, spot and directional lights to the first surfaces they meet.

What a lamp shines at may be small and yet light a room; few rays of a probe find it. Paths from the lamp
land nowhere else. Both find the same light, so each is weighted by how densely it samples a place next to
the other (the balance heuristic; Veach 1997, 9.2): the mean stays what it was, and noise is little more than
that of the better of the two.

Paths are of no use where no probe sees them land: the sun on a roof. So a few are tried first, and a ray
from where they land tells whether there is anything that their light could reach next.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ddgi import sampling
from ddgi.extrema import at_least, clamp
from ddgi.lighting import lamp_cells
from ddgi.lighting.lamp_cells import BELOW_ONE, Disc
from ddgi.lighting.lights import DeltaLight, Lights, delta_light, from_delta
from ddgi.sampling import Clock
from ddgi.trace.surface import Surface, matt_bounce
from ddgi.trace.tracer import Tracer

TRIED = 4096
"""Paths tried in every update, of two rays each: 3 % of the rays of 2,048 probes."""
TRIED_PER_CELL = 16
DOUBT = 0.25
"""Of the paths tried in a cell, as many more count as of use: none is ever left out."""


@dataclass
class Aim:
    """How M paths are shared out between the cells of the lamps' squares (`lamp_cells`)."""

    count: int  # M
    side: int  # every lamp has side^2 cells
    disc: Disc
    chance: mi.Float  # (C,) of a path to leave through each cell; the sum is one
    before: mi.Float  # (C,) sum of the chances of the cells before


@dataclass
class Landed:
    """Where M paths met the first surface."""

    surface: Surface  # (M,)
    intensity: mi.Color3f  # (M,) reflected along the normal, of the lamp a path comes from [W/sr]
    density: mi.Float  # (M,) of all M paths there [1/m^2]; 0 where nothing is lit


def aim(tracer: Tracer, lights: Lights, disc: Disc, count: int, time: Clock) -> Aim:
    """Share out `count` paths between the lamps, after what those tried found.

    Args:
        tracer: Says where paths land.
        lights: At least one delta light.
        disc: Around the probes.
        count: How many paths there will be.
        time: Random source.
    """
    side = max(1, math.isqrt(TRIED // (TRIED_PER_CELL * lights.delta.count)))
    even = _shares(count, side, disc, _power_of_cells(lights, side, disc))
    lane = dr.arange(mi.UInt32, TRIED)
    # Numbers that have nothing in common with those of the paths sent: the mean would not be right.
    u = sampling.uniform_2d(time, sampling.LAMP_TRIAL, lane)
    cell, surface, _ = _sent(
        tracer, lights, even, mi.Point2f((mi.Float(lane) + u.x) / TRIED, u.y), time, sampling.LAMP_TRIAL
    )
    onward = sampling.uniform_2d(time, sampling.LAMP_TRIAL_ONWARD, lane)
    origin, direction = matt_bounce(surface, onward)
    met = 1 - tracer.visible(origin, direction, 2 * disc.radius, surface.lit)
    tried, of_use = (dr.zeros(mi.Float, dr.width(even.chance)) for _ in range(2))
    dr.scatter_reduce(dr.ReduceOp.Add, tried, mi.Float(1), cell)
    dr.scatter_reduce(dr.ReduceOp.Add, of_use, met, cell, surface.lit)
    return _shares(count, side, disc, even.chance * ((of_use + DOUBT) / (tried + DOUBT)))


def _shares(count: int, side: int, disc: Disc, weight: mi.Float) -> Aim:
    chance = weight / at_least(dr.sum(weight), 1e-30)
    dr.eval(chance)  # every ray's hit reads some of it
    return Aim(count, side, disc, chance, dr.prefix_sum(chance))


def _power_of_cells(lights: Lights, side: int, disc: Disc) -> mi.Float:
    """What to share out by before anything is known: luminous power [W]. (C,)."""
    cells = side * side
    lamp = dr.arange(mi.UInt32, lights.delta.count * cells) // cells
    return lamp_cells.power(delta_light(lights.delta, lamp), disc)


def density(row: DeltaLight, number: mi.UInt32, surface: Surface, by: Aim) -> mi.Float:
    """Paths of one lamp that land per area, of all M, were nothing in their way. (N,) [1/m^2].

    Args:
        row: The lamp, (1,) or (N,).
        number: Of the lamp.
        surface: (N,) where they land.
        by: How paths are shared out.
    """
    square, inside = lamp_cells.square_at(row, surface.position, by.disc)
    cells = by.side * by.side
    chance = dr.gather(mi.Float, by.chance, number * cells + lamp_cells.cell(square, by.side), inside)
    light = from_delta(row, surface.position)
    spread = dr.select(dr.isfinite(light.distance), dr.rcp(dr.square(light.distance)), 1)
    cosine = at_least(dr.dot(mi.Vector3f(surface.geometric_normal), light.direction), 0)
    return chance * (by.count * cells) * cosine * spread / lamp_cells.size(row, by.disc)


def land(tracer: Tracer, lights: Lights, by: Aim, time: Clock) -> Landed:
    """Send the paths out. Successive ones lie far apart, and so do those of successive updates."""
    point = time.tick * by.count + dr.arange(mi.UInt32, by.count)
    u = sampling.low_discrepancy_2d(time, sampling.LAMP_PATH, mi.UInt32(0), point)
    _, surface, number = _sent(tracer, lights, by, u, time, sampling.LAMP_PATH)
    row = delta_light(lights.delta, number)
    light = from_delta(row, surface.position)
    cosine = at_least(dr.dot(mi.Vector3f(surface.normal), light.direction), 0)
    there = density(row, number, surface, by)
    lit = surface.lit & (there > 0)
    intensity = surface.albedo * light.power * (cosine * dr.inv_pi) / at_least(there, 1e-30)
    out = Landed(surface, dr.select(lit, intensity, mi.Color3f(0)), dr.select(lit, there, 0))
    dr.eval(out)
    return out


def _sent(
    tracer: Tracer, lights: Lights, by: Aim, u: mi.Point2f, time: Clock, stream: int
) -> tuple[mi.UInt32, Surface, mi.UInt32]:
    """Cells that paths leave through, where they land, and the lamps they come from. u: (N,) in [0, 1)."""
    cell, place = _picked(by, u)
    number = cell // (by.side * by.side)
    square = lamp_cells.within(cell - number * (by.side * by.side), place, by.side)
    origin, direction = lamp_cells.leave(delta_light(lights.delta, number), square, by.disc, tracer.extent)
    surface = tracer.intersect(origin, direction, mi.Bool(True), time=time, stream=stream)
    return cell, surface, number


def _picked(by: Aim, u: mi.Point2f) -> tuple[mi.UInt32, mi.Point2f]:
    """Cells in proportion to their chances, and places in them.

    First one of all rows of cells, then one in the row: what fills the unit square evenly fills cells so.
    """
    side, none = by.side, mi.UInt32(0)
    row, down, height = _found(by.before, none, side, dr.width(by.chance) // side, u.x, mi.Float(1))
    start = dr.gather(mi.Float, by.before, row * side)
    column, across, _ = _found(by.before, row * side, 1, side, dr.fma(u.y, height, start), start + height)
    return row * side + column, mi.Point2f(across, down)


def _found(
    before: mi.Float, first: mi.UInt32, step: int, count: int, target: mi.Float, end: mi.Float
) -> tuple[mi.UInt32, mi.Float, mi.Float]:
    """Which of `count` intervals numbers lie in, how far through it, and how wide it is.

    Args:
        before: (C,) where intervals start; theirs are every `step`-th from `first` on.
        first: (N,).
        step: In `before`.
        count: Of intervals.
        target: (N,) the numbers.
        end: (N,) of the last interval.
    """
    number = mi.UInt32(0)
    for bit in reversed(range((count - 1).bit_length())):
        further = number + (1 << bit)
        there = further < count
        reached = dr.gather(mi.Float, before, first + further * step, there) <= target
        number = dr.select(there & reached, further, number)
    start = dr.gather(mi.Float, before, first + number * step)
    last = number == count - 1
    width = dr.select(last, end, dr.gather(mi.Float, before, first + (number + 1) * step, ~last)) - start
    return number, clamp((target - start) / at_least(width, 1e-30), 0, BELOW_ONE), width
