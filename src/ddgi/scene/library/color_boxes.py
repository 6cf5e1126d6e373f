"""A closed box with two coloured objects under one spotlight: colour bleeding.

After the CTU thesis, section 7.4's scene of figure 7.4, where the spotlight travels and two probes
along each axis suffice.
"""

from __future__ import annotations

from typing import Any

from ddgi.scene.library import geometry
from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.ingredients import camera, diffuse, front_camera, spot
from ddgi.scene.library.moving import Carried, rig
from ddgi.scene.mesh_keys import mesh

LOW: Point = (-2.0, 0.0, -1.5)
HIGH: Point = (2.0, 2.4, 1.5)
"""Corners of the air in the box [m]."""

TRAVEL = 1.6
"""How far the spotlight goes in its animation, from one object to the other [m]."""
_REACH = 1.8  # how far along x the spotlight may travel [m]


def color_boxes(spot_x: float = -0.5, wall: float = 0.2, intensity: float = 30.0) -> Blueprint:
    """Build the box: a red tower at -x, green blocks at +x, and white walls.

    Args:
        spot_x: Where the spotlight hangs along x, -1.8 to 1.8 [m].
        wall: Thickness of the walls [m].
        intensity: Of the spotlight along its axis [W/sr].
    """
    if not wall > 0:
        raise ValueError(f"wall must be thicker than 0 m, not {wall}")
    if not abs(spot_x) <= _REACH:
        raise ValueError(f"spot_x must be -{_REACH} to {_REACH} m, not {spot_x}")
    solids = {
        "walls": (geometry.merge(geometry.shell(LOW, HIGH, wall).values()), diffuse(0.76, 0.75, 0.73)),
        "tower": (_tower(), diffuse(0.72, 0.06, 0.05)),
        "blocks": (_blocks(), diffuse(0.10, 0.55, 0.12)),
    }
    description: dict[str, Any] = {
        "type": "scene",
        "front": front_camera(LOW, HIGH, 4.2),
        "side": camera((-1.8, 1.5, 1.3), (0.1, 0.6, -0.5), fov=84),
        "spot": spot((spot_x, 2.25, 1.3), (spot_x, 0.7, -0.1), (intensity,) * 3, 24.0, 16.0),
    }
    for name, (shape, bsdf) in solids.items():
        description[name] = mesh(name, shape.positions, shape.faces, bsdf=bsdf, normals=shape.normals)
    there = spot_x + (TRAVEL if spot_x < 0 else -TRAVEL)
    places = [(x, 2.25, 1.3) for x in (spot_x, there, spot_x)]
    sweep = Carried("spot", (0.0, 2.0, 4.0), places, light="spot")
    return Blueprint(description, (LOW, HIGH), rig("sweep", [sweep]))


def _tower() -> geometry.Triangles:
    """Slabs in a pile, each turned a little further; they reach into one another."""
    slabs = [
        geometry.moved(
            geometry.turned(geometry.box((-h, -0.01, -h), (h, 0.12, h)), 12 + 7 * i), (0, 0.12 * i, 0)
        )
        for i, h in enumerate([0.36 - 0.008 * i for i in range(13)])
    ]
    return geometry.moved(geometry.merge(slabs), (-0.85, 0.01, -0.15))


def _blocks() -> geometry.Triangles:
    """A cube with a smaller one and a ball on it."""
    cube = geometry.turned(geometry.box((-0.42, 0, -0.42), (0.42, 0.8, 0.42)), -24)
    small = geometry.turned(geometry.box((-0.2, 0.79, -0.2), (0.2, 1.15, 0.2)), 15)
    ball = geometry.moved(geometry.sphere(0.16, 32), (0.0, 1.3, 0.0))
    return geometry.moved(geometry.merge([cube, small, ball]), (0.65, 0.0, -0.05))
