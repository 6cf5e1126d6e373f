"""A room that light floods through an opening in its ceiling, with a wall that keeps a part in shadow.

After the CTU thesis, figure 7.3: how far light spreads, and whether the corner behind the wall is as
dark as it should be.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ddgi.scene.library import geometry
from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.ingredients import camera, diffuse, front_camera, sun
from ddgi.scene.mesh_keys import mesh

LOW: Point = (-3.0, 0.0, -2.5)
HIGH: Point = (3.0, 3.4, 2.5)
"""Corners of the air in the room [m]."""

HOLE = ((0.6, -1.5), (2.0, 0.3))
"""(x, z) of the opening's corners [m]."""

PARTITION = (-0.35, 0.9)
"""Where the wall stands: its middle along x, and how far it comes forward from the back, as z [m]."""


def ceiling_hole(
    wall: float = 0.2,
    sun_direction: Point = (0.12, -1.0, 0.1),
    sun_irradiance: tuple[float, float, float] = (40.0, 38.0, 34.0),
) -> Blueprint:
    """Build the room: the opening is at +x, the shadowed part at -x.

    Args:
        wall: Thickness of the walls [m].
        sun_direction: The way the light above the opening travels.
        sun_irradiance: Irradiance of a surface that faces it [W/m^2].
    """
    if not wall > 0:
        raise ValueError(f"wall must be thicker than 0 m, not {wall}")
    shell = geometry.shell(LOW, HIGH, wall)
    ceiling = [
        *_ceiling(wall),
        geometry.moved(geometry.box((-3, -0.16, -0.12), (3, 0.01, 0.12)), (0, 3.4, 1.4)),
    ]
    white = [shell[side] for side in ("left", "right", "back", "front")]
    x, forward = PARTITION
    partition = geometry.box((x - wall / 2, 0, LOW[2]), (x + wall / 2, HIGH[1], forward))
    solids = {
        "walls": (geometry.merge(white), diffuse(0.74, 0.72, 0.68)),
        "ceiling": (geometry.merge(ceiling), diffuse(0.76, 0.75, 0.73)),
        "floor": (shell["floor"], diffuse(0.55, 0.46, 0.36)),
        "partition": (partition, diffuse(0.70, 0.70, 0.70)),
        **_objects(),
    }
    description: dict[str, Any] = {"type": "scene", **_cameras(), "sun": sun(sun_direction, sun_irradiance)}
    for name, (shape, bsdf) in solids.items():
        description[name] = mesh(name, shape.positions, shape.faces, bsdf=bsdf, normals=shape.normals)
    return Blueprint(description, (LOW, HIGH))


def _ceiling(wall: float) -> list[geometry.Triangles]:
    """Four slabs around the opening."""
    (x0, z0), (x1, z1) = HOLE
    low, high = HIGH[1], HIGH[1] + wall
    left, right, back, front = LOW[0] - wall, HIGH[0] + wall, LOW[2] - wall, HIGH[2] + wall
    return [
        geometry.box((left, low, back), (right, high, z0)),
        geometry.box((left, low, z1), (right, high, front)),
        geometry.box((left, low, z0), (x0, high, z1)),
        geometry.box((x1, low, z0), (right, high, z1)),
    ]


def _objects() -> dict[str, tuple[geometry.Triangles, dict[str, Any]]]:
    """Things that the bounced light shows: two in the lit part, two in the shadowed one."""
    box, moved, turned = geometry.box, geometry.moved, geometry.turned
    stone = geometry.blob(0.4, bumps=2.6, amplitude=0.4, seed=7)
    standing = moved(stone, (1.0, 0.78 - stone.positions[:, 1].min(), -1.6))
    profile = [(0, 0), (0.17, 0), (0.17, 0), (0.3, 0.28), (0.32, 0.5), (0.2, 0.72), (0.12, 0.8), (0.2, 0.9)]
    vase = geometry.lathe(np.array([*profile, (0.2, 0.9), (0.16, 0.9), (0.09, 0.8), (0.0, 0.78)]), 64)
    return {
        "pedestal": (moved(turned(box((-0.28, 0, -0.28), (0.28, 0.8, 0.28)), 12), (1.0, 0, -1.6)),
                     diffuse(0.70, 0.68, 0.64)),
        "stone": (standing, diffuse(0.72, 0.70, 0.66)),
        "ball": (moved(geometry.sphere(0.35, 32), (2.3, 0.35, 1.1)), diffuse(0.20, 0.35, 0.62)),
        "crate": (moved(turned(box((-0.4, 0, -0.4), (0.4, 0.8, 0.4)), 25), (-2.1, 0, -1.6)),
                  diffuse(0.62, 0.50, 0.20)),
        "vase": (moved(vase, (-1.25, 0, -0.3)), diffuse(0.62, 0.25, 0.16)),
    }  # fmt: skip


def _cameras() -> dict[str, Any]:
    """All of it past the front wall, and the shadowed part from within."""
    return {
        "front": front_camera(LOW, HIGH, 6.5),
        "shadow": camera((-0.75, 1.7, 2.2), (-2.0, 0.8, -1.6), fov=80),
        "lit": camera((2.7, 1.7, 2.2), (0.4, 0.9, -1.4), fov=82),
    }
