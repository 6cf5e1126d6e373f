"""A closed white box with two occluders under one spotlight: how much occlusion a field resolves.

After the CTU thesis, table 7.1, where grids of 2 x 1 x 2 to 4 x 4 x 4 probes and maps of 2 x 2 to
32 x 32 texels are compared, and figure 7.10, where two spotlights shine at one of the occluders.
"""

from __future__ import annotations

from typing import Any

from ddgi.scene.library import geometry
from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.ingredients import camera, diffuse, front_camera, spot
from ddgi.scene.mesh_keys import mesh

LOW: Point = (-2.0, 0.0, -2.0)
HIGH: Point = (2.0, 2.4, 2.0)
"""Corners of the air in the box [m]."""

_SPOTS: tuple[Point, ...] = ((-1.3, 2.25, 1.5), (1.5, 2.25, 1.6))  # where they hang [m]
_AIM: Point = (-0.7, 0.7, -0.3)  # on the standing occluder [m]


def occluder_box(lights: int = 1, wall: float = 0.2, intensity: float = 30.0) -> Blueprint:
    """Build the box: a slab stands at -x, a bench with room beneath it at +x.

    Args:
        lights: Spotlights that shine at the slab, 1 or 2.
        wall: Thickness of the walls [m].
        intensity: Of each spotlight along its axis [W/sr].
    """
    if not wall > 0:
        raise ValueError(f"wall must be thicker than 0 m, not {wall}")
    if lights not in (1, 2):
        raise ValueError(f"lights must be 1 or 2, not {lights}")
    solids = {
        "walls": (geometry.merge(geometry.shell(LOW, HIGH, wall).values()), diffuse(0.76, 0.76, 0.76)),
        "slab": (_slab(), diffuse(0.74, 0.74, 0.74)),
        "bench": (_bench(), diffuse(0.74, 0.74, 0.74)),
    }
    description: dict[str, Any] = {
        "type": "scene",
        "front": front_camera(LOW, HIGH, 4.6),
        "beneath": camera((1.75, 0.75, 1.6), (0.3, 0.3, -0.7), fov=72),
    }
    for number, place in enumerate(_SPOTS[:lights]):
        description[f"spot-{number}"] = spot(place, _AIM, (intensity,) * 3, 34.0, 28.0)
    for name, (shape, bsdf) in solids.items():
        description[name] = mesh(name, shape.positions, shape.faces, bsdf=bsdf, normals=shape.normals)
    return Blueprint(description, (LOW, HIGH))


def _slab() -> geometry.Triangles:
    """An upright slab that stands free on the floor."""
    return geometry.moved(
        geometry.turned(geometry.box((-0.55, 0, -0.15), (0.55, 1.5, 0.15)), 28), (-0.75, 0.0, -0.35)
    )


def _bench() -> geometry.Triangles:
    """A thick board on two round feet; its feet reach into it."""
    board = geometry.box((-0.6, 0.42, -0.45), (0.6, 0.6, 0.45))
    feet = [geometry.moved(geometry.cylinder(0.13, 0.5, 48), (x, 0, 0)) for x in (-0.4, 0.4)]
    return geometry.moved(geometry.turned(geometry.merge([board, *feet]), -20), (0.85, 0.0, -0.5))
