"""Where the light is that a picture shows: the box to lay probes over when nobody names one.

The bounding box says little: a room may lie in a dome of sky a hundred metres wide. What counts is
where light goes on its way to the cameras, so paths are traced back from them, and the box is drawn
around the surfaces they meet. A few paths end far away, through a window say: from the middle
outwards, the box grows to the next share of the light only while that share lies close together. Where
it then ends a little beyond a wall, it is laid at the wall: planes of probes between there and the
wall would light next to nothing, and stand where they see what is behind it. And where it ends in the
middle of a room, because hardly any path goes there, it is drawn to the end of the room: light that
the paths miss may stand there, and all that it sheds on the walls around it would be lost. Behind a
wall with a door to another room it goes on for about a plane of probes, which have that room's light.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi import sampling
from ddgi.box import Box
from ddgi.probes.walls import STRAIGHT
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
EVEN = 1 / 256
"""Ends lie at multiples of a step, at most that much of the box around all but its outer light: a single path more or
less, as of the same scene in other units, then moves none.
"""
SLIVER = 0.1
"""How far beyond a wall the box is cut back to it, in lengths of the box along that axis."""
SAME_WALL = 1e-3
"""How far apart surfaces of one wall may lie, likewise."""
REACH = 2.0
"""How far the end of a room may lie beyond the box, in lengths of the box's longest side: no dome of sky."""
AHEAD = 4096
"""Rays that look for it, on each side."""
DOOR = 0.005
"""Share of rays through a side that must pass the wall there for it to have an opening."""
BEHIND = 0.1
"""How far the box goes on behind one, in edges of a cube of its volume: more than a spacing of 2,048 probes."""


@dataclass
class Seen:
    """Surfaces on the paths that light takes to some cameras."""

    position: np.ndarray  # (N, 3) [m]
    normal: np.ndarray  # (N, 3) unit, on the side that was seen
    weight: np.ndarray  # (N,) share of the picture's light that may come from there; 0: nothing was met


def look(tracer: Tracer, cameras: Sequence[Camera]) -> Seen:
    """What paths traced back from cameras meet. There is one at least, and they count alike."""
    found = [_walk(tracer, camera, number) for number, camera in enumerate(cameras)]
    position, normal = (np.concatenate([f[i] for f in found]) for i in range(2))
    return Seen(position, normal, np.concatenate([w / max(w.sum(), 1e-30) for *_, w in found]))


def find(tracer: Tracer, seen: Seen, bounds: Box) -> Box:
    """The box around what lights the pictures of some cameras [m].

    Args:
        tracer: The scene.
        seen: What those cameras see.
        bounds: The box around all geometry; what is found never reaches beyond it, and where cameras
            see nothing it is taken as it is.
    """
    position, normal, weight = seen.position, seen.normal, seen.weight
    if not weight.any():
        return bounds
    longest = float(np.max(np.subtract(bounds[1], bounds[0])))
    sides = []
    for a in range(3):
        ends = _evened(_grown(position[:, a], weight), bounds[0][a], longest)
        sides.append(_trimmed(*ends, position[:, a], normal[:, a], weight))
    low, high = _completed(tracer, np.array(sides))
    low, high = np.maximum(low, bounds[0]), np.minimum(high, bounds[1])
    return (float(low[0]), float(low[1]), float(low[2])), (float(high[0]), float(high[1]), float(high[2]))


