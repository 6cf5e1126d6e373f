"""A closed building with a small door, lit by a far spotlight as by the sun: which weight stops leaks.

After the CTU thesis, figure 7.1: the same view without weights, then with wrap shading, the
Chebyshev weight and the surface bias. Behind the room lies another that no direct light reaches.
"""

from __future__ import annotations

from typing import Any

from ddgi.scene.library import geometry
from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.ingredients import camera, diffuse, spot
from ddgi.scene.mesh_keys import mesh

WIDTH, HEIGHT = 5.0, 2.7
"""Inner size of both rooms along x, and y [m]."""

DEPTH, FAR_DEPTH = 4.0, 2.6
"""Inner size of the room with the door, and of the far room behind it, along z [m]."""

SPOT: Point = (14.0, 22.0, 30.0)
"""Where the light hangs [m]; the building stands about the origin."""

_DOOR = (0.5, 1.4)  # along x [m]
_INNER_DOOR = (-2.0, -1.1)  # along x [m]
_DOOR_HEIGHT = 2.0
_GROUND = 16.0  # half the ground's edge [m]
_AROUND = 1.0  # of air that probes cover outside [m]


def far_room(wall: float = 0.25) -> tuple[Point, Point]:
    """(low, high) of the air in the room that no direct light reaches [m]."""
    return (-WIDTH / 2, 0.0, -wall / 2 - FAR_DEPTH), (WIDTH / 2, HEIGHT, -wall / 2)


def near_room(wall: float = 0.25) -> tuple[Point, Point]:
    """(low, high) of the air in the room with the door [m]."""
    return (-WIDTH / 2, 0.0, wall / 2), (WIDTH / 2, HEIGHT, wall / 2 + DEPTH)


def room_with_door(wall: float = 0.25, intensity: float = 30_000.0) -> Blueprint:
    """Build the rooms; the door is in the +z side.

    Args:
        wall: Thickness of the walls and the roof [m].
        intensity: Of the spotlight along its axis [W/sr]; it hangs 40 m away.
    """
    if not wall > 0:
        raise ValueError(f"wall must be thicker than 0 m, not {wall}")
    (x0, _, z0), (x1, _, z1) = far_room(wall)[0], near_room(wall)[1]
    x_out, back, front, top = x1 + wall, z0 - wall, z1 + wall, HEIGHT + wall
    walls = [
        *geometry.wall_with_opening((-x_out, 0, z1), (x_out, HEIGHT, front), _DOOR, _DOOR_HEIGHT),
        *geometry.wall_with_opening(
            (-x_out, 0, -wall / 2), (x_out, HEIGHT, wall / 2), _INNER_DOOR, _DOOR_HEIGHT
        ),
        geometry.box((-x_out, 0, back), (x_out, HEIGHT, z0)),
        geometry.box((-x_out, 0, z0), (x0, HEIGHT, z1)),
        geometry.box((x1, 0, z0), (x_out, HEIGHT, z1)),
    ]
    roof = geometry.box((-x_out, HEIGHT, back), (x_out, top, front))
    ground = geometry.box((-_GROUND, -1, -_GROUND), (_GROUND, 0, _GROUND))
    solids = {
        "ground": (ground, diffuse(0.52, 0.47, 0.38)),
        "walls": (geometry.merge(walls), diffuse(0.74, 0.73, 0.71)),
        "roof": (roof, diffuse(0.66, 0.65, 0.63)),
        **_objects(),
    }
    description: dict[str, Any] = {
        "type": "scene",
        **_cameras(),
        "spot": spot(SPOT, (0.0, 1.0, 0.5), (intensity,) * 3, 14.0, 12.0),
    }
    for name, (shape, bsdf) in solids.items():
        description[name] = mesh(name, shape.positions, shape.faces, bsdf=bsdf, normals=shape.normals)
    low, high = (-x_out - _AROUND, 0.0, back - _AROUND), (x_out + _AROUND, top + _AROUND, front + _AROUND)
    return Blueprint(description, (low, high))


def _objects() -> dict[str, tuple[geometry.Triangles, dict[str, Any]]]:
    """A few things in both rooms, away from the light that the door lets in."""
    box, moved, turned = geometry.box, geometry.moved, geometry.turned
    stone = geometry.blob(0.34, bumps=2.8, amplitude=0.4, seed=11)
    crates = [
        moved(turned(box((-0.4, 0, -0.4), (0.4, 0.8, 0.4)), 18), (-1.9, 0, 1.3)),
        moved(turned(box((-0.25, 0.79, -0.25), (0.25, 1.3, 0.25)), -10), (-1.95, 0, 1.25)),
        moved(turned(box((-0.4, 0, -0.4), (0.4, 0.8, 0.4)), -22), (1.7, 0, -2.0)),
    ]
    return {
        "crates": (geometry.merge(crates), diffuse(0.55, 0.40, 0.22)),
        "ball": (moved(geometry.sphere(0.35, 32), (1.9, 0.35, 0.9)), diffuse(0.60, 0.16, 0.12)),
        "column": (moved(geometry.cylinder(0.28, 0.9, 64), (0.1, 0, -2.0)), diffuse(0.70, 0.68, 0.64)),
        "stone": (moved(stone, (0.1, 0.88 - stone.positions[:, 1].min(), -2.0)), diffuse(0.72, 0.70, 0.66)),
    }


def _cameras() -> dict[str, Any]:
    """In the room, in the far room, and outside."""
    return {
        "room": camera((2.15, 1.6, 3.75), (-1.0, 1.05, 0.4), fov=86),
        "far": camera((-2.2, 1.6, -0.45), (1.0, 0.85, -2.3), fov=84),
        "outside": camera((6.5, 4.2, 10.5), (0.0, 1.1, 1.0), fov=52),
    }
