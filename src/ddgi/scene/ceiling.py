"""A ceiling for scenes without one, such as models of flats that are made to be looked into from above.

Where it belongs is found with horizontal rays: up to the top of the walls they are stopped, above it
they leave. That needs neither closed nor consistently oriented geometry, and furniture does not matter.
"""

from __future__ import annotations

from typing import Any, Literal

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.daylight import horizontal_axes

Height = float | Literal["auto"]

ALBEDO = 0.8
THICKNESS = 0.1
"""Of its height above the lowest point. Sheets leak."""
LEVELS = 64
"""Heights at which is looked for walls, before the last one is refined."""
REFINED = 12
"""Halvings of the step between two levels."""
RAYS = 4096
"""At each level."""
ENCLOSED = 0.5
"""Least share of rays that are stopped, against the level with the most, where there are still walls."""
FEWEST = 0.01
"""Share of rays that must be stopped somewhere for there to be walls."""
STRAY = 0.5
"""Percentage of what rays meet below the ceiling that may lie beyond it on either side: masts, not walls."""


def describe_ceiling(
    scene: mi.Scene, height: Height, up: np.ndarray, below: float = 0.0
) -> tuple[dict[str, Any], float]:
    """A flat white slab over the walls that stand under it.

    Args:
        scene: All geometry.
        height: Of its lower face: the coordinate along `up` [m], or "auto" for the top of the walls.
        up: (3,) unit vector.
        below: At which height the scene counts from zero [m].

    Returns:
        The plugin, and the height.

    Raises:
        SceneError: The height is no number, not above everything's lowest point or far above the highest,
            or there are no walls.
    """
    frame = np.stack([*horizontal_axes(up), up])  # rows: two horizontal axes and up
    bounds = scene.bbox()
    corners = np.array([np.ravel(bounds.corner(i)) for i in range(8)]) @ frame.T
    low, high = corners.min(0), corners.max(0)
    level = _top_of_walls(scene, frame, low, high) if height == "auto" else _number(height) - below
    highest = 2 * high[2] - low[2]  # as far above everything again as everything is high
    if not low[2] < level <= highest:
        raise SceneError(
            f"ceiling must be above the lowest point of the scene, {low[2] + below:.6g}, and no higher than "
            f"{highest + below:.6g}, not at {level + below:.6g}"
        )
    thickness = THICKNESS * (level - low[2])
    (x0, y0), (x1, y1) = _outline(scene, frame, low, high, level)
    first, last = np.array([x0, y0, level]), np.array([x1, y1, level + thickness])
    matrix = np.eye(4)
    matrix[:3, :3] = frame.T * ((last - first) / 2)
    matrix[:3, 3] = frame.T @ ((first + last) / 2)
    bsdf = {"type": "diffuse", "reflectance": {"type": "rgb", "value": ALBEDO}}
    slab = {
        "type": "cube",
        "to_world": mi.ScalarTransform4f(matrix),
        "bsdf": {"type": "twosided", "bsdf": bsdf},
    }
    return slab, level + below


def _number(height: Any) -> float:
    if isinstance(height, bool) or not isinstance(height, (int, float)) or not np.isfinite(height):
        raise SceneError(f"ceiling must be a height or 'auto', not {height!r}")
    return float(height)


def _top_of_walls(scene: mi.Scene, frame: np.ndarray, low: np.ndarray, high: np.ndarray) -> float:
    """The highest level at which about as many rays are stopped as lower down."""
    levels = low[2] + (np.arange(LEVELS) + 0.5) / LEVELS * (high[2] - low[2])
    stopped = np.array([np.mean(_hits(scene, frame, low, high, level)[1]) for level in levels])
    if stopped.max() < FEWEST:
        raise SceneError("ceiling must be a height here: 'auto' found no walls for it to lie on")
    below = levels[stopped >= ENCLOSED * stopped.max()][-1]
    above = min(below + (high[2] - low[2]) / LEVELS, high[2])
    for _ in range(REFINED):
        middle = (below + above) / 2
        if np.mean(_hits(scene, frame, low, high, middle)[1]) >= ENCLOSED * stopped.max():
            below = middle
        else:
            above = middle
    return float(below)  # the walls reach a little into the slab: no crack


def _outline(
    scene: mi.Scene, frame: np.ndarray, low: np.ndarray, high: np.ndarray, level: float
) -> tuple[np.ndarray, np.ndarray]:
    """Two corners, (2,), of what the slab covers: what stands just below it, else everything there is."""
    around = 0.1 * (high - low)  # from where rays see the outer walls from outside
    place, hit = _hits(scene, frame, low - around, high + around, level - 1e-3 * (high[2] - low[2]))
    if not hit.any():
        return low[:2], high[:2]
    first, last = np.percentile(place[hit], (STRAY, 100 - STRAY), axis=0)
    return first, last


def _hits(
    scene: mi.Scene, frame: np.ndarray, low: np.ndarray, high: np.ndarray, level: float
) -> tuple[np.ndarray, np.ndarray]:
    """Where horizontal rays at one level meet something, (RAYS, 2) in the frame, and which do."""
    sample = np.random.default_rng(0).random((RAYS, 3))
    start = np.concatenate([low[:2] + sample[:, :2] * (high - low)[:2], np.full((RAYS, 1), level)], 1)
    angle = 2 * np.pi * sample[:, 2]
    along = np.stack([np.cos(angle), np.sin(angle), np.zeros(RAYS)], 1)
    ray = mi.Ray3f(mi.Point3f((start @ frame).T), mi.Vector3f((along @ frame).T))
    found = scene.ray_intersect_preliminary(ray)
    hit, distance = np.array(found.is_valid()), np.array(dr.select(found.is_valid(), found.t, 0))
    return start[:, :2] + distance[:, None] * along[:, :2], hit
