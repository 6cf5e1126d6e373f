"""Leaves as thin folded rhombi, and trees that carry them. Metres, +y up.

A leaf is an open sheet: its material must have two sides.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ddgi.scene.library.geometry import Array, Triangles, merge
from ddgi.scene.library.rounded import tube

_GOLDEN = np.pi * (3 - np.sqrt(5))  # turn from one branch to the next [rad]


class Tree(NamedTuple):
    """One tree on the origin."""

    wood: Triangles
    leaves: Triangles


def leaves(
    base: Array, along: Array, up: Array, length: Array, width: float = 0.5, fold: float = 0.2
) -> Triangles:
    """Many leaves, two triangles each, folded along the middle.

    Args:
        base: (N, 3) where they begin [m].
        along: (N, 3) unit vectors towards their tips.
        up: (N, 3) roughly where their upper sides point; must not be parallel to `along`.
        length: (N,) [m].
        width: As a share of the length.
        fold: Height of the rims above the middle, as a share of the width.
    """
    beside = np.cross(along, up)
    beside /= np.maximum(np.linalg.norm(beside, axis=1, keepdims=True), 1e-20)
    above = np.cross(beside, along)
    size = np.asarray(length)[:, None]
    rim = base + size * (0.45 * along + width * fold * above)
    corners = [
        base,
        rim + 0.5 * width * size * beside,
        base + size * along,
        rim - 0.5 * width * size * beside,
    ]
    one = np.array([[0, 1, 2], [0, 2, 3]])
    faces = (one[None] + 4 * np.arange(len(base))[:, None, None]).reshape(-1, 3)
    return Triangles(np.stack(corners, 1).reshape(-1, 3), faces)


def fern(fronds: int = 9, leaflets: int = 14, length: float = 0.8, seed: int = 0) -> Triangles:
    """A fern on the origin: fronds that arch outwards, with leaflets on both sides.

    Args:
        fronds: How many.
        leaflets: On each side of a frond.
        length: Of a frond [m].
        seed: Which fern.
    """
    rng = np.random.default_rng(seed)
    azimuth = 2 * np.pi * (np.arange(fronds) + rng.uniform(-0.3, 0.3, fronds)) / fronds
    size = length * rng.uniform(0.7, 1.1, fronds)
    t = np.linspace(0.12, 1.0, leaflets)
    out = np.stack([np.sin(azimuth), np.zeros(fronds), np.cos(azimuth)], 1)
    reach, rise = 0.75 * t**1.1, 1.1 * t - 0.85 * t**2.2
    place = size[:, None, None] * (reach[:, None] * out[:, None] + rise[:, None] * np.array([0, 1.0, 0]))
    beside = np.cross(out, (0, 1.0, 0))
    shape = (fronds, leaflets, 3)
    ahead = np.broadcast_to(0.45 * out[:, None], shape)
    both = [ahead + side * beside[:, None] - np.array([0, 0.15, 0]) for side in (-1, 1)]
    along = np.concatenate([side.reshape(-1, 3) for side in both])
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    taper = np.broadcast_to(
        0.30 * size[:, None] * np.sin(np.pi * (0.12 + 0.86 * t)) + 0.02, shape[:2]
    ).ravel()
    up = np.broadcast_to((0, 1.0, 0), along.shape)
    return leaves(np.tile(place.reshape(-1, 3), (2, 1)), along, up, np.tile(taper, 2), 0.28)


def tree(
    height: float,
    crown: float,
    leaf_count: int,
    leaf: float,
    seed: int = 0,
    boughs: int = 16,
    *,
    near: bool = True,
) -> Tree:
    """A broad-leaved tree on the origin; its roots reach 0.4 m below.

    Args:
        height: Of the trunk's tip [m].
        crown: Radius of the crown [m].
        leaf_count: How many leaves.
        leaf: Mean length of a leaf [m].
        seed: Which tree.
        boughs: Branches that grow from the trunk.
        near: Whether to be seen from near, with twigs and round wood.
    """
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, 14 if near else 7)
    sway = rng.normal(0, 0.018 * height, 2)[:, None] * np.sin(np.pi * t * rng.uniform(0.8, 1.6)) * t
    trunk = np.stack([sway[0], -0.4 + (height + 0.4) * t, sway[1]], 1)
    girth = 0.026 * height
    thick = girth * ((1 - t) ** 0.8 + 0.05) + 0.5 * girth * np.exp(-((trunk[:, 1] + 0.4) / 0.35))
    wood, all_twigs = [tube(trunk, thick, 10 if near else 6)], []
    joints, sides = (np.array([0, 1, 3, 5]), 6) if near else (np.array([0, 2, 5]), 3)
    slender = np.array([0.55, 0.42, 0.3, 0.2, 0.1, 0.03])
    for k in range(boughs):
        share = 0.34 + 0.62 * (k + rng.uniform(-0.3, 0.3)) / boughs
        start = np.array([np.interp(share, t, trunk[:, axis]) for axis in range(3)])
        reach = crown * np.sqrt(np.clip(1.15 - ((share - 0.5) / 0.6) ** 2, 0.05, 1)) * rng.uniform(0.75, 1.05)
        bough = _branch(start, _GOLDEN * k, rng.uniform(0.25, 0.7) + 0.5 * share, reach, rng)
        wood.append(tube(bough[joints], np.interp(share, t, thick) * slender[joints], sides))
        ahead = np.arctan2(*(bough[-1] - bough[0])[[0, 2]])
        for along in (2, 3, 4, 5):
            twig = _branch(
                bough[along], ahead + rng.uniform(-1.3, 1.3), rng.uniform(0.0, 0.8), 0.4 * reach, rng
            )
            all_twigs.append(twig)
            if near:
                wood.append(tube(twig[[0, 3, 5]], np.array([0.018, 0.011, 0.004]), 3))
    return Tree(merge(wood), _leaves_on(np.array(all_twigs), leaf_count, leaf, rng))


def _branch(start: Array, azimuth: float, elevation: float, reach: float, rng: np.random.Generator) -> Array:
    """(6, 3) points of a branch that bends upwards and wanders a little [m]; angles [rad]."""
    t = np.linspace(0.0, 1.0, 6)[:, None]
    level = np.array([np.sin(azimuth), 0.0, np.cos(azimuth)])
    rise = np.sin(elevation) * t + 0.18 * t**2
    path = start + reach * (np.cos(elevation) * t * level + rise * np.array([0, 1.0, 0]))
    return path + 0.05 * reach * t * rng.normal(size=(6, 3))


def _leaves_on(twigs: Array, count: int, size: float, rng: np.random.Generator) -> Triangles:
    """Leaves around (N, 6, 3) twigs, most of them lying rather flat."""
    which, at = rng.integers(len(twigs), size=count), 5 * np.sqrt(rng.uniform(size=count))
    before = np.minimum(at.astype(int), 4)
    part = (at - before)[:, None]
    on = (1 - part) * twigs[which, before] + part * twigs[which, before + 1]
    spread = 0.9 * size * rng.normal(size=(count, 3))
    along = rng.normal(size=(count, 3)) * (1, 0.45, 1) - (0, 0.25, 0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    up = rng.normal(size=(count, 3)) * 0.55 + (0, 1, 0)
    return leaves(on + spread, along, up, size * rng.uniform(0.65, 1.3, count))
