"""Probes as small spheres in the picture, where they stand."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ddgi.extrema import at_least
from ddgi.probes.grid import ProbeGrid

RADIUS = 0.1
"""Of a sphere, in smallest spacings."""


@dataclass
class Hits:
    """The nearest sphere that each of N rays meets."""

    distance: mi.Float  # (N,) [m]; infinite if there is none
    probe: mi.UInt32  # (N,) its number
    normal: mi.Vector3f  # (N,) unit, there


def meet(
    grid: ProbeGrid,
    origin: mi.Point3f,
    direction: mi.Vector3f,
    radius: float = RADIUS,
    *,
    places: bool = False,
) -> Hits:
    """What rays meet of the probes.

    Args:
        grid: Of the probes.
        origin: (N,) where rays start [m].
        direction: (N,) unit.
        radius: Of the spheres [smallest spacings].
        places: They are in the places of the grid, and not where the probes stand.
    """
    width, size = dr.width(direction), grid.size
    squared = dr.square(grid.smallest_spacing * radius)
    stands = grid.place if places else grid.position

    def nearer(number, distance, probe):
        way = stands(number) - origin
        ahead = dr.dot(way, direction)
        inside = squared - (dr.squared_norm(way) - dr.square(ahead))
        found = ahead - dr.sqrt(at_least(inside, 0))
        hit = (inside > 0) & (found > 0) & (found < distance)
        return number + 1, dr.select(hit, found, distance), dr.select(hit, number, probe)

    start = mi.UInt32(0), dr.full(mi.Float, dr.inf, width), dr.zeros(mi.UInt32, width)
    _, distance, probe = dr.while_loop(start, lambda number, *_: number < size, nearer, label="probes")
    met = dr.isfinite(distance)
    at = dr.fma(direction, dr.select(met, distance, 0), origin)
    normal = dr.select(met, dr.normalize(at - stands(probe)), mi.Vector3f(0, 0, 1))
    return Hits(distance, probe, normal)
