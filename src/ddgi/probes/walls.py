"""Fit the planes of a grid to the axis-aligned walls of a scene.

How well a wall is lit depends on where the planes of probes parallel to it stand. A plane just in
front of it sees what the wall sees; half a cell away, corners turn too bright; a plane in the wall
itself looks out on both sides and leaks. The walls are found with rays, as probes would see them:
that needs neither closed nor consistently oriented geometry.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi import sampling
from ddgi.trace.tracer import Tracer

RAYS = 32768
STRAIGHT = 0.9999
"""Least cosine between a normal and an axis for a wall to count as aligned."""

# Error of a picture by the distance of the first plane in front of a wall, in spacings: mean FLIP of
# `cornell-point` with that distance at all its walls. Measured, but for 0.03 and 0.97, which are guesses
# that keep planes out of the wall itself; only 0.1, 0.55 and 1 were measured again with the final code.
_PLACE = np.array([0.00, 0.03, 0.05, 0.10, 0.20, 0.30, 0.40, 0.55, 0.70, 0.90, 0.97, 1.00])
_ERROR = np.array([0.53, 0.10, 0.057, 0.056, 0.063, 0.068, 0.077, 0.096, 0.11, 0.14, 0.20, 0.53])

_MARGINS = np.linspace(-0.4, 0.5, 46)
"""Margins to try on each side of an axis, in spacings."""


@dataclass
class Walls:
    """The walls across one axis."""

    place: np.ndarray  # (W,) coordinate [m]
    facing: np.ndarray  # (W,) +1 or -1: the side they were seen from
    share: np.ndarray  # (W,) how much was seen of them; sums to one


def find(tracer: Tracer, box: tuple[tuple[float, ...], tuple[float, ...]]) -> list[Walls]:
    """The axis-aligned walls that random points in a box see, for x, y and z."""
    time = sampling.clock(0, 0)
    lane = dr.arange(mi.UInt32, RAYS)
    uniform = [sampling.uniform_2d(time, sampling.WALLS, lane * 3 + k) for k in range(3)]
    low, high = mi.Point3f(box[0]), mi.Point3f(box[1])
    origin = low + mi.Vector3f(uniform[0].x, uniform[0].y, uniform[1].x) * (high - low)
    direction = mi.warp.square_to_uniform_sphere(uniform[2])
    seen = tracer.intersect(origin, direction, mi.Bool(True), time=time, stream=sampling.WALLS)
    position, normal = np.array(seen.position).T, np.array(seen.geometric_normal).T
    return among(position, normal, np.array(seen.lit, np.float64), box)


def among(
    position: np.ndarray,
    normal: np.ndarray,
    weight: np.ndarray,
    box: tuple[tuple[float, ...], tuple[float, ...]],
) -> list[Walls]:
    """The axis-aligned walls among surfaces, for x, y and z.

    Args:
        position: (N, 3) places on them [m].
        normal: (N, 3) unit, on the side that counts.
        weight: (N,) how much each counts.
        box: What they are walls of [m].
    """
    some = weight > 0
    position, normal, weight = position[some], normal[some], weight[some]
    return [_across(position[:, a], normal[:, a], weight, box[0][a], box[1][a]) for a in range(3)]


def _across(place: np.ndarray, cosine: np.ndarray, weight: np.ndarray, low: float, high: float) -> Walls:
    """Gather hits into walls: those of one facing within a thousandth of the box are one."""
    aligned = (
        (np.abs(cosine) > STRAIGHT)
        & (place >= low - 1e-3 * (high - low))
        & (place <= high + 1e-3 * (high - low))
    )
    step = max(high - low, 1e-9) * 1e-3
    keys = np.stack([np.round(place[aligned] / step), np.sign(cosine[aligned])], 1)
    walls, index = np.unique(keys, axis=0, return_inverse=True)
    total, sums = (
        np.bincount(index.ravel(), w, len(walls)) for w in (weight[aligned], (weight * place)[aligned])
    )
    return Walls(sums / np.maximum(total, 1e-300), walls[:, 1], total / max(total.sum(), 1e-300))


def best_margins(walls: Walls, low: float, high: float, count: int) -> tuple[float, float]:
    """How far beyond the box `count` planes should reach, in spacings, below and above.

    Searches margins from -0.4 to 0.5 on either side for the least expected error, the mean of the
    measured error over all walls. Without walls: -0.1, just inside the box, on both sides.
    """
    if len(walls.place) == 0:
        return -0.1, -0.1
    below, above = np.meshgrid(_MARGINS, _MARGINS, indexing="ij")
    cells = np.maximum(count - 1 - below - above, 0.5)
    spacing = (high - low) / cells
    first = low - below * spacing
    # Distance from each wall to the first plane in front of it, in spacings.
    ahead = (first[..., None] - walls.place) * walls.facing / spacing[..., None]
    error = (np.interp(ahead - np.floor(ahead), _PLACE, _ERROR) * walls.share).sum(-1)
    error += 1e-3 * (spacing - spacing.min()) / spacing.min()  # of equals, the densest
    best = np.unravel_index(np.argmin(error), error.shape)
    return float(below[best]), float(above[best])
