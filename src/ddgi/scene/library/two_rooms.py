"""Two rooms joined by a doorway; a lamp hangs in only one of them.

All light in the other room has come through the door and bounced at least once: the plainest test of
indirect light, and of light leaking through the wall between.
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi

from ddgi.scene.library import geometry
from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.ingredients import camera, diffuse
from ddgi.scene.mesh_keys import mesh

WIDTH, DEPTH, HEIGHT = 4.0, 4.0, 2.8
"""Inner size of each room along x, z and y [m]."""

_DOOR = (-0.6, 0.8)  # along z [m]
_DOOR_HEIGHT = 2.1
_LAMP = 0.55  # half the lamp's edge [m]


def two_rooms(wall: float = 0.2, lamp_radiance: tuple[float, float, float] = (30.0, 27.0, 22.0)) -> Blueprint:
    """Build the rooms: the lit one at +x, the dark one at -x.

    Args:
        wall: Thickness of walls, floor and ceiling [m].
        lamp_radiance: Of the square lamp under the ceiling, 1.1 m wide [W/(m^2 sr)].
    """
    if not wall > 0:
        raise ValueError(f"wall must be thicker than 0 m, not {wall}")
    x_in, z_in = WIDTH + wall / 2, DEPTH / 2
    x_out, z_out = x_in + wall, z_in + wall
    middle = wall / 2 + WIDTH / 2  # of the lit room
    box = geometry.box

    # End walls run past the long walls, floor and ceiling past them all: no cracks at inner edges.
    white = [
        box((-x_in, 0, -z_out), (x_in, HEIGHT, -z_in)),
        box((-x_in, 0, z_in), (x_in, HEIGHT, z_out)),
        *geometry.wall_with_opening((-wall / 2, 0, -z_in), (wall / 2, HEIGHT, z_in), _DOOR, _DOOR_HEIGHT),
    ]
    solids = {
        "walls": (geometry.merge(white), diffuse(0.74, 0.72, 0.68)),
        "end-wall-lit": (box((x_in, 0, -z_out), (x_out, HEIGHT, z_out)), diffuse(0.66, 0.25, 0.13)),
        "end-wall-dark": (box((-x_out, 0, -z_out), (-x_in, HEIGHT, z_out)), diffuse(0.16, 0.42, 0.46)),
        "ceiling": (box((-x_out, HEIGHT, -z_out), (x_out, HEIGHT + wall, z_out)), diffuse(0.78, 0.77, 0.75)),
        "floor": (box((-x_out, -wall, -z_out), (x_out, 0, z_out)), diffuse(0.55, 0.43, 0.31)),
        **_objects(middle),
    }
    description: dict[str, Any] = {"type": "scene", **_cameras(), "lamp": _lamp(middle, lamp_radiance)}
    for name, (shape, bsdf) in solids.items():
        description[name] = mesh(name, shape.positions, shape.faces, bsdf=bsdf, normals=shape.normals)
    return Blueprint(description, ((-x_in, 0.0, -z_in), (x_in, HEIGHT, z_in)))


def _objects(middle: float) -> dict[str, tuple[geometry.Triangles, dict[str, Any]]]:
    """A few things to be lit; `middle`: distance of the rooms' middles from the wall between [m]."""
    box, moved, turned = geometry.box, geometry.moved, geometry.turned
    pedestal = moved(turned(box((-0.3, 0, -0.3), (0.3, 0.8, 0.3)), 20), (-middle + 0.95, 0, -1.4))
    sculpture = geometry.blob(0.36, bumps=2.8, amplitude=0.4, seed=4)
    standing = moved(sculpture, (-middle + 0.95, 0.77 - sculpture.positions[:, 1].min(), -1.4))
    return {
        "pedestal": (pedestal, diffuse(0.70, 0.68, 0.64)),
        "sculpture": (standing, diffuse(0.72, 0.70, 0.66)),
        "ball": (moved(geometry.sphere(0.35), (-middle + 0.6, 0.35, 1.45)), diffuse(0.70, 0.52, 0.16)),
        "crate": (
            moved(turned(box((-0.4, 0, -0.4), (0.4, 0.8, 0.4)), -18), (middle + 0.9, 0, -1.0)),
            diffuse(0.30, 0.50, 0.22),
        ),
        "tall-crate": (
            moved(turned(box((-0.35, 0, -0.35), (0.35, 1.6, 0.35)), 30), (middle - 1.3, 0, 1.4)),
            diffuse(0.68, 0.65, 0.60),
        ),
    }


def _lamp(middle: float, radiance: tuple[float, float, float]) -> dict[str, Any]:
    """A square that shines down from a centimetre under the ceiling."""
    place = mi.ScalarTransform4f().translate([middle, HEIGHT - 0.01, 0.0])
    facing_down = mi.ScalarTransform4f().rotate([1, 0, 0], 90)
    return {
        "type": "rectangle",
        "to_world": place @ facing_down @ mi.ScalarTransform4f().scale([_LAMP, _LAMP, 1]),
        "bsdf": diffuse(0.5, 0.5, 0.5),
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": list(radiance)}},
    }


def _cameras() -> dict[str, Any]:
    """Two views towards the doorway, one from each room."""
    dark: Point = (-3.75, 1.55, 1.6)
    lit: Point = (3.8, 1.6, 1.65)
    return {
        "dark": camera(dark, (-0.6, 1.05, -0.75), fov=75),
        "lit": camera(lit, (0.2, 1.05, -0.2), fov=80),
    }
