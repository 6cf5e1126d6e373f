"""Openness: how much room there is around a place, for every way that a surface there could face.

The mean of d / (d + nearby) over a hemisphere, by cosine, where d is how far a ray gets: what ambient
obscurance is to light that comes from everywhere. The light itself is not known when probes are placed,
but where probes have as much room ahead as the surfaces that read them, they see much the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi import sampling
from ddgi.extrema import at_least, at_most
from ddgi.probes.directions import fibonacci, picked
from ddgi.trace.tracer import Tracer

RAYS = 32
"""From every place, in all directions, the same from each."""


@dataclass
class Openness:
    """How open N places are."""

    facing: mi.Float  # (6 N,) towards +x, -x, +y, -y, +z and -z, in [0, 1]; number = place * 6 + side
    nearest: mi.Float  # (N,) distance of the nearest surface that a ray met [m]

    def along(self, place: mi.UInt32, normal: mi.Vector3f) -> mi.Float:
        """Openness of places towards a unit normal, between those of its axes. (M,) each."""
        total = mi.Float(0)
        for axis in range(3):
            side = dr.select(normal[axis] < 0, mi.UInt32(2 * axis + 1), mi.UInt32(2 * axis))
            total += dr.square(normal[axis]) * dr.gather(mi.Float, self.facing, place * 6 + side)
        return total


def of_places(tracer: Tracer, position: mi.Point3f, nearby: float) -> Openness:
    """Look around.

    Args:
        tracer: The scene.
        position: (N,) [m].
        nearby: Surfaces at that distance take half of the room [m].
    """
    directions = fibonacci(RAYS)
    dr.eval(directions)
    distance = _distances(tracer, position, directions)
    room = distance / (distance + nearby)
    nearest = dr.block_reduce(dr.ReduceOp.Min, distance, RAYS)
    ray = dr.arange(mi.UInt32, dr.width(distance)) % RAYS
    facing = dr.empty(mi.Float, 6 * dr.width(position))
    place = dr.arange(mi.UInt32, dr.width(position)) * 6
    for axis in range(3):
        for side, sign in enumerate((1, -1)):
            share = _shares(sign * np.array(directions[axis]))
            mean = dr.block_sum(room * dr.gather(mi.Float, mi.Float(share), ray), RAYS)
            dr.scatter(facing, mean, place + (2 * axis + side), mode=dr.ReduceMode.Permute)
    dr.eval(facing, nearest)
    return Openness(facing, nearest)


def of_surfaces(tracer: Tracer, start: mi.Point3f, normal: mi.Vector3f, nearby: float) -> mi.Float:
    """Openness of points on surfaces, the way that they face. (N,).

    Args:
        tracer: The scene.
        start: (N,) just above the surfaces [m].
        normal: (N,) unit.
        nearby: As of places [m].
    """
    directions = fibonacci(RAYS)
    dr.eval(directions)
    distance = _distances(tracer, start, directions)
    lane = dr.arange(mi.UInt32, dr.width(distance))
    facing = dr.gather(mi.Vector3f, normal, lane // RAYS)
    cosine = at_least(dr.dot(facing, picked(directions, lane % RAYS)), 0)
    room = dr.block_sum(cosine * distance / (distance + nearby), RAYS)
    return room / at_least(dr.block_sum(cosine, RAYS), 1e-6)


def _shares(cosine: np.ndarray) -> np.ndarray:
    """What each direction counts in a mean by cosine. (R,)."""
    above = np.maximum(cosine, 0)
    share: np.ndarray = above / above.sum()
    return share


def _distances(tracer: Tracer, position: mi.Point3f, directions: mi.Vector3f) -> mi.Float:
    """How far rays get, number = place * R + ray; what meets nothing gets very far. (R N,) [m]."""
    lane = dr.arange(mi.UInt32, dr.width(position) * RAYS)
    surface = tracer.intersect(
        dr.gather(mi.Point3f, position, lane // RAYS), picked(directions, lane % RAYS), mi.Bool(True),
        time=sampling.clock(0, 0), stream=sampling.PLACEMENT,
    )  # fmt: skip
    return at_most(surface.distance, tracer.extent * 1e6)
