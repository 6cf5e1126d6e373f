"""A furnace: a closed box whose walls all glow and reflect alike, so its answer is known on paper.

Every surface emits `emission` and reflects `albedo` of what arrives. The radiance L is then the same
everywhere: L = emission + albedo L, so L = emission / (1 - albedo); 1 with the defaults. Each bounce
that a method loses or gains shows.
"""

from __future__ import annotations

from ddgi.scene.library import geometry
from ddgi.scene.library.blueprint import Blueprint
from ddgi.scene.library.ingredients import camera, diffuse
from ddgi.scene.mesh_keys import mesh


def furnace(albedo: float = 0.5, emission: float = 0.5, half_size: float = 1.0) -> Blueprint:
    """Build the furnace.

    Args:
        albedo: Of the walls, 0 <= albedo < 1.
        emission: Radiance that the walls emit [W/(m^2 sr)].
        half_size: Half the box's edge [m].
    """
    low, high = (-half_size,) * 3, (half_size,) * 3
    inside = geometry.turned_inside_out(geometry.box(low, high))
    glow = {"type": "area", "radiance": {"type": "rgb", "value": [emission] * 3}}
    description = {
        "type": "scene",
        "inside": camera((0.0, 0.0, 0.8 * half_size), (0.1 * half_size, -0.2 * half_size, -half_size)),
        "walls": mesh(
            "walls", inside.positions, inside.faces, bsdf=diffuse(albedo, albedo, albedo), emitter=glow
        ),
    }
    return Blueprint(description, (low, high))
