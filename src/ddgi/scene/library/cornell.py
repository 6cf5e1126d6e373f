"""The Cornell box: two metres wide, seen through its open front.

Goral et al., "Modeling the Interaction of Light Between Diffuse Surfaces", SIGGRAPH 1984, in the
measures that Mitsuba ships.
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi

from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.ingredients import film

BOX = ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))


def cornell(size: tuple[int, int] = (512, 512)) -> Blueprint:
    """Build the box with its area light in the ceiling. `size`: (width, height) [pixels]."""
    return Blueprint(_description(size), BOX)


def cornell_point(
    size: tuple[int, int] = (512, 512),
    intensity: float = 1.0,
    position: Point = (0.0, 0.7, 0.0),
) -> Blueprint:
    """Build the box without the luminaire, lit by a white point light.

    Args:
        size: (width, height) [pixels].
        intensity: Of the light [W/sr].
        position: Of the light [m].
    """
    description = _description(size)
    del description["light"]
    description["point-light"] = {
        "type": "point",
        "position": list(position),
        "intensity": {"type": "rgb", "value": [intensity] * 3},
    }
    return Blueprint(description, BOX)


def _description(size: tuple[int, int]) -> dict[str, Any]:
    """Mitsuba's Cornell box with our camera name and picture size, and without its integrator."""
    original: dict[str, Any] = mi.cornell_box()
    front: dict[str, Any] = original.pop("sensor") | {"film": film(size)}
    del front["sampler"], original["integrator"]
    return {"type": "scene", "front": front} | original
