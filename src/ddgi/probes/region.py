"""Where the light is that a picture shows: the box to lay probes over when nobody names one.

The bounding box says little: a room may lie in a dome of sky a hundred metres wide. What counts is
where light goes on its way to the cameras, so paths are traced back from them, and the box is drawn
around the surfaces they meet. A few paths end far away, through a window say: from the middle
outwards, the box grows to the next share of the light only while that share lies close together.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi import sampling
from ddgi.box import Box
from ddgi.scene.camera import Camera, camera_rays
from ddgi.trace.surface import matt_bounce
from ddgi.trace.tracer import Tracer

PATHS = 32768
"""Of every camera."""
BOUNCES = 4
"""Surfaces that a path meets: by then it has been wherever much light comes from."""
SHARES = (0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
"""Shares of the light left out at either end of an axis, from the first box to the largest."""
THIN = 0.07
"""Light thinner than this, against the mean of the first box, ends the growth of a side.

Measured: from 0.1 upwards beyond doors and in corridors that light comes through, 0.06 and less
outside the windows of `classroom`, `dream-apartment` and `house`.
"""


def find(tracer: Tracer, cameras: Sequence[Camera], bounds: Box) -> Box:
    """The box around what lights the pictures of some cameras [m].

    Args:
        tracer: The scene.
        cameras: At least one. They count alike.
        bounds: The box around all geometry; what is found never reaches beyond it, and where cameras
            see nothing it is taken as it is.
    """
    found = [_walk(tracer, camera, number) for number, camera in enumerate(cameras)]
    position = np.concatenate([p for p, _ in found])
    weight = np.concatenate([w / max(w.sum(), 1e-30) for _, w in found])
    if not weight.any():
        return bounds
    sides = [_grown(position[:, a], weight) for a in range(3)]
    low = [max(side[0], b) for side, b in zip(sides, bounds[0], strict=True)]
    high = [min(side[1], b) for side, b in zip(sides, bounds[1], strict=True)]
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


def _walk(tracer: Tracer, camera: Camera, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Where paths from a camera meet surfaces, (N, 3), and how much of the picture's light came over each."""
    time = sampling.clock(0, number)
    lane = dr.arange(mi.UInt32, PATHS)
    start = sampling.uniform_2d(time, sampling.REGION, lane)
    width, height = camera.size
    pixel = mi.UInt32(start.x * (width * height))
    origin, direction = camera_rays(
        camera, tracer.origin, pixel, sampling.uniform_2d(time, sampling.REGION, lane + PATHS)
    )
    throughput, active = mi.Float(1), mi.Bool(True)
    places, weights = [], []
    for bounce in range(BOUNCES):
        surface = tracer.intersect(origin, direction, active, time=time, stream=sampling.REGION)
        active = active & surface.lit
        places.append(np.array(dr.select(active, surface.position, mi.Point3f(0))).T)
        weights.append(np.array(dr.select(active, throughput, 0)))
        throughput = throughput * mi.luminance(surface.albedo)
        onward = sampling.uniform_2d(time, sampling.REGION, lane + (2 + bounce) * PATHS)
        origin, direction = matt_bounce(surface, onward)
    return np.concatenate(places), np.concatenate([np.broadcast_to(w, PATHS) for w in weights])


def _grown(place: np.ndarray, weight: np.ndarray) -> tuple[float, float]:
    """Both ends of the box along an axis."""
    order = np.argsort(place)
    place, total = place[order], np.cumsum(weight[order])
    low, high = (_side(place, total, sign) for sign in (-1, 1))
    return low, high


def _side(place: np.ndarray, total: np.ndarray, sign: int) -> float:
    """The low (-1) or high (1) end."""

    def at(share: float) -> float:
        part = share if sign < 0 else 1 - share
        return float(place[min(np.searchsorted(total, part * total[-1]), len(place) - 1)])

    first = abs(at(1 - SHARES[0]) - at(SHARES[0]))
    longest = first / (1 - 2 * SHARES[0]) / THIN  # for light that is just thick enough, per share
    end = at(SHARES[0])
    for before, share in pairwise(SHARES):
        if abs(at(share) - end) > (before - share) * longest:
            break
        end = at(share)
    return end
