"""A broad-leaved wood in summer: a path, a glade, ferns, and the sun through the leaves.

After the forest of the Czech thesis (CTU, Table 7.2 and section 7.1). Probes are known to fail here: light
changes from leaf to leaf, far below any spacing of probes, and distance maps of foliage are mere averages.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ddgi.scene.library import foliage, geometry, rounded
from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.foliage import Tree
from ddgi.scene.library.geometry import Array, Triangles
from ddgi.scene.library.ingredients import camera, diffuse, sheet, sun
from ddgi.scene.mesh_keys import mesh

HALF = 18.0
"""Half the edge of the part that is seen from near, and that probes cover [m]."""

EYE = 1.65
"""Of a walker above the ground [m]."""

GLADE = (5.0, -4.5, 6.5)
"""A place without trees: its middle along x and z, and its radius [m]."""

_FAR = 34.0  # half the edge of the wood [m]
_GROUND = 60.0  # of the ground [m]
_PATH = 1.6  # half the width kept free of trees along the path [m]


def ground_height(x: Array | float, z: Array | float) -> Array:
    """Of the ground at (x, z) [m]."""
    bumps = 0.35 * np.sin(0.21 * x + 0.8) * np.cos(0.17 * z) + 0.18 * np.sin(0.47 * x - 0.39 * z + 1.0)
    small = 0.05 * np.sin(1.3 * x + 0.7 * z) + 0.04 * np.sin(2.1 * z - 1.1 * x + 0.5)
    hollow = -0.12 * np.exp(-((_off_path(x, z) / 0.8) ** 2))
    height: Array = np.asarray(bumps + small + hollow, float)
    return height


def forest(
    sun_direction: Point = (-0.50, -1.0, 0.35),
    sun_irradiance: tuple[float, float, float] = (30.0, 27.5, 23.0),
    sky_radiance: tuple[float, float, float] = (0.9, 1.2, 1.7),
) -> Blueprint:
    """Build the forest.

    Args:
        sun_direction: The way sunlight travels.
        sun_irradiance: Irradiance of a surface that faces the sun [W/m^2].
        sky_radiance: Of the whole sky [W/(m^2 sr)].
    """
    description: dict[str, Any] = {
        "type": "scene",
        **_cameras(),
        "sun": sun(sun_direction, sun_irradiance),
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": list(sky_radiance)}},
    }
    for name, (bsdf, parts) in _materials().items():
        shape = geometry.merge(parts)
        description[name] = mesh(name, shape.positions, shape.faces, bsdf=bsdf, normals=shape.normals)
    return Blueprint(description, ((-HALF, -0.7, -HALF), (HALF, 12.0, HALF)))


def _materials() -> dict[str, tuple[dict[str, Any], list[Triangles]]]:
    """Material and parts of every mesh, by the mesh's name."""
    wood, crowns = _trees()
    near, far = _ground()
    return {
        "bark": (diffuse(0.22, 0.16, 0.11), [*wood, *_log()]),
        "leaves-bright": (sheet(0.28, 0.46, 0.08), crowns[0::3]),
        "leaves-middle": (sheet(0.18, 0.38, 0.07), crowns[1::3]),
        "leaves-dark": (sheet(0.12, 0.30, 0.07), crowns[2::3]),
        "ferns": (sheet(0.20, 0.42, 0.09), list(_ferns())),
        "grass": (sheet(0.26, 0.40, 0.10), [_grass()]),
        "litter": (sheet(0.34, 0.20, 0.09), [_litter()]),
        "stones": (diffuse(0.40, 0.39, 0.36), list(_stones())),
        "soil": (diffuse(0.15, 0.105, 0.06), [near]),
        "trodden": (diffuse(0.30, 0.23, 0.15), [_trodden()]),
        "meadow": (diffuse(0.13, 0.17, 0.06), [far]),
    }


# The ground -----------------------------------------------------------------------------------------


def _path_z(x: Array | float) -> Array | float:
    """Where the path runs: z over x [m]."""
    return 2.2 * np.sin(0.16 * np.asarray(x)) + 1.2


