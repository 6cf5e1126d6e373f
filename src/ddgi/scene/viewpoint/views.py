"""How much there is to see in a view."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddgi.scene.daylight import horizontal_axes
from ddgi.scene.viewpoint.sight import Sight

SIZE = (16, 9)
"""Rays across a view, and down; pictures have this shape too."""


@dataclass(frozen=True)
class View:
    """What a camera looks at, and from where."""

    place: np.ndarray  # (3,) [m]
    target: np.ndarray  # (3,) [m]
    fov: float  # horizontal [degrees]
    lit: bool  # some light reaches what it shows


def directions(elevation: np.ndarray | float, azimuth: np.ndarray, up: np.ndarray) -> np.ndarray:
    """(..., 3) unit vectors; angles in radians, azimuth as of the sun."""
    elevation = np.asarray(elevation)
    north, east = horizontal_axes(up)
    level = np.cos(azimuth)[..., None] * north + np.sin(azimuth)[..., None] * east
    return np.cos(elevation)[..., None] * level + np.sin(elevation)[..., None] * up


def frustum(forward: np.ndarray, up: np.ndarray, fov: float, size: tuple[int, int] = SIZE) -> np.ndarray:
    """(V, h, w, 3) unit directions of the rays of views.

    Args:
        forward: (V, 3) unit, not along up.
        up: (3,) unit.
        fov: Horizontal field of view [degrees].
        size: (w, h).
    """
    right = np.cross(forward, up)
    right /= np.linalg.norm(right, axis=-1, keepdims=True)
    upward = np.cross(right, forward)
    width, height = size
    half = np.tan(0.5 * np.radians(fov))
    x = ((np.arange(width) + 0.5) / width * 2 - 1) * half
    y = (1 - (np.arange(height)[:, None] + 0.5) / height * 2) * half * SIZE[1] / SIZE[0]
    rays = forward[:, None, None] + x[..., None] * right[:, None, None] + y[..., None] * upward[:, None, None]
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def variety(sight: Sight, counted: np.ndarray, unit: np.ndarray | float) -> np.ndarray:
    """(V,) bits: entropy of where the surfaces of each view face, what colour they have and how far they are.

    Args:
        sight: (V, h, w) rays.
        counted: (V, h, w) bool, those that count.
        unit: (V, 1, 1) or a number: the length that distances are compared with [m].
    """
    axis = np.abs(sight.normal).argmax(-1)[..., None]
    facing = (axis * 2 + (np.take_along_axis(sight.normal, axis, -1) > 0))[..., 0]
    colour = np.rint(sight.albedo * 3).astype(int) @ (1, 4, 16)
    octave = np.floor(np.log2(np.where(counted, sight.distance, 1) / unit + 1e-9)).astype(int).clip(-8, 7) + 8
    kind = np.where(counted, (facing * 64 + colour) * 16 + octave, -1)
    return np.array([_entropy(view) for view in kind])


def _entropy(kinds: np.ndarray) -> float:
    _, counts = np.unique(kinds[kinds >= 0], return_counts=True)
    share = counts / max(counts.sum(), 1)
    return float(-(share * np.log2(share)).sum())


def mean(what: np.ndarray) -> np.ndarray:
    """(V,) over the rays of each view. what: (V, h, w)."""
    return what.mean((1, 2))


def lit(light: np.ndarray) -> np.ndarray:
    """(V,) in [0, 1): 0 for views in the dark, nearly 1 for those lit like the others.

    Args:
        light: (V, h, w) brightness along each ray, any unit; NaN where it does not count.
    """
    counted = np.isfinite(light)
    light = np.where(counted, light, 0)
    if not light.any():
        return np.zeros(len(light))
    usual = float(np.quantile(light[light > 0], 0.5))
    level = np.minimum(light / usual, 4).sum((1, 2)) / np.maximum(counted.sum((1, 2)), 1)
    return level / (level + 0.3)
