"""A hundred bright beach balls that tumble through the courtyard (BLOG's moving scene)."""

from __future__ import annotations

import numpy as np

from ddgi.scene.library import geometry
from ddgi.scene.library.blueprint import Blueprint
from ddgi.scene.library.courtyard import courtyard
from ddgi.scene.library.geometry import Array, Triangles
from ddgi.scene.library.ingredients import diffuse
from ddgi.scene.library.moving import Carried, rig
from ddgi.scene.library.tumbling import Yard, tumble
from ddgi.scene.mesh_keys import mesh

RADIUS = 0.3
SECONDS, RATE = 8.0, 60.0
YARD = Yard(
    (-8.6, -2.85),
    (8.6, 2.85),
    # Sculptures on the axis, and pots.
    ((-1.15, 0.0, 0.6), (5.75, 0.0, 0.6), (8.2, 2.5, 0.5), (8.2, -2.5, 0.5), (-8.2, 2.5, 0.5), (-8.2, -2.5, 0.5),
     (2.3, 2.5, 0.5), (-2.3, -2.5, 0.5)),
)  # fmt: skip
COLORS = (
    (0.85, 0.08, 0.06), (0.90, 0.45, 0.04), (0.90, 0.80, 0.05), (0.10, 0.60, 0.12), (0.05, 0.30, 0.80), (0.70, 0.10, 0.55),
)  # fmt: skip
WHITE = (0.85, 0.85, 0.82)
PANELS, RINGS = 6, 6
"""Of a ball, from pole to pole: as many again are white."""


def beach_balls(balls: int = 100, seed: int = 7) -> Blueprint:
    """Build the courtyard with balls in it, and the animation that moves them.

    Args:
        balls: How many.
        seed: Of how they are let go.
    """
    court = courtyard()
    places, turns = tumble(YARD, _start(balls, seed), RADIUS, SECONDS, RATE, seed)
    description, carried = dict(court.description), []
    times = np.arange(len(places)) / RATE
    for number in range(balls):
        # White panels and coloured ones are shapes of their own, which move alike.
        names = (f"ball-{number}", f"ball-{number}-white")
        for name, parity, color in zip(names, (0, 1), (COLORS[number % len(COLORS)], WHITE), strict=True):
            part = geometry.moved(_panels(parity), tuple(places[0, number]))
            description[name] = mesh(
                name, part.positions, part.faces, bsdf=diffuse(*color), normals=part.normals
            )
        carried.append(Carried(f"ball-{number}", times, places[:, number], turns[:, number], shapes=names))
    return Blueprint(description, court.box, rig("tumble", carried))


def _start(balls: int, seed: int) -> Array:
    """(N, 3) places above the court, apart from each other, in layers."""
    rng = np.random.default_rng(seed)
    x, z = np.meshgrid(np.arange(-8.0, 8.1, 1.0), np.arange(-2.0, 2.1, 1.0))
    layer = np.stack([x.ravel(), np.zeros(x.size), z.ravel()], 1)
    free = [
        np.hypot(layer[:, 0] - px, layer[:, 2] - pz) > size + RADIUS + 0.25 for px, pz, size in YARD.posts
    ]
    layer = layer[np.all(free, axis=0)]
    layers = -(-balls // len(layer))
    places = np.concatenate([layer + np.array([0, 2.5 + 1.6 * k, 0]) for k in range(layers)])
    picked = rng.permutation(len(places))[:balls]
    return places[picked] + rng.uniform(-0.15, 0.15, (balls, 3))


def _panels(parity: int) -> Triangles:
    """Every other panel of a ball about the origin, from pole to pole."""
    return geometry.merge(_panel(2 * number + parity) for number in range(PANELS))


def _panel(number: int) -> Triangles:
    theta = np.linspace(0, np.pi, RINGS + 1)[:, None]
    phi = (number + np.arange(2)) * np.pi / PANELS
    normal = np.stack(
        [np.sin(theta) * np.cos(phi), np.cos(theta) + 0 * phi, -np.sin(theta) * np.sin(phi)], -1
    )
    panel = geometry.grid(RADIUS * normal)
    return panel._replace(normals=normal.reshape(-1, 3))