def _off_path(x: Array | float, z: Array | float) -> Array | float:
    """Distance from the path along z [m]."""
    return np.abs(z - _path_z(x))


def _terrain(x: Array, z: Array, lift: float = 0.0) -> Triangles:
    """The ground over (R, C) places, facing up; rows along z, columns along x."""
    return geometry.smooth(geometry.grid(np.stack([x, ground_height(x, z) + lift, z], -1)))


def _ground() -> tuple[Triangles, Triangles]:
    """The wood's floor, and around it a coarser one."""
    axis = np.linspace(-_FAR, _FAR, 161)
    near = _terrain(*np.meshgrid(axis, axis))
    axis = np.linspace(-_GROUND, _GROUND, 61)
    return near, _terrain(*np.meshgrid(axis, axis), lift=-0.5)


def _trodden() -> Triangles:
    """The path: bare earth a little above the soil."""
    x = np.linspace(-_FAR, _FAR, 241)
    half = 0.55 + 0.1 * np.sin(0.9 * x) + 0.06 * np.sin(2.3 * x + 1.0)
    across = np.linspace(-1.0, 1.0, 9)[:, None]
    strip = _terrain(np.broadcast_to(x, (9, 241)), _path_z(x) + half * across, lift=0.03)
    strip.positions[:, 1] -= np.repeat(0.06 * across.ravel() ** 4, 241)  # its rims dip below the soil
    return geometry.smooth(strip)


def _on_ground(places: Array, lift: float = 0.0) -> Array:
    """(N, 3) places at (N, 2) x and z [m]."""
    x, z = places.T
    return np.stack([x, ground_height(x, z) + lift, z], 1)


def _scattered(count: int, half: float, seed: int, keep_off: float) -> Array:
    """(N, 2) random x and z; fewer than `count`, as the path is left free [m]."""
    places = np.random.default_rng(seed).uniform(-half, half, (count, 2))
    return places[_off_path(*places.T) > keep_off]


# Trees ----------------------------------------------------------------------------------------------


def _tree_places(low: float, high: float, spacing: float, seed: int) -> Array:
    """(N, 2) x and z of trees in a square ring, away from the path and the glade [m]."""
    rng = np.random.default_rng(seed)
    axis = np.arange(-high + spacing / 2, high, spacing)
    x, z = (a.ravel() + rng.uniform(-0.32, 0.32, a.size) * spacing for a in np.meshgrid(axis, axis))
    in_glade = np.hypot(x - GLADE[0], z - GLADE[1]) < GLADE[2]
    there = (np.maximum(np.abs(x), np.abs(z)) > low) & (_off_path(x, z) > _PATH) & ~in_glade
    return np.stack([x, z], 1)[there]


def _shrub_places() -> Array:
    """(N, 2) x and z of shrubs, most of them far away, where they close the view between the trunks [m]."""
    near = _scattered(36, HALF, 16, 3.0)
    near = near[np.hypot(*(near - GLADE[:2]).T) > GLADE[2] + 3.0]
    return np.concatenate([near, _tree_places(HALF - 2, _FAR, 4.4, 17)])


def _trees() -> tuple[list[Triangles], list[Triangles]]:
    """Wood and crowns of trees and shrubs; trees far away have fewer and larger leaves."""
    rng = np.random.default_rng(8)
    near = [foliage.tree(9.5 + 0.9 * k, 3.1 + 0.2 * k, 2200, 0.38, seed=k) for k in range(4)]
    far = [foliage.tree(10.0 + k, 3.5, 400, 0.92, seed=20 + k, boughs=9, near=False) for k in range(3)]
    shrubs = [
        foliage.tree(2.3 + 0.5 * k, 1.5, 260, 0.36, seed=40 + k, boughs=9, near=False) for k in range(3)
    ]
    wood: list[Triangles] = []
    crowns: list[Triangles] = []
    for kinds, places in (
        (near, _tree_places(0.0, HALF, 4.2, 1)),
        (far, _tree_places(HALF, _FAR, 5.0, 2)),
        (shrubs, _shrub_places()),
    ):
        for number, place in enumerate(_on_ground(places)):
            standing = _stand(kinds[number % len(kinds)], place, rng)
            wood.append(standing.wood)
            crowns.append(standing.leaves)
    return wood, crowns


