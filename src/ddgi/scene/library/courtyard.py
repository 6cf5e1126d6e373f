"""A court of two storeys of columns and arches with galleries behind, in the sun.

It stands in for Crytek's Sponza, which may not be shipped: the same problems in the same proportions
(deep galleries lit only by what bounces in, thin cloth in saturated colours, sunlit floor) with more
than 200,000 triangles, all made here.

The court's long side runs along x. Columns stand on a rectangle around the court, one every `BAY`
metres; arcades rest on them; behind lies a gallery on each side and an outer wall without windows.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ddgi.scene.library import geometry
from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.geometry import Array, Triangles, rectangle_profile, rectangular_ring
from ddgi.scene.library.ingredients import camera, diffuse, sheet, sun
from ddgi.scene.mesh_keys import mesh

BAY = 2.3
"""Distance from column to column [m]."""

BAYS = (8, 3)
"""Number of bays along x and z."""

HALF_COURT = (BAY * BAYS[0] / 2, BAY * BAYS[1] / 2)
"""From the middle of the court to the columns' axes along x and z [m]."""

GALLERY = 2.8
"""From the columns' axes to the outer wall's inner face [m]."""

_ARCH = 0.88  # radius of the arches [m]
_ARCADE = 0.25  # half the thickness of the arcades' walls [m]
_OUTER_WALL = 0.4  # thickness [m]
_EAVES = 10.5  # underside of the roof [m]


class Storey(NamedTuple):
    """Heights of one storey [m]."""

    floor: float  # the columns' feet
    spring: float  # the columns' heads, where the arches begin
    top: float  # the upper edge of the arcade's wall


LOWER = Storey(0.0, 3.6, 5.1)
UPPER = Storey(5.5, 8.5, 10.1)


def courtyard(
    sun_direction: Point = (0.45, -1.0, 0.42),
    sun_irradiance: tuple[float, float, float] = (21.0, 20.0, 18.0),
    sky_radiance: tuple[float, float, float] = (0.6, 0.8, 1.2),
) -> Blueprint:
    """Build the courtyard.

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
    half_x, half_z = HALF_COURT[0] + GALLERY, HALF_COURT[1] + GALLERY
    return Blueprint(description, ((-half_x, 0.0, -half_z), (half_x, _EAVES + 0.5, half_z)))


def _materials() -> dict[str, tuple[dict[str, Any], list[Triangles]]]:
    """Material and parts of every mesh, by the mesh's name."""
    light_tiles, dark_tiles = _tiles()
    curtains, rods = _curtains()
    pots, leaves = _plants()
    sculptures, pedestals = _sculptures()
    return {
        "walls": (diffuse(0.72, 0.62, 0.47), [_outer_wall()]),
        "dado": (diffuse(0.47, 0.17, 0.10), list(_dado())),
        "arcades": (diffuse(0.62, 0.55, 0.44), list(_arcades())),
        "columns": (diffuse(0.70, 0.66, 0.57), list(_columns())),
        "trim": (diffuse(0.74, 0.70, 0.62), [*_mouldings(), *_balustrades(), *pedestals]),
        "ceilings": (diffuse(0.56, 0.50, 0.42), [_gallery_slab(), *_ribs()]),
        "roof": (diffuse(0.50, 0.23, 0.13), [_roof()]),
        "floor": (diffuse(0.36, 0.28, 0.21), [_base()]),
        "tiles-light": (diffuse(0.58, 0.52, 0.43), [light_tiles]),
        "tiles-dark": (diffuse(0.30, 0.24, 0.19), [dark_tiles]),
        "wood": (diffuse(0.24, 0.14, 0.08), [*_doors(), *rods]),
        "curtains-red": (sheet(0.56, 0.05, 0.04), curtains[0::3]),
        "curtains-green": (sheet(0.08, 0.34, 0.11), curtains[1::3]),
        "curtains-blue": (sheet(0.06, 0.14, 0.48), curtains[2::3]),
        "pots": (diffuse(0.48, 0.20, 0.11), pots),
        "leaves": (diffuse(0.12, 0.27, 0.06), leaves),
        "sculptures": (diffuse(0.76, 0.74, 0.70), sculptures),
        "ground": (diffuse(0.36, 0.31, 0.22), [geometry.box((-45, -1.3, -45), (45, -0.3, 45))]),
    }


