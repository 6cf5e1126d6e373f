"""What stands around probes: how far away, and which side of it, in a set of directions."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi import sampling
from ddgi.probes.directions import fibonacci, picked, random_rotation
from ddgi.sampling import Clock
from ddgi.trace.tracer import Tracer

AT_ONCE = 1 << 22
"""Rays traced together."""


@dataclass
class Surroundings:
    """What R rays from each of P probes met."""

    directions: np.ndarray  # (R, 3) unit
    distance: np.ndarray  # (R, P) [m]; infinite where nothing was met
    back: np.ndarray  # (R, P) bool: a surface seen from behind
    lit: np.ndarray  # (R, P) bool: a surface that can reflect light, from this side

    @property
    def behind(self) -> np.ndarray:
        """Share of rays that met surfaces from behind, in [0, 1]. (P,)."""
        share: np.ndarray = self.back.mean(0)
        return share

    def nearest(self, back: bool) -> tuple[np.ndarray, np.ndarray]:
        """Direction, (P, 3), and distance, (P,), of the nearest back or front; infinite if there is none."""
        distance = np.where(self.back == back, self.distance, np.inf)
        ray = distance.argmin(0)
        return self.directions[ray], np.take_along_axis(distance, ray[None], 0)[0]

    def farthest_front(self) -> tuple[np.ndarray, np.ndarray]:
        """Direction, (P, 3), and distance, (P,), of the farthest front; a miss is infinitely far."""
        distance = np.where(self.back, -np.inf, self.distance)
        ray = distance.argmax(0)
        return self.directions[ray], np.take_along_axis(distance, ray[None], 0)[0]


def look_around(tracer: Tracer, position: np.ndarray, rays: int, turn: Clock | None = None) -> Surroundings:
    """Trace rays from points, all in the same directions.

    Args:
        tracer: The scene.
        position: (P, 3) [m].
        rays: How many from each, R.
        turn: Turns the directions at random; None: they are always the same.
    """
    directions = fibonacci(rays)
    if turn is not None:
        directions = random_rotation(turn) @ directions
    dr.eval(directions)
    chunk = max(1, AT_ONCE // rays)
    parts = [_look(tracer, position[i : i + chunk], directions, rays) for i in range(0, len(position), chunk)]
    distance, back, lit = (np.concatenate([part[i] for part in parts], axis=1) for i in range(3))
    return Surroundings(np.array(directions).T, distance, back, lit)


def _look(tracer: Tracer, position: np.ndarray, directions: mi.Vector3f, rays: int):
    count = len(position)
    lane = dr.arange(mi.UInt32, rays * count)
    ray = lane // count
    start = dr.gather(mi.Point3f, mi.Point3f(position.T), lane - ray * count)
    surface = tracer.intersect(
        start, picked(directions, ray), mi.Bool(True), time=sampling.clock(0, 0), stream=sampling.PLACEMENT,
        coherent=True,
    )  # fmt: skip
    back, lit = surface.valid & ~surface.front, surface.lit
    dr.eval(surface.distance, back, lit)
    return tuple(np.array(x).reshape(rays, count) for x in (surface.distance, back, lit))
