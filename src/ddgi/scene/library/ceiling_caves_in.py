"""A room whose ceiling caves in: a slab falls out of it, and the sun comes in (SCALE 4.3's large object change)."""

from __future__ import annotations

import numpy as np

from ddgi.scene.library import geometry
from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.ceiling_hole import HIGH, HOLE, ceiling_hole
from ddgi.scene.library.ingredients import diffuse
from ddgi.scene.library.moving import Carried, rig, turns_about
from ddgi.scene.mesh_keys import mesh

BULB: Point = (-1.6, 2.9, 0.6)
"""Of a dim light in the shadowed part [m]."""
FALLS_AT, LASTS = 1.0, 4.0
"""When the slab comes loose, and how long the animation is [s]."""
GAP = 0.001
"""Around the slab [m]."""
FORWARD = 0.35
"""How far it drifts, past the pedestal [m]."""
GRAVITY, STEPS = 9.81, 16


def ceiling_caves_in(wall: float = 0.2, bulb: float = 1.5) -> Blueprint:
    """Build the room of `ceiling-hole` with its opening shut, and the animation that opens it.

    Args:
        wall: Thickness of walls and slab [m].
        bulb: Radiant intensity of a light that shines inside all the time [W/sr].
    """
    room = ceiling_hole(wall)
    (x0, z0), (x1, z1) = HOLE
    slab = geometry.box((x0 + GAP, HIGH[1], z0 + GAP), (x1 - GAP, HIGH[1] + wall, z1 - GAP))
    description = dict(room.description)
    description["slab"] = mesh("slab", slab.positions, slab.faces, bsdf=diffuse(0.76, 0.75, 0.73))
    intensity = {"type": "rgb", "value": [bulb, 0.85 * bulb, 0.6 * bulb]}
    description["bulb"] = {"type": "point", "position": list(BULB), "intensity": intensity}
    return Blueprint(description, room.box, rig("caves-in", [_falling(wall)]))


def _falling(wall: float) -> Carried:
    """It turns a little as it falls, and lies flat at last."""
    (x0, z0), (x1, z1) = HOLE
    middle = np.array([(x0 + x1) / 2, HIGH[1] + wall / 2, (z0 + z1) / 2])
    lasts = np.sqrt(2 * HIGH[1] / GRAVITY)
    fall = np.linspace(0, lasts, STEPS + 1)
    times = np.concatenate([[0.0], FALLS_AT + fall, [LASTS]])
    drop = np.concatenate([[0.0], 0.5 * GRAVITY * fall**2, [HIGH[1]]])
    degrees = np.concatenate([[0.0], 9 * np.sin(np.pi * fall / lasts), [0.0]])
    places = middle + drop[:, None] * [0.0, -1.0, FORWARD / HIGH[1]]
    return Carried("slab", times, places, turns_about((0.0, 0.0, 1.0), degrees), shapes=("slab",))