# The shell ------------------------------------------------------------------------------------------


def _outer_wall() -> Triangles:
    """Around all four sides, from the ground to the roof."""
    return rectangular_ring(*HALF_COURT, rectangle_profile((GALLERY, -0.5), (GALLERY + _OUTER_WALL, _EAVES)))


def _dado() -> Iterator[Triangles]:
    """A painted band along the foot of the outer wall, in both storeys."""
    for storey in (LOWER, UPPER):
        band = rectangle_profile((GALLERY - 0.02, storey.floor), (GALLERY + 0.1, storey.floor + 1.1))
        yield rectangular_ring(*HALF_COURT, band)


def _base() -> Triangles:
    """The slab under everything; its top shows in the galleries, and as joints between the court's tiles."""
    x, z = HALF_COURT[0] + GALLERY + 0.2, HALF_COURT[1] + GALLERY + 0.2
    return geometry.box((-x, -0.5, -z), (x, 0.0, z))


def _gallery_slab() -> Triangles:
    """The upper gallery's floor and the lower one's ceiling; it ends inside wall and arcade."""
    return rectangular_ring(
        *HALF_COURT, rectangle_profile((-_ARCADE, LOWER.top), (GALLERY + 0.2, UPPER.floor))
    )


def _roof() -> Triangles:
    """A lean-to roof on each side that falls towards the court."""
    inner, outer = -_ARCADE - 0.35, GALLERY + _OUTER_WALL + 0.3
    return rectangular_ring(
        *HALF_COURT,
        np.array([(inner, _EAVES), (outer, _EAVES), (outer, _EAVES + 1.1), (inner, _EAVES + 0.12)]),
    )


def _ribs() -> Iterator[Triangles]:
    """Beams under both ceilings, from each column to the outer wall."""
    for ceiling in (LOWER.top, _EAVES):
        low, high = ceiling - 0.3, ceiling + 0.05
        for place, towards in _column_places():
            outwards, across = np.array([towards[0], 0, towards[1]]), np.array([towards[1], 0, towards[0]])
            foot = np.array([place[0], 0, place[1]])
            ends = np.stack(
                [foot + 0.2 * outwards + 0.14 * across, foot + (GALLERY + 0.1) * outwards - 0.14 * across]
            )
            ends[:, 1] = low, high
            yield geometry.box(ends.min(0), ends.max(0))


