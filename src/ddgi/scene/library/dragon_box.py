"""A white box with a white spotlight and a red dragon: with it in the beam, all light has bounced off it.

After McGuire, "Dynamic Diffuse Global Illumination" (2019, BLOG, "Accurate and noise-free"): with the
dragon on the right the beam meets the white floor and the box is white; on the left everything
turns red.
"""

from __future__ import annotations

from typing import Any

from ddgi.scene.library import geometry
from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.dragon import dragon
from ddgi.scene.library.ingredients import camera, diffuse, front_camera, spot
from ddgi.scene.mesh_keys import mesh

LOW: Point = (-2.0, 0.0, -1.4)
HIGH: Point = (2.0, 2.3, 1.4)
"""Corners of the air in the box [m]."""

LEFT, RIGHT = -0.95, 1.0
"""Where the dragon stands along x, in the beam and out of it [m]."""

_SPOT: Point = (0.95, 2.1, 1.0)
_AIM: Point = (-0.7, 0.4, 0.05)
_CUTOFF = 12.5  # [degrees]: the whole beam meets a dragon that stands at LEFT


def dragon_box(dragon_x: float = LEFT, wall: float = 0.2, intensity: float = 250.0) -> Blueprint:
    """Build the box.

    Args:
        dragon_x: Where the dragon stands along x, -1.1 to 1.1 [m].
        wall: Thickness of the walls [m].
        intensity: Of the spotlight along its axis [W/sr].
    """
    if not wall > 0:
        raise ValueError(f"wall must be thicker than 0 m, not {wall}")
    if not abs(dragon_x) <= 1.1:
        raise ValueError(f"dragon_x must be -1.1 to 1.1 m, not {dragon_x}")
    figure = geometry.moved(geometry.turned(dragon(), 38), (dragon_x, 0.0, -0.1))
    solids = {
        "walls": (geometry.merge(geometry.shell(LOW, HIGH, wall).values()), diffuse(0.78, 0.78, 0.78)),
        "dragon": (figure, diffuse(0.75, 0.07, 0.05)),
    }
    description: dict[str, Any] = {
        "type": "scene",
        "front": front_camera(LOW, HIGH, 4.4),
        "head": camera((dragon_x + 1.4, 1.2, 0.55), (dragon_x + 0.1, 1.32, 0.0), fov=56),
        "spot": spot(_SPOT, _AIM, (intensity,) * 3, _CUTOFF, 0.6 * _CUTOFF),
    }
    for name, (shape, bsdf) in solids.items():
        description[name] = mesh(name, shape.positions, shape.faces, bsdf=bsdf, normals=shape.normals)
    return Blueprint(description, (LOW, HIGH))
