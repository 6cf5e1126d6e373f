"""Places to stand inside rooms.

What a room is, as rays see it: a level floor below, walls all around at the height of the eyes, a
ceiling perhaps. Walls may be single sheets, and some of them turned the wrong way; but from inside a
solid thing all is seen from behind, and that is how the inside of a statue differs from a hall.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi import sampling
from ddgi.scene.viewpoint.sight import Sight, see
from ddgi.scene.viewpoint.views import directions
from ddgi.trace.tracer import Tracer

AZIMUTHS, ELEVATIONS = 32, 12
"""Rays of a panorama."""
FAR = 6.0
"""What is further off than so many times the median extent of the shapes is sky."""
EYE = 0.6
"""Height of the eyes over that of the room."""
LOW, HIGH = 0.3, 0.75
"""Where that may come to lie, as the place itself sees its room: over a table it was first taken for another."""
LEVEL = 0.7
"""Least cosine between a floor's normal and up."""
WALLS, FLOOR, FRONT = 0.6, 0.6, 0.3
"""Least shares of the horizon that walls take, of the ground that is level, and of fronts."""
CLEAR = 0.12
"""Least distance to anything, over the height of the room."""


@dataclass(frozen=True)
class Places:
    """C places, and what rays see all around each."""

    position: np.ndarray  # (C, 3) [m]
    floor: np.ndarray  # (C,) its height above the place, so mostly negative [m]; NaN without one
    top: np.ndarray  # (C,) height of the ceiling, or of the walls without one
    roofed: np.ndarray  # (C,) bool
    walls: np.ndarray  # (C,) share of the horizon
    ground: np.ndarray  # (C,) share of what is below that is level
    fronts: np.ndarray  # (C,) share of what is met
    black: np.ndarray  # (C,) share of everything
    nearest: np.ndarray  # (C,) [m]
    width: np.ndarray  # (C,) of the room, from wall to wall through the place; median [m]

    def __getitem__(self, which: np.ndarray) -> Places:
        return Places(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    def __len__(self) -> int:
        return len(self.position)


def survey(tracer: Tracer, position: np.ndarray, up: np.ndarray, reach: float) -> Places:
    """Look all around from places.

    Args:
        tracer: The scene.
        position: (C, 3) [m].
        up: (3,) unit.
        reach: What is further off does not count [m].
    """
    elevation = np.radians((np.arange(ELEVATIONS) + 0.5) / ELEVATIONS * 180 - 90)
    azimuth = (np.arange(AZIMUTHS) + 0.5) / AZIMUTHS * 2 * np.pi
    direction = directions(elevation[:, None], azimuth, up)
    sight = see(tracer, position[:, None, None], direction)
    return _summary(position, sight, elevation, up, reach)


def _summary(
    position: np.ndarray, sight: Sight, elevation: np.ndarray, up: np.ndarray, reach: float
) -> Places:
    hit = sight.distance < reach
    height = (sight.position - position[:, None, None]) @ up
    level = hit & (np.abs(sight.normal @ up) > LEVEL)
    rise = np.degrees(elevation)[:, None]
    weight = np.broadcast_to(np.cos(elevation)[:, None], hit.shape)

    def share(what: np.ndarray, among: np.ndarray) -> np.ndarray:
        return (what * weight * among).sum((1, 2)) / np.maximum((weight * among).sum((1, 2)), 1e-9)

    roofed = share(hit, rise > 40) > 0.5
    ceiling = _quantile(height, level & (rise > 30), 0.5)
    walls = _quantile(height, hit & (rise > 0), 0.95)
    level_ray = np.minimum(sight.distance, reach)[:, ELEVATIONS // 2]
    across = level_ray[:, : AZIMUTHS // 2] + level_ray[:, AZIMUTHS // 2 :]
    return Places(
        position=position,
        floor=_quantile(height, level & (rise < -30), 0.2),
        top=np.where(roofed & np.isfinite(ceiling), ceiling, walls),
        roofed=roofed,
        walls=hit[:, ELEVATIONS // 2].mean(1),
        ground=share(level, rise < -40),
        fronts=share(sight.front, hit),
        black=share(sight.black, hit),
        nearest=sight.distance.min((1, 2)),
        width=np.median(across, axis=1),
    )


def candidates(tracer: Tracer, near: np.ndarray, up: np.ndarray, reach: float) -> Places:
    """Places at the height of eyes, as rays that start near the shapes find them. near: (N, 3) points [m]."""
    first = survey(tracer, _drifted(tracer, near, reach), up, reach)
    first = first[np.isfinite(first.floor + first.top) & (first.top > first.floor)]
    if not len(first):
        return first
    eye = first.floor + EYE * np.minimum(first.top - first.floor, 1.2 * first.width)
    return survey(tracer, first.position + eye[:, None] * up, up, reach)


def is_room(p: Places, fronts: float = FRONT) -> np.ndarray:
    """(C,) bool: whether somebody could stand at each place, with a room around.

    Args:
        p: The places.
        fronts: Least share of fronts among what is seen from there.
    """
    with np.errstate(invalid="ignore"):
        room = p.top - p.floor
        wide = p.roofed | (p.width > room)  # without a roof, what is taller than wide is a vessel
        return (
            (p.walls >= WALLS) & (p.ground >= FLOOR) & (p.fronts >= fronts) & (p.black < 0.5)
            & wide & (p.floor < -LOW * room) & (p.floor > -HIGH * room) & (p.nearest > CLEAR * room)
        )  # fmt: skip


def far_off(near: np.ndarray) -> float:
    """The distance beyond which everything is sky, given points near the shapes [m]."""
    return FAR * float(np.median(np.linalg.norm(near - np.median(near, axis=0), axis=1)))


def _drifted(tracer: Tracer, near: np.ndarray, reach: float) -> np.ndarray:
    """Points somewhere on the way from each point to the next surface in a random direction."""
    lane = dr.arange(mi.UInt32, len(near))
    time = sampling.clock(0, 1)
    to = mi.warp.square_to_uniform_sphere(sampling.uniform_2d(time, sampling.VIEWPOINT, lane))
    way = np.array(sampling.uniform_2d(time, sampling.VIEWPOINT, lane + len(near)).x, np.float64)
    direction = np.array(to, np.float64).T
    start = near + 1e-3 * reach / FAR * direction
    free = np.minimum(see(tracer, start, direction).distance, reach / FAR)
    return start + (way * free)[:, None] * direction


def _quantile(values: np.ndarray, among: np.ndarray, share: float) -> np.ndarray:
    """(C,) of the values (C, ...) that count; NaN where none does."""
    rows = np.sort(np.where(among, values, np.inf).reshape(len(values), -1), axis=1)
    count = among.reshape(len(values), -1).sum(1)
    picked = rows[np.arange(len(rows)), (share * np.maximum(count - 1, 0)).astype(int)]
    return np.where(count > 0, picked, np.nan)