def _tiles() -> tuple[Triangles, Triangles]:
    """The court's floor as two sets of slabs, laid as a chequerboard with open joints."""
    size, joint, height = BAY / 2, 0.008, 0.015
    half = [h - _ARCADE - 0.2 for h in HALF_COURT]
    counts = [round(2 * h / size) for h in half]
    step = [2 * h / n for h, n in zip(half, counts, strict=True)]
    tile = geometry.box(
        (-step[0] / 2 + joint, -0.02, -step[1] / 2 + joint),
        (step[0] / 2 - joint, height, step[1] / 2 - joint),
    )
    i, j = (k.ravel() for k in np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"))
    centres = np.stack([(i + 0.5) * step[0] - half[0], np.zeros(len(i)), (j + 0.5) * step[1] - half[1]], 1)
    odd = (i + j) % 2 == 1
    return geometry.copies(tile, centres[~odd]), geometry.copies(tile, centres[odd])


def _doors() -> Iterator[Triangles]:
    """Wooden doors on the galleries' outer walls, both storeys, long sides."""
    inner = HALF_COURT[1] + GALLERY
    for storey in (LOWER, UPPER):
        for side in (-1, 1):
            for x in BAY * np.array([-2.5, 0.5, 2.5]):
                z = sorted((side * (inner - 0.06), side * (inner + 0.05)))
                yield geometry.box((x - 0.55, storey.floor, z[0]), (x + 0.55, storey.floor + 2.3, z[1]))


# Columns and arches ---------------------------------------------------------------------------------


def _column_places() -> Iterator[tuple[tuple[float, float], tuple[int, int]]]:
    """(x, z) of every column but the corner piers, and the way to its outer wall."""
    half_x, half_z = HALF_COURT
    for side in (-1, 1):
        for i in range(1, BAYS[0]):
            yield (BAY * i - half_x, side * half_z), (0, side)
        for j in range(1, BAYS[1]):
            yield (side * half_x, BAY * j - half_z), (side, 0)


def _column(height: float) -> Triangles:
    """A fluted column of this height on y = 0: plinth, base, shaft, capital, abacus [m]."""
    foot, head, radius = 0.12, height - 0.12, 0.20
    torus = [(0.27 + 0.03 * np.sin(a), foot + 0.045 - 0.045 * np.cos(a)) for a in np.linspace(0, np.pi, 5)]
    scotia = [(0.25, foot + 0.09), (0.25, foot + 0.09), (0.222, foot + 0.115), (0.23, foot + 0.15)]
    upper_torus = [
        (0.23 + 0.018 * np.sin(a), foot + 0.175 - 0.025 * np.cos(a)) for a in np.linspace(0, np.pi, 4)
    ]
    base = [(0.0, foot), (0.27, foot), *torus, *scotia, *upper_torus]
    shaft_foot, shaft_head = foot + 0.21, head - 0.36
    rise = np.linspace(0, 1, 6)
    shaft = [(radius + 0.01 - 0.03 * t**1.6, shaft_foot + t * (shaft_head - shaft_foot)) for t in rise]
    neck = shaft_head + 0.02
    ring = [(0.185 + 0.02 * np.sin(a), neck + 0.02 - 0.02 * np.cos(a)) for a in np.linspace(0, np.pi, 4)]
    bell = [(0.18 + 0.11 * t**2.2, neck + 0.05 + t * (head - neck - 0.05)) for t in np.linspace(0, 1, 5)]
    profile = np.array([*base, *shaft, *ring, *bell, (bell[-1][0], head), (0.0, head)])
    fluting = np.zeros(len(profile))
    fluting[len(base) + 1 : len(base) + len(shaft) - 1] = 0.022
    turned = geometry.lathe(profile, 64, flutes=16, fluting=fluting)
    plinth = geometry.box((-0.31, 0, -0.31), (0.31, foot, 0.31))
    abacus = geometry.box((-0.31, head, -0.31), (0.31, height, 0.31))
    return geometry.merge([plinth, turned, abacus])


def _columns() -> Iterator[Triangles]:
    """All columns, and square piers in the corners."""
    places = np.array([place for place, _ in _column_places()])
    for storey in (LOWER, UPPER):
        feet = np.stack([places[:, 0], np.full(len(places), storey.floor), places[:, 1]], 1)
        yield geometry.copies(_column(storey.spring - storey.floor), feet)
    pier = 0.32
    for x in (-HALF_COURT[0], HALF_COURT[0]):
        for z in (-HALF_COURT[1], HALF_COURT[1]):
            for storey in (LOWER, UPPER):
                yield geometry.box((x - pier, storey.floor, z - pier), (x + pier, storey.top, z + pier))


def _sides() -> Iterator[tuple[float, float, Array]]:
    """The court's four sides: turn about +y [degrees], distance of the columns [m], arches' centres [m].

    Built facing the court from +z and then turned, so that a side's own x runs along it.
    """
    for degrees in (0, 90, 180, 270):
        long = degrees % 180 == 0
        count, distance = (BAYS[0], HALF_COURT[1]) if long else (BAYS[1], HALF_COURT[0])
        yield degrees, distance, np.array([BAY * (i - (count - 1) / 2) for i in range(count)])


def _arcades() -> Iterator[Triangles]:
    """The walls on the columns, pierced by arches."""
    for degrees, distance, centres in _sides():
        for storey in (LOWER, UPPER):
            # The upper wall reaches into the roof, the lower one ends at the slab.
            top = storey.top if storey is LOWER else _EAVES
            z = (-distance - _ARCADE, -distance + _ARCADE)
            wall = geometry.arcade(list(centres), _ARCH, BAY, storey.spring, top, z)
            yield geometry.turned(wall, degrees)


def _mouldings() -> Iterator[Triangles]:
    """A rounded band around every arch, and string courses around the court."""
    angle = np.linspace(0, np.pi, 6)
    half_round = np.stack([0.055 + 0.055 * np.cos(angle), 0.06 * np.sin(angle) - 0.01], 1)
    half_round = half_round[[0, *range(len(angle)), -1]]  # sharp edges where it meets the wall
    band = geometry.arch(_ARCH + 0.01, half_round, segments=32)
    for degrees, distance, centres in _sides():
        for storey in (LOWER, UPPER):
            height = np.full_like(centres, storey.spring)
            front = np.stack([centres, height, np.full_like(centres, -distance + _ARCADE)], 1)
            yield geometry.turned(geometry.copies(band, front), degrees)
    inner = -_ARCADE
    for low, high, out in ((LOWER.top - 0.02, UPPER.floor + 0.04, 0.14), (UPPER.top - 0.1, _EAVES, 0.2)):
        middle = (low + high) / 2
        profile = [
            (inner - out, high),
            (inner - out, high - 0.1),
            (inner - 0.6 * out, middle),
            (inner - 0.25 * out, low),
        ]
        yield rectangular_ring(*HALF_COURT, np.array([*profile, (inner + 0.05, low), (inner + 0.05, high)]))


def _balustrades() -> Iterator[Triangles]:
    """Turned balusters and a rail in every bay of the upper storey."""
    height, radius = 0.72, [0.055, 0.055, 0.028, 0.062, 0.05, 0.024, 0.024, 0.045]
    at = [0.0, 0.06, 0.10, 0.28, 0.40, 0.56, 0.64, 0.72]
    baluster = geometry.lathe(np.array([(0.0, 0.0), *zip(radius, at, strict=True), (0.0, height)]), 10)
    offsets = np.linspace(-0.75, 0.75, 7)
    for degrees, distance, centres in _sides():
        x = (centres[:, None] + offsets).ravel()
        feet = np.stack([x, np.full_like(x, UPPER.floor + 0.06), np.full_like(x, -distance)], 1)
        yield geometry.turned(geometry.copies(baluster, feet), degrees)
        end = centres[-1] + BAY / 2
        for low, high, half in ((0.0, 0.07, 0.09), (0.06 + height - 0.01, 0.06 + height + 0.08, 0.11)):
            rail = geometry.box(
                (-end, UPPER.floor + low, -distance - half), (end, UPPER.floor + high, -distance + half)
            )
            yield geometry.turned(rail, degrees)


# What stands and hangs in it ------------------------------------------------------------------------


def _curtains() -> tuple[list[Triangles], list[Triangles]]:
    """Curtains (colours repeat every three) and the rods they hang from."""
    curtains, rods = [], []
    to_the_court = {-1: 0.0, 1: 180.0}
    # In the lower arcades, drawn to one side; and long banners over the upper balustrade.
    for side in (-1, 1):
        for k, bay in enumerate((-3, -2, 0, 1, 3) if side < 0 else (-3, -1, 0, 2, 3)):
            x = BAY * (bay - 0.5)
            drawn = 0.28 * (-1 if k % 2 else 1)
            hung = geometry.cloth(1.15, 3.15, folds=7, depth=0.075, cells=(64, 32))
            place = (x + drawn, LOWER.spring - 0.14, side * HALF_COURT[1])
            curtains.append(geometry.moved(geometry.turned(hung, to_the_court[side]), place))
            rods.append(_rod(x, LOWER.spring - 0.12, side * HALF_COURT[1], BAY - 0.36))
    for side in (-1, 1):
        for bay in (-2, 0, 2) if side < 0 else (-1, 1, 3):
            x = BAY * (bay - 0.5)
            z = side * (HALF_COURT[1] - _ARCADE - 0.24)
            banner = geometry.cloth(1.0, 2.0, folds=2.5, depth=0.04, cells=(40, 28))
            place = (x, UPPER.floor + 0.02, z)
            curtains.append(geometry.moved(geometry.turned(banner, to_the_court[side]), place))
            rods.append(_rod(x, UPPER.floor + 0.03, z, 1.1))
    return curtains, rods


def _rod(x: float, y: float, z: float, length: float) -> Triangles:
    """A thin bar along x about (x, y, z)."""
    rod = geometry.cylinder(0.022, length, 12)
    turn = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1.0]])  # +y to +x
    assert rod.normals is not None
    lying = rod._replace(positions=rod.positions @ turn.T, normals=rod.normals @ turn.T)
    return geometry.moved(lying, (x - length / 2, y, z))


