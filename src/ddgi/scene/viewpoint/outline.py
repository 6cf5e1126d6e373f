"""The points that geometry reaches: what has to fit into a picture, and near what there is something to see."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi import sampling

CURVED = ("Sphere", "Disk", "Cylinder")
ON_CURVED = 2048
"""Points that stand for a sphere, a disk or a cylinder."""
BACKDROP = 5.0
"""A ground or dome this many times as wide as all that stands on or in it is no part of the object."""
FLAT = 0.1
"""Height of a ground over its width, at most."""


def outlines(shapes: Iterable[mi.Shape]) -> list[np.ndarray]:
    """(V, 3) points of each shape [m]: vertices, places on curved shapes, corners around instances."""
    return [points for points in map(_points, shapes) if len(points)]


def without_backdrop(shapes: Sequence[np.ndarray], up: np.ndarray) -> np.ndarray:
    """(V, 3) the points of all shapes but of grounds and domes that reach far beyond the rest.

    Args:
        shapes: (V, 3) points of each.
        up: (3,) unit.
    """
    widest = sorted(shapes, key=lambda points: -float(np.ptp(points, axis=0).max()))
    while len(widest) > 1 and _is_backdrop(widest[0], np.concatenate(widest[1:]), up):
        widest.pop(0)
    return np.concatenate(widest)


def near_shapes(shapes: Sequence[np.ndarray], count: int) -> np.ndarray:
    """(count, 3) points picked at random; shapes count alike, so that details outweigh large walls."""
    lane = dr.arange(mi.UInt32, count)
    picked = np.array(sampling.uniform_2d(sampling.clock(0, 0), sampling.VIEWPOINT, lane), np.float64)
    number = (picked[0] * len(shapes)).astype(int)
    lengths = np.array([len(points) for points in shapes])
    within = (picked[1] * lengths[number]).astype(int)
    return np.array([shapes[n][w] for n, w in zip(number, within, strict=True)], np.float64)


def _points(shape: mi.Shape) -> np.ndarray:
    if shape.is_mesh():
        return np.array(shape.vertex_position(dr.arange(mi.UInt32, shape.vertex_count())), np.float64).T
    if shape.class_name() not in CURVED:  # instances, and what has no area to pick places from
        box = shape.bbox()
        return np.array([np.ravel(box.corner(n)) for n in range(8)], np.float64)
    lane = dr.arange(mi.UInt32, ON_CURVED)
    even = sampling.low_discrepancy_2d(sampling.clock(0, 0), sampling.VIEWPOINT, mi.UInt32(0), lane)
    return np.array(shape.sample_position(mi.Float(0), even).p, np.float64).T


def _is_backdrop(points: np.ndarray, rest: np.ndarray, up: np.ndarray) -> bool:
    low, high = points.min(0), points.max(0)
    size, inner = high - low, np.ptp(rest, axis=0)
    level = np.arange(3) != np.abs(up).argmax()
    around_rest = (low[level] <= rest.min(0)[level]).all() and (high[level] >= rest.max(0)[level]).all()
    wide = size[level].max() > BACKDROP * inner.max() > 0  # a point, as what rests at scale 0, is no object
    flat = size[~level].sum() < FLAT * size[level].max()
    dome = size[~level].sum() > inner.max()
    return bool(around_rest and wide and (flat or dome))
