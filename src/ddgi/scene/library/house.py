"""A house on an orange ground under a white sun: does light, or darkness, pass its walls?

After the leak test of McGuire, "Dynamic Diffuse Global Illumination" (2019, BLOG). One room opens to
the outside through a doorway and gets subtle light of many bounces, tinted by the ground. The
other is sealed: whatever light a method puts in there has leaked, and the right answer is exactly 0.
"""

from __future__ import annotations

from typing import Any

from ddgi.scene.library import geometry
from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.ingredients import camera, diffuse, sun
from ddgi.scene.mesh_keys import mesh

WIDTH, DEPTH, HEIGHT = 4.0, 4.0, 3.0
"""Inner size of each room along x, z and y [m]."""

FLOOR = 0.1
"""Height of the floor above the ground [m]."""

_DOOR_WIDTH, _DOOR_HEIGHT = 1.4, 2.2
_EAVES = 0.25  # how far the roof stands out [m]
_GROUND = 40.0  # half the ground's edge [m]


def open_room(wall: float = 0.2) -> tuple[Point, Point]:
    """(low, high) of the air in the room with the doorway [m]."""
    return (wall / 2, FLOOR, -DEPTH / 2), (wall / 2 + WIDTH, FLOOR + HEIGHT, DEPTH / 2)


def sealed_room(wall: float = 0.2) -> tuple[Point, Point]:
    """(low, high) of the air in the sealed room [m]."""
    return (-wall / 2 - WIDTH, FLOOR, -DEPTH / 2), (-wall / 2, FLOOR + HEIGHT, DEPTH / 2)


def house(
    wall: float = 0.2, sun_direction: Point = (-0.45, -1.0, -0.6), sun_irradiance: float = 20.0
) -> Blueprint:
    """Build the house. The doorway is in its +z side, at +x; the sealed room lies at -x.

    Args:
        wall: Thickness of walls and roof [m].
        sun_direction: The way sunlight travels.
        sun_irradiance: Irradiance of a surface that faces the sun [W/m^2].
    """
    if not wall > 0:
        raise ValueError(f"wall must be thicker than 0 m, not {wall}")
    x_in, z_in, ceiling = WIDTH + wall / 2, DEPTH / 2, FLOOR + HEIGHT
    x_out, z_out, top = x_in + wall, z_in + wall, ceiling + wall
    middle = wall / 2 + WIDTH / 2  # of the open room

    # Wherever two boxes meet at an inner edge one of them runs on behind the other, so that no ray
    # finds a crack.
    door = (middle - _DOOR_WIDTH / 2, middle + _DOOR_WIDTH / 2)
    walls = geometry.merge(
        [
            geometry.box((-x_out, 0, -z_out), (x_out, ceiling, -z_in)),
            *geometry.wall_with_opening(
                (-x_out, 0, z_in), (x_out, ceiling, z_out), door, FLOOR + _DOOR_HEIGHT
            ),
            geometry.box((-x_out, 0, -z_in), (-x_in, ceiling, z_in)),
            geometry.box((x_in, 0, -z_in), (x_out, ceiling, z_in)),
            geometry.box((-wall / 2, 0, -z_in), (wall / 2, ceiling, z_in)),
        ]
    )
    roof = geometry.box((-x_out - _EAVES, ceiling, -z_out - _EAVES), (x_out + _EAVES, top, z_out + _EAVES))
    # The floor fills the rooms and the doorway; a doorstep lies outside.
    floor = geometry.merge(
        [
            geometry.box(
                (-x_in - wall / 2, -0.1, -z_in - wall / 2), (x_in + wall / 2, FLOOR, z_in + wall / 2)
            ),
            geometry.box((door[0], -0.1, z_in + wall / 2), (door[1], FLOOR, z_out + 0.35)),
        ]
    )
    ground = geometry.box((-_GROUND, -1.0, -_GROUND), (_GROUND, 0.0, _GROUND))

    # The same furniture in both rooms, so that leaks are seen on objects too.
    rooms = (middle, -middle)
    tables = geometry.merge(_table((x - 0.9, FLOOR, -1.45)) for x in rooms)
    balls = geometry.merge(
        geometry.moved(geometry.sphere(0.3), (x - 0.7, FLOOR + 1.05, -1.45)) for x in rooms
    )
    crates = geometry.merge(
        geometry.moved(
            geometry.turned(geometry.box((-0.35, 0, -0.35), (0.35, 0.7, 0.35)), 25), (x - 1.3, FLOOR, 1.1)
        )
        for x in rooms
    )

    solids = {
        "ground": (ground, diffuse(0.78, 0.34, 0.10)),
        "walls": (walls, diffuse(0.75, 0.74, 0.71)),
        "roof": (roof, diffuse(0.62, 0.60, 0.57)),
        "floor": (floor, diffuse(0.55, 0.53, 0.50)),
        "tables": (tables, diffuse(0.45, 0.29, 0.16)),
        "balls": (balls, diffuse(0.25, 0.45, 0.62)),
        "crates": (crates, diffuse(0.62, 0.58, 0.30)),
    }
    description: dict[str, Any] = {
        "type": "scene",
        **_cameras(wall),
        "sun": sun(sun_direction, (sun_irradiance,) * 3),
    }
    for name, (shape, bsdf) in solids.items():
        description[name] = mesh(name, shape.positions, shape.faces, bsdf=bsdf, normals=shape.normals)
    around = 1.0
    return Blueprint(
        description, ((-x_out - around, 0.0, -z_out - around), (x_out + around, top + around, z_out + around))
    )


def _table(foot: Point) -> geometry.Triangles:
    """A table of 1.5 x 0.7 m that stands on `foot` [m]."""
    legs = [
        geometry.box((x - 0.04, 0, z - 0.04), (x + 0.04, 0.69, z + 0.04))
        for x in (-0.65, 0.65)
        for z in (-0.27, 0.27)
    ]
    return geometry.moved(
        geometry.merge([geometry.box((-0.75, 0.69, -0.35), (0.75, 0.75, 0.35)), *legs]), foot
    )


def _cameras(wall: float) -> dict[str, Any]:
    """Outside, from above with the roof cut away, and in each room."""
    (x0, y0, z0), (x1, _, _) = open_room(wall)
    above = 14.0
    eye = 1.6
    return {
        "overview": camera((9.0, 4.6, 10.5), (0.0, 1.1, 0.0), fov=52),
        # Straight down; the near plane lies just below the ceiling: the roof keeps out the sun, unseen.
        "cutaway": camera(
            (0, above, 0), (0, 0, 0), up=(0, 0, -1), fov=46, near=above - (FLOOR + HEIGHT - 0.05)
        ),
        "open": camera((x1 - 0.35, y0 + eye, z0 + 0.35), (x0 + 0.5, y0 + 1.1, 0.3), fov=88),
        "sealed": camera((-x0 - 0.35, y0 + eye, z0 + 0.35), (-x1 + 0.5, y0 + 1.1, 0.3), fov=88),
    }