def _plants() -> tuple[list[Triangles], list[Triangles]]:
    """Terracotta pots and the bushes in them."""
    outline = [(0.20, 0.0), (0.30, 0.38), (0.34, 0.38), (0.34, 0.46), (0.29, 0.46), (0.28, 0.38)]
    profile = [(0.0, 0.0), *(point for point in outline for _ in range(2)), (0.0, 0.38)]  # all edges sharp
    pot = geometry.lathe(np.array(profile), 40)
    x, z = HALF_COURT[0] - 1.0, HALF_COURT[1] - 0.95
    places = [(sx * x, 0.015, sz * z) for sx in (-1, 1) for sz in (-1, 1)]
    places += [(sx * BAY, 0.015, sz * z) for sx, sz in ((-1, -1), (1, 1))]
    bushes = [
        geometry.moved(geometry.blob(0.42, bumps=9, amplitude=0.16, seed=i, rings=24), (px, py + 0.78, pz))
        for i, (px, py, pz) in enumerate(places)
    ]
    return [geometry.copies(pot, np.array(places))], bushes


def _sculptures() -> tuple[list[Triangles], list[Triangles]]:
    """Smooth stones on pedestals: on the court's axis, and in the lower gallery's ends."""
    stones, pedestals = [], []
    gallery = HALF_COURT[1] + GALLERY / 2
    for seed, (x, z) in enumerate(((-1.15, 0.0), (5.75, 0.0), (-9.9, -gallery), (9.9, gallery))):
        stone = geometry.blob(0.42, bumps=2.6, amplitude=0.42, seed=20 + seed, rings=32)
        stone = stone._replace(positions=stone.positions * np.array([1, 1.45, 1]))
        stone = geometry.smooth(stone)
        sunk = 1.02 - stone.positions[:, 1].min() - 0.03  # a little into the pedestal, so that it stands
        stones.append(geometry.moved(stone, (x, sunk, z)))
        for half, low, high in ((0.42, 0.0, 0.14), (0.34, 0.14, 0.92), (0.40, 0.92, 1.02)):
            pedestals.append(geometry.box((x - half, low, z - half), (x + half, high, z + half)))
    return stones, pedestals


def _cameras() -> dict[str, Any]:
    """From a corner of the court, along the sunnier lower gallery, and from above the roof."""
    half_x, half_z = HALF_COURT
    return {
        "court": camera((-half_x + 0.9, 1.75, -half_z + 1.2), (half_x - 3.0, 3.9, 1.3), fov=82),
        "gallery": camera((-half_x + 0.6, 1.65, half_z + GALLERY - 0.7), (half_x, 2.0, half_z + 0.8), fov=78),
        "above": camera((0.0, 28.0, -7.5), (0.0, 5.0, 0.6), fov=54),
    }