def _stand(tree: Tree, place: Array, rng: np.random.Generator) -> Tree:
    """A tree turned, grown a little and put on its place [m]."""
    degrees, size = rng.uniform(0, 360), rng.uniform(0.88, 1.12)

    def put(part: Triangles) -> Triangles:
        grown = part._replace(positions=part.positions * size)
        return geometry.moved(geometry.turned(grown, degrees), place)

    return Tree(put(tree.wood), put(tree.leaves))


def _log() -> Iterator[Triangles]:
    """A fallen trunk beside the glade."""
    t = np.linspace(0, 1, 12)
    x, z = 0.8 + 4.2 * t, -4.4 + 1.3 * t
    path = np.stack([x, ground_height(x, z) + 0.2 - 0.06 * t, z], 1)
    yield rounded.tube(path, 0.27 - 0.09 * t, 20)


# What grows and lies below --------------------------------------------------------------------------


def _ferns() -> Iterator[Triangles]:
    kinds = [foliage.fern(leaflets=11, length=0.85 + 0.15 * k, seed=k) for k in range(3)]
    places = _on_ground(_scattered(260, HALF, 4, 1.0))
    rng = np.random.default_rng(6)
    for number, place in enumerate(places):
        yield geometry.moved(geometry.turned(kinds[number % 3], rng.uniform(0, 360)), place)


def _grass() -> Triangles:
    """Tufts of blades, most of them in the glade."""
    rng = np.random.default_rng(9)
    in_glade = np.array(GLADE[:2]) + rng.normal(0, 0.55 * GLADE[2], (700, 2))
    tufts = np.concatenate([in_glade[_off_path(*in_glade.T) > 0.8], _scattered(500, HALF, 10, 0.9)])
    blades = 12
    roots = np.repeat(tufts, blades, 0) + rng.normal(0, 0.07, (blades * len(tufts), 2))
    along = rng.normal(0, 0.4, (len(roots), 3)) * (1, 0, 1) + (0, 1, 0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    up = rng.normal(size=along.shape)
    return foliage.leaves(_on_ground(roots, -0.02), along, up, rng.uniform(0.16, 0.42, len(roots)), 0.07)


def _litter() -> Triangles:
    """Last year's leaves on the soil."""
    rng = np.random.default_rng(12)
    places = _on_ground(_scattered(14000, HALF, 13, 0.0), 0.02)
    along = rng.normal(size=places.shape) * (1, 0.12, 1)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    up = rng.normal(size=places.shape) * 0.3 + (0, 1, 0)
    return foliage.leaves(places, along, up, rng.uniform(0.09, 0.19, len(places)), 0.6)


def _stones() -> Iterator[Triangles]:
    """Half sunk boulders."""
    rng = np.random.default_rng(14)
    for number, place in enumerate(_on_ground(_scattered(34, HALF, 15, 1.1))):
        stone = geometry.blob(rng.uniform(0.15, 0.5), bumps=2.2, amplitude=0.3, seed=80 + number, rings=16)
        flat = geometry.smooth(stone._replace(positions=stone.positions * np.array([1, 0.65, 1])))
        yield geometry.moved(flat, place)


def _cameras() -> dict[str, Any]:
    """At eye height along the path, from the shade into the glade, up into the crowns; and from above."""

    def standing(x: float, z: float) -> Point:
        return (x, float(ground_height(x, z)) + EYE, z)

    along = float(np.asarray(_path_z(-9.5)))
    return {
        "path": camera(standing(-9.5, along), (1.0, 1.9, -1.6), fov=70),
        "glade": camera(standing(-1.2, -0.6), (6.5, 1.2, -4.6), fov=74),
        "crowns": camera(standing(-4.0, float(np.asarray(_path_z(-4.0)))), (1.0, 9.0, -2.0), fov=80),
        "overview": camera((-13.0, 27.0, 10.0), (4.0, 0.0, -4.0), fov=60),
    }