def _walk(tracer: Tracer, camera: Camera, number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where paths from a camera meet surfaces, their normals, (N, 3), and what share of its light each may carry."""
    time = sampling.clock(0, number)
    lane = dr.arange(mi.UInt32, PATHS)
    start = sampling.uniform_2d(time, sampling.REGION, lane)
    width, height = camera.size
    # Anywhere in the picture, whatever its pixels: two sizes of it get the same volume.
    column, row = mi.UInt32(start.x * width), mi.UInt32(start.y * height)
    within = mi.Point2f(start.x * width - column, start.y * height - row)
    origin, direction = camera_rays(camera, tracer.origin, row * width + column, within)
    throughput, active = mi.Float(1), mi.Bool(True)
    places, normals, weights = [], [], []
    for bounce in range(BOUNCES):
        surface = tracer.intersect(origin, direction, active, time=time, stream=sampling.REGION)
        active = active & surface.lit
        met = dr.select(active, surface.position, mi.Point3f(0)), dr.select(active, throughput, 0)
        normal, throughput = surface.geometric_normal, throughput * mi.luminance(surface.albedo)
        onward = sampling.uniform_2d(time, sampling.REGION, lane + (1 + bounce) * PATHS)
        origin, direction = matt_bounce(surface, onward)
        # Once: each by itself would trace the ray again.
        dr.eval(met, normal, throughput, origin, direction, active)
        places.append(np.array(met[0]).T)
        normals.append(np.array(normal).T)
        weights.append(np.array(met[1]))
    weight = np.concatenate([np.broadcast_to(w, PATHS) for w in weights])
    return np.concatenate(places), np.concatenate(normals), weight


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


def _evened(ends: tuple[float, float], start: float, longest: float) -> tuple[float, float]:
    """Both ends of the box along an axis, moved out to even places, which depend on the scene as a whole.

    Args:
        ends: Low and high [m].
        start: Where the scene begins along the axis [m].
        longest: Its longest side [m]; steps are a whole power of two of it.
    """
    low, high = ends
    if not 0 < high - low <= longest:
        return ends
    step = longest * 2.0 ** np.floor(np.log2(EVEN * (high - low) / longest))
    return (
        start + step * float(np.floor((low - start) / step)),
        start + step * float(np.ceil((high - start) / step)),
    )


def _trimmed(
    low: float, high: float, place: np.ndarray, normal: np.ndarray, weight: np.ndarray
) -> tuple[float, float]:
    """Both ends of the box along an axis, cut back to walls that face in just before them.

    Args:
        low: The low end [m].
        high: The high end.
        place: (N,) coordinates of what paths meet [m].
        normal: (N,) along the axis.
        weight: (N,) what it counts.
    """
    length = high - low
    wall_low, wall_high = (
        sign * _wall(sign * place, sign * normal, weight, sign * end, length)
        for sign, end in ((1, low), (-1, high))
    )
    return wall_low, wall_high


def _wall(place: np.ndarray, normal: np.ndarray, weight: np.ndarray, end: float, length: float) -> float:
    """Where the wall stands that counts most just above a low end; the end if what lies between counts more."""
    step = max(SAME_WALL * length, 1e-30)
    near = (weight > 0) & (normal > STRAIGHT) & (place >= end) & (place <= end + SLIVER * length)
    if not near.any():
        return end
    bins = ((place[near] - end) / step).astype(int)
    strength = np.bincount(bins, weight[near])
    wall = float(place[near][bins == strength.argmax()].min())
    return wall if strength.max() > weight[(place >= end) & (place < wall)].sum() else end


def _completed(tracer: Tracer, sides: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both corners, (3,), of a box whose sides are moved out to the ends of the rooms they cut through.

    Args:
        tracer: The scene.
        sides: (3, 2) low and high end along each axis [m].
    """
    length = sides[:, 1] - sides[:, 0]
    furthest, behind = REACH * length.max(), BEHIND * np.prod(length) ** (1 / 3)
    out = sides.copy()
    for axis in range(3):
        for end, sign in enumerate((-1, 1)):
            out[axis, end] += sign * _further(_ahead(tracer, sides, axis, sign), furthest, behind)
    return out[:, 0], out[:, 1]


def _further(ahead: np.ndarray, furthest: float, behind: float) -> float:
    """How far a side moves out [m].

    Args:
        ahead: (N,) how far beyond the side rays end that leave through it [m]; infinite where they meet nothing.
        furthest: Where the end of a room may lie at most.
        behind: How far to go on behind a wall with an opening.
    """
    wall = float(np.median(ahead))
    if not wall <= furthest:
        return 0.0
    wall = max(wall, 0.0)
    passing = ahead > wall + SAME_WALL * furthest
    inside = passing & (ahead <= furthest)  # a room, and not the open
    if inside.sum() < max(DOOR * len(ahead), passing.sum() / 2):
        return wall
    return wall + min(behind, float(np.median(ahead[inside])) - wall)


def _ahead(tracer: Tracer, sides: np.ndarray, axis: int, sign: int) -> np.ndarray:
    """How far beyond the low (-1) or high (1) side of a box rays end that leave through it, straight ahead [m]."""
    time, lane = sampling.clock(0, 0), dr.arange(mi.UInt32, AHEAD)
    first, second = (sampling.uniform_2d(time, sampling.REGION, lane + k * AHEAD) for k in range(2))
    share = np.array([first.x, first.y, second.x])
    inside = SLIVER * share[axis]  # from close to the side: what rays meet then belongs to what lies there
    share[axis] = inside if sign < 0 else 1 - inside
    low, high = sides.T
    origin = low + share.T * (high - low)
    direction = mi.Vector3f([float(sign * (a == axis)) for a in range(3)])
    seen = tracer.intersect(mi.Point3f(origin.T), direction, mi.Bool(True), time=time, stream=sampling.REGION)
    ahead: np.ndarray = np.array(dr.select(seen.valid, seen.distance, dr.inf)) - inside * (high - low)[axis]
    return ahead
