"""Cameras to Mitsuba's sensors. They look along their node's -z, +y is up; scale does not count."""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf.lights import facing
from ddgi.scene.gltf.nodes import Placed
from ddgi.scene.gltf.schema import Camera

HEIGHT = 360
"""Of pictures, where nobody asks for another size [pixels]."""
DEFAULT_ASPECT = 16 / 9
EXTREME_ASPECT = 16.0


def sensor(camera: Camera, placed: Placed) -> dict[str, Any]:
    """The camera that stands at a node.

    Raises:
        SceneError: It lacks what its type needs, or is no camera that can be.
    """
    label = f'camera "{placed.node.name or camera.name or placed.name}"'
    frame = _frame(placed, label)
    if camera.type == "perspective":
        lens = camera.perspective
        if lens is None:
            raise SceneError(f"{label} says that it is perspective, but not how wide")
        if not lens.yfov < np.pi:
            raise SceneError(f"{label}: its yfov must be below pi, not {lens.yfov:g}")
        return {
            "type": "perspective",
            "to_world": mi.ScalarTransform4f(frame.tolist()),
            "fov": float(np.degrees(lens.yfov)),
            "fov_axis": "y",
            **_near(lens.znear),
            "film": _film(lens.aspect_ratio or DEFAULT_ASPECT),
        }
    parallel = camera.orthographic
    if parallel is None:
        raise SceneError(f"{label} says that it is orthographic, but not how wide")
    if parallel.xmag == 0 or parallel.ymag == 0:
        raise SceneError(f"{label}: its xmag and ymag must not be zero")
    width = abs(parallel.xmag)
    return {
        "type": "orthographic",
        "to_world": mi.ScalarTransform4f((frame @ np.diag([width, width, 1.0, 1.0])).tolist()),
        **_near(parallel.znear),
        "film": _film(width / abs(parallel.ymag)),
    }


def _near(distance: float) -> dict[str, float]:
    """Mitsuba wants no near plane of 0, and a far one beyond it, though nothing ends there."""
    return {"near_clip": distance, "far_clip": 1e4 + 2 * distance} if distance > 0 else {}


def _film(aspect: float) -> dict[str, Any]:
    aspect = min(max(aspect, 1 / EXTREME_ASPECT), EXTREME_ASPECT)
    return {"type": "hdrfilm", "height": HEIGHT, "width": max(round(HEIGHT * aspect), 1)}


def _frame(placed: Placed, label: str) -> np.ndarray:
    """(4, 4) from Mitsuba's camera space (+z ahead, +x left, +y up) to the scene, without scale."""
    ahead = facing(placed, label)
    left = np.cross(placed.world[:3, 1], ahead)
    if not np.linalg.norm(left) > 0:
        raise SceneError(f"{label}: its node is scaled to nothing, so nothing is up")
    left /= np.linalg.norm(left)
    matrix = np.eye(4)
    matrix[:3] = np.stack([left, np.cross(ahead, left), ahead, placed.world[:3, 3]], 1)
    return matrix
