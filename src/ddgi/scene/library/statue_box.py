"""A statue between an orange and a cyan wall, with no direct light on it: one colour from each side.

After McGuire, "Dynamic Diffuse Global Illumination" (2019, BLOG, "Diffuse interreflection"). Two
spotlights shine at the coloured walls alone.
"""

from __future__ import annotations

from typing import Any

from ddgi.scene.library import geometry
from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.ingredients import camera, diffuse, front_camera, spot
from ddgi.scene.library.statue import bust, pedestal
from ddgi.scene.mesh_keys import mesh

LOW: Point = (-1.8, 0.0, -1.4)
HIGH: Point = (1.8, 2.2, 1.4)
"""Corners of the air in the box [m]."""

_SPOT: Point = (0.35, 2.08, 0.0)  # and its mirror image [m]
_AIM: Point = (HIGH[0], 1.3, 0.0)
_CUTOFF = 26.0  # [degrees]: the whole beam meets the wall


def statue_box(wall: float = 0.2, intensity: float = 40.0) -> Blueprint:
    """Build the box: orange at -x, cyan at +x, the rest white.

    Args:
        wall: Thickness of the walls [m].
        intensity: Of each spotlight along its axis [W/sr].
    """
    if not wall > 0:
        raise ValueError(f"wall must be thicker than 0 m, not {wall}")
    shell = geometry.shell(LOW, HIGH, wall)
    solids = {
        "orange-wall": (shell.pop("left"), diffuse(0.85, 0.36, 0.04)),
        "cyan-wall": (shell.pop("right"), diffuse(0.04, 0.62, 0.72)),
        "walls": (geometry.merge(shell.values()), diffuse(0.74, 0.74, 0.74)),
        "pedestal": (pedestal(), diffuse(0.66, 0.66, 0.66)),
        "statue": (bust(), diffuse(0.80, 0.80, 0.80)),
    }
    description: dict[str, Any] = {
        "type": "scene",
        "front": front_camera(LOW, HIGH, 3.8),
        "face": camera((0.4, 1.5, 1.3), (0.0, 1.4, 0.0), fov=64),
    }
    for number, side in enumerate((-1, 1)):
        origin, target = ((side * x, y, z) for x, y, z in (_SPOT, _AIM))
        description[f"spot-{number}"] = spot(origin, target, (intensity,) * 3, _CUTOFF, 0.3 * _CUTOFF)
    for name, (shape, bsdf) in solids.items():
        description[name] = mesh(name, shape.positions, shape.faces, bsdf=bsdf, normals=shape.normals)
    return Blueprint(description, (LOW, HIGH))
