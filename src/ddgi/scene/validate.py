"""Checks on what Mitsuba accepts without a word: NaN, negative light, vertices that do not exist."""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.box import Box
from ddgi.errors import SceneError
from ddgi.scene.mesh_keys import FACES, POSITIONS

FARTHEST = 1e15
"""From the origin [m]: squares of lengths, and of areas, stay within single precision."""


def check_finite(values: Any, what: str) -> None:
    """Refuse NaN and infinity.

    Raises:
        SceneError: Some value is not finite; the text starts with `what`.
    """
    if not np.isfinite(values).all():
        raise SceneError(f"{what} is not finite")


def check_light(values: Any, what: str) -> None:
    """Refuse NaN, infinity and negative light.

    Raises:
        SceneError: Some value is not finite or below zero; the text starts with `what`.
    """
    check_finite(values, what)
    if (np.asarray(values) < 0).any():
        raise SceneError(f"{what} is negative")


def check_bounds(bounds: Box, what: str) -> None:
    """Refuse a scene that is a point, or reaches so far that squared distances overflow.

    Raises:
        SceneError: With `what` in front.
    """
    low, high = np.array(bounds)
    if not (np.abs(bounds) < FARTHEST).all():
        raise SceneError(f"{what}: its bounding box is not finite, or reaches beyond {FARTHEST:g} m")
    if (low == high).all():
        raise SceneError(f"{what}: all of it lies in one point")


def without_area(shape: mi.Shape) -> int:
    """Number of triangles of a mesh that are lines or points, which no ray meets."""
    parameters = mi.traverse(shape) if shape.is_mesh() else {}
    if POSITIONS not in parameters:
        return 0
    corners = parameters[POSITIONS].numpy().reshape(-1, 3).astype(np.float64)[parameters[FACES].numpy()]
    a, b, c = corners.reshape(-1, 3, 3).swapaxes(0, 1)
    return int((np.cross(b - a, c - a) == 0).all(1).sum())


def check_mesh(shape: mi.Shape, what: str) -> None:
    """Refuse meshes whose vertices are not finite or whose faces name vertices that do not exist.

    Raises:
        SceneError: With `what` in front.
    """
    if not shape.is_mesh():
        return
    parameters = mi.traverse(shape)
    if POSITIONS not in parameters:  # a cube: a mesh that Mitsuba makes itself
        return
    check_finite(parameters[POSITIONS].numpy(), f"{what}: a vertex position")
    faces = parameters[FACES].numpy()
    if faces.size and faces.max() >= shape.vertex_count():
        raise SceneError(f"{what}: a face uses vertex {faces.max()}, but there are {shape.vertex_count()}")
