"""A vaulted church with a high nave, two aisles and an apse; the sun comes in through narrow windows.

It stands in for the cathedral of Sibenik, which may not be shipped: thick walls, most of the light
indirect, and a red carpet that tints it.

The nave runs along x from the west front at -x to the apse at +x, one bay every `BAY` metres. Columns
stand between the nave and its aisles at +z and -z. The windows have no glass.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ddgi.scene.library import geometry, rounded, vaulting
from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.geometry import Array, Triangles
from ddgi.scene.library.ingredients import camera, diffuse, sheet, sun
from ddgi.scene.mesh_keys import mesh

BAY = 5.0
"""Distance from column to column along x [m]."""

BAYS = 6
"""Number of bays along the nave."""

HALF_LENGTH = BAY * BAYS / 2
"""From the middle to the west front's inner face, and to where the apse begins [m]."""

HALF_NAVE = 3.65
"""From the axis to the inner faces of the nave's walls, and the radius of the apse [m]."""

HALF_WIDTH = 8.0
"""From the axis to the inner faces of the aisles' outer walls [m]."""

SPRING = 11.5
"""Height at which the nave's vault begins [m]."""

CROWN = SPRING + HALF_NAVE
"""Height of the nave's vault [m]."""

_WALL = 0.7  # thickness of the nave's walls [m]
_OUTER = 0.8  # of all others [m]
_COLUMN = 4.5  # height of the columns, where the aisles' vaults begin [m]
_ARCH = 2.0  # radius of the arches between them [m]
_AISLE_TOP = 7.2  # upper side of the aisles' vaults [m]
_STRING = 8.1  # height of the string course below the upper windows [m]
_EAVES = 16.0  # upper side of the nave's vault [m]
_STEPS = 10.0  # where the choir's steps begin along x [m]
_CHOIR = 0.48  # height of the choir's floor [m]
_WINDOW_STEP = 0.3  # longest flat piece of the bent wall [m]


def cathedral(
    sun_direction: Point = (-0.34, -1.0, -0.45),
    sun_irradiance: tuple[float, float, float] = (60.0, 54.0, 44.0),
    sky_radiance: tuple[float, float, float] = (2.1, 2.7, 3.7),
) -> Blueprint:
    """Build the cathedral.

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
    return Blueprint(
        description, ((-HALF_LENGTH, 0.0, -HALF_WIDTH), (HALF_LENGTH + HALF_NAVE, CROWN, HALF_WIDTH))
    )


def _materials() -> dict[str, tuple[dict[str, Any], list[Triangles]]]:
    """Material and parts of every mesh, by the mesh's name."""
    light_tiles, dark_tiles = _tiles()
    gold = {
        "type": "roughconductor",
        "material": "Au",
        "alpha": 0.25,
        "distribution": "ggx",
    }
    return {
        "walls": (diffuse(0.66, 0.60, 0.50), [*_nave_walls(), *_aisle_walls(), *_west_front(), *_apse()]),
        "vaults": (diffuse(0.70, 0.66, 0.58), list(_vaults())),
        "columns": (diffuse(0.62, 0.57, 0.49), [*_columns(), *_shafts()]),
        "ribs": (diffuse(0.58, 0.53, 0.45), [*_ribs(), *_mouldings(), *_tracery()]),
        "roof": (diffuse(0.42, 0.20, 0.13), list(_roofs())),
        "floor": (diffuse(0.25, 0.22, 0.19), [_base(), *_choir()]),
        "tiles-light": (diffuse(0.55, 0.50, 0.43), [light_tiles]),
        "tiles-dark": (diffuse(0.33, 0.23, 0.18), [dark_tiles]),
        "carpet": (diffuse(0.52, 0.03, 0.03), list(_carpet())),
        "pews": (diffuse(0.27, 0.15, 0.08), [*_pews(), *_doors()]),
        "altar": (diffuse(0.62, 0.59, 0.54), list(_altar())),
        "altar-cloth": (sheet(0.78, 0.76, 0.72), list(_altar_cloth())),
        "gold": (gold, list(_gold())),
        "ground": (diffuse(0.30, 0.29, 0.20), [geometry.box((-70, -1.5, -70), (70, -0.5, 70))]),
    }


# The shell ------------------------------------------------------------------------------------------


def _bay_middles() -> list[float]:
    """Along x [m]."""
    return [BAY * (i - (BAYS - 1) / 2) for i in range(BAYS)]


def _both_sides(shape: Triangles) -> Iterator[Triangles]:
    """What is built at -z and faces +z, there and turned to the other side."""
    yield shape
    yield geometry.turned(shape, 180)


def _nave_walls() -> Iterator[Triangles]:
    """Arches on columns, and above them a wall with a large window in every bay."""
    end = HALF_LENGTH + 0.4  # inside the walls at the ends
    z = (-HALF_NAVE - _WALL, -HALF_NAVE)
    yield from _both_sides(geometry.arcade(_bay_middles(), _ARCH, BAY, _COLUMN, _STRING + 0.05, z))
    yield from _both_sides(
        vaulting.windowed_wall(
            (-end, end), (_STRING, _EAVES), z, _bay_middles(), (0.85, 1.05), (8.9, 8.5), 11.3
        )
    )


def _aisle_walls() -> Iterator[Triangles]:
    """Long outer walls with a window in every bay, and their short ends beside the apse."""
    end = HALF_LENGTH + _OUTER
    z = (-HALF_WIDTH - _OUTER, -HALF_WIDTH)
    half, sill, spring = (0.5, 0.75), (2.5, 2.2), 4.9
    yield from _both_sides(
        vaulting.windowed_wall((-end, end), (-0.7, _AISLE_TOP), z, _bay_middles(), half, sill, spring)
    )
    middle, inside = (HALF_WIDTH + HALF_NAVE + _WALL) / 2, HALF_NAVE + 0.3
    for side in (-1, 1):
        span = sorted((side * inside, side * (HALF_WIDTH + 0.1)))
        wall = vaulting.windowed_wall(
            (span[0], span[1]), (-0.7, _AISLE_TOP), (-_OUTER, 0.0), [side * middle], half, sill, spring
        )
        yield geometry.moved(geometry.turned(wall, -90), (HALF_LENGTH, 0, 0))


def _west_front() -> Iterator[Triangles]:
    """The end at -x, with a round window high up."""
    radius, height = _rose()
    angle = np.linspace(np.pi, 0.0, 49)
    half = HALF_NAVE + 0.65
    x = np.concatenate([[-half], radius * np.cos(angle), [half]])
    bow = np.concatenate([[0.0], radius * np.sin(angle), [0.0]])
    z = (-_OUTER, 0.0)
    lower = geometry.slab_between(x, np.full_like(x, -0.7), height - bow, z)
    overlap = np.where(bow == 0, 0.05, 0.0)
    upper = geometry.slab_between(x, height + bow - overlap, np.full_like(x, _EAVES), z)
    aisles = [
        geometry.box((side * 6.2 - 2.6, -0.7, -_OUTER), (side * 6.2 + 2.6, _AISLE_TOP, 0)) for side in (-1, 1)
    ]
    for part in (lower, upper, *aisles):
        yield geometry.moved(geometry.turned(part, 90), (-HALF_LENGTH, 0, 0))


def _rose() -> tuple[float, float]:
    """Radius of the round window and height of its middle [m]."""
    return 1.9, 10.6


def _apse() -> Iterator[Triangles]:
    """Half a cylinder with five tall windows, the half dome on it, and the gable over that."""
    span = np.pi / 2 * HALF_NAVE
    wall = vaulting.windowed_wall(
        (-span, span), (-0.7, SPRING + 0.2), (-_OUTER, 0.0), [HALF_NAVE * np.radians(turn) for turn in (-66, -33, 0, 33, 66)],
        (0.42, 0.52), (4.2, 3.9), 8.8, step=_WINDOW_STEP,
    )  # fmt: skip
    yield geometry.moved(geometry.turned(vaulting.bent(wall, HALF_NAVE), -90), (HALF_LENGTH, 0, 0))
    yield geometry.moved(vaulting.half_dome(HALF_NAVE, HALF_NAVE + _OUTER), (HALF_LENGTH, SPRING, 0))
    inside_dome = HALF_NAVE + 0.35
    gable = geometry.arcade([0.0], inside_dome, 2 * (HALF_NAVE + _WALL), SPRING, _EAVES, (-_OUTER, 0.0))
    yield geometry.moved(geometry.turned(gable, -90), (HALF_LENGTH, 0, 0))


def _vaults() -> Iterator[Triangles]:
    """Over the nave and both aisles."""
    bays = _bay_middles()
    yield vaulting.groin_vault(bays, (BAY / 2, HALF_NAVE), SPRING, HALF_NAVE, _EAVES)
    inner = HALF_NAVE + _WALL
    half, middle = (HALF_WIDTH - inner) / 2, (HALF_WIDTH + inner) / 2
    aisle = vaulting.groin_vault(bays, (BAY / 2, half), _COLUMN, _ARCH, _AISLE_TOP)
    for side in (-1, 1):
        yield geometry.moved(aisle, (0, 0, side * middle))


def _roofs() -> Iterator[Triangles]:
    """A saddle roof on the nave, lean-to roofs on the aisles."""

    def roof(z: list[float], height: list[float], foot: float) -> Triangles:
        x = np.array([-HALF_LENGTH - _OUTER - 0.3, HALF_LENGTH + _OUTER + 0.3])
        lower = np.stack(np.broadcast_arrays(x, foot, np.array(z)[:, None]), -1)
        upper = lower.copy()
        upper[..., 1] = np.array(height)[:, None]
        return vaulting.between(lower, upper)

    eaves = HALF_NAVE + _WALL + 0.5
    yield geometry.flat(roof([-eaves, 0, eaves], [_EAVES + 0.1, _EAVES + 3.4, _EAVES + 0.1], _EAVES - 0.01))
    outer, inner = HALF_WIDTH + _OUTER + 0.4, HALF_NAVE + 0.2
    lean_to = geometry.flat(roof([-outer, -inner], [_AISLE_TOP + 0.1, _STRING + 0.1], _AISLE_TOP - 0.01))
    yield from _both_sides(lean_to)


def _mouldings() -> Iterator[Triangles]:
    """Rounded bands around the arches, and string courses along the nave."""
    angle = np.linspace(0, np.pi, 7)
    half_round = np.stack([0.1 + 0.1 * np.cos(angle), 0.1 * np.sin(angle) - 0.01], 1)
    half_round = half_round[[0, *range(len(angle)), -1]]  # sharp edges where it meets the wall
    band = geometry.arch(_ARCH, half_round, segments=48)
    window = geometry.arch(1.05, 0.7 * half_round, segments=32)
    for shape, height in ((band, _COLUMN), (window, 11.3)):
        places = np.array([(x, height, -HALF_NAVE) for x in _bay_middles()])
        yield from _both_sides(geometry.copies(shape, places))
    end = HALF_LENGTH + 0.2
    for height, out in ((_STRING, 0.16), (7.0, 0.1)):
        course = rounded.rounded_box(
            (-end, height - 0.13, -HALF_NAVE - 0.2), (end, height + 0.13, -HALF_NAVE + out), 0.09, steps=3
        )
        yield from _both_sides(course)


# Columns and ribs -----------------------------------------------------------------------------------


def _column_places() -> Array:
    """(N, 3) feet of the columns that stand free [m]."""
    z = HALF_NAVE + _WALL / 2
    return np.array([(BAY * i - HALF_LENGTH, 0.0, side * z) for side in (-1, 1) for i in range(1, BAYS)])


def _columns() -> Iterator[Triangles]:
    """Columns with base and capital, and piers where the arcades end."""
    foot, head, radius = 0.30, _COLUMN - 0.22, 0.40
    torus = [(0.47 + 0.07 * np.sin(a), foot + 0.08 - 0.08 * np.cos(a)) for a in np.linspace(0, np.pi, 9)]
    scotia = [(0.47, foot + 0.16), (0.47, foot + 0.16), (0.43, foot + 0.21), (0.44, foot + 0.26)]
    upper_torus = [
        (0.42 + 0.035 * np.sin(a), foot + 0.30 - 0.04 * np.cos(a)) for a in np.linspace(0, np.pi, 7)
    ]
    shaft_foot, shaft_head = foot + 0.36, head - 0.62
    shaft = [
        (radius + 0.01 - 0.05 * t**1.8, shaft_foot + t * (shaft_head - shaft_foot))
        for t in np.linspace(0, 1, 10)
    ]
    ring = [
        (0.36 + 0.045 * np.sin(a), shaft_head + 0.08 - 0.045 * np.cos(a)) for a in np.linspace(0, np.pi, 7)
    ]
    bell = [(0.35 + 0.2 * t**2.4, head - 0.48 + 0.48 * t) for t in np.linspace(0, 1, 9)]
    profile = np.array(
        [
            (0.0, foot),
            (0.47, foot),
            *torus,
            *scotia,
            *upper_torus,
            *shaft,
            *ring,
            *bell,
            (0.55, head),
            (0, head),
        ]
    )
    turned = geometry.lathe(profile, 48)
    plinth = rounded.rounded_box((-0.62, -0.1, -0.62), (0.62, foot, 0.62), 0.04)
    abacus = rounded.rounded_box((-0.62, head - 0.01, -0.62), (0.62, _COLUMN + 0.02, 0.62), 0.05)
    yield geometry.copies(geometry.merge([plinth, turned, abacus]), _column_places())
    # Against the end walls; where the apse begins they hide the joints of its wall and dome.
    for x0, x1 in ((-HALF_LENGTH - 0.1, -HALF_LENGTH + 0.5), (HALF_LENGTH - 0.5, HALF_LENGTH + 0.1)):
        for low, high in (
            (HALF_NAVE - 0.3, HALF_NAVE + _WALL + 0.3),
            (-HALF_NAVE - _WALL - 0.3, -HALF_NAVE + 0.3),
        ):
            yield geometry.box((x0, -0.1, low), (x1, _COLUMN, high))
            yield rounded.rounded_box(
                (x0, _COLUMN - 0.2, low - 0.06), (x1 + 0.06, _COLUMN + 0.02, high + 0.06), 0.04
            )
            inner = sorted((np.sign(low) * (HALF_NAVE + 0.1), np.sign(low) * (HALF_NAVE - 0.22)))
            yield geometry.box((x0, _COLUMN, inner[0]), (x1, SPRING, inner[1]))


def _shafts() -> Iterator[Triangles]:
    """Half columns on the nave's walls, from the capitals up to the vault, and their small capitals."""
    x = BAY * np.arange(1, BAYS) - HALF_LENGTH
    bell = [(0.17 + 0.15 * t**2, SPRING - 0.5 + 0.36 * t) for t in np.linspace(0, 1, 7)]
    profile = [
        (0.0, _COLUMN),
        (0.26, _COLUMN),
        (0.26, _COLUMN),
        (0.26, _COLUMN + 0.3),
        (0.17, _COLUMN + 0.42),
    ]
    profile += [*bell, (0.32, SPRING - 0.14), (0.32, SPRING), (0.32, SPRING), (0.0, SPRING)]
    shaft = geometry.lathe(np.array(profile), 32)
    for side in (-1, 1):
        yield geometry.copies(shaft, np.stack([x, 0 * x, np.full_like(x, side * HALF_NAVE)], 1))


def _ribs() -> Iterator[Triangles]:
    """Bands under the vaults: across the nave and aisles, and along the creases."""
    chamfered = np.array([(-0.2, 0.12), (0.1, 0.2), (0.1, -0.2), (-0.2, -0.12)])[::-1].repeat(2, axis=0)
    inner = HALF_NAVE + _WALL
    for radius, middle, spring, scale in (
        (HALF_NAVE, 0.0, SPRING, 1.0),
        ((HALF_WIDTH - inner) / 2, (HALF_WIDTH + inner) / 2, _COLUMN, 0.7),
        ((HALF_WIDTH - inner) / 2, -(HALF_WIDTH + inner) / 2, _COLUMN, 0.7),
    ):
        rise = HALF_NAVE if middle == 0 else _ARCH
        band = geometry.turned(geometry.arch(radius, scale * chamfered, segments=48), 90)
        band = band._replace(positions=band.positions * np.array([1, rise / radius, 1]))
        x = BAY * np.arange(BAYS + 1) - HALF_LENGTH
        yield geometry.copies(band, np.stack([x, np.full_like(x, spring), np.full_like(x, middle)], 1))
        angle = np.linspace(-np.pi / 2, np.pi / 2, 33)
        places = np.array([(x, spring, middle) for x in _bay_middles()])
        for way in (-1, 1):
            path = np.stack([BAY / 2 * np.sin(angle), rise * np.cos(angle), way * radius * np.sin(angle)], 1)
            yield geometry.copies(rounded.tube(path, 0.13 * scale, 10), places)
    boss = geometry.sphere(0.26, rings=12)
    boss = geometry.smooth(boss._replace(positions=boss.positions * np.array([1, 0.6, 1])))
    yield geometry.copies(boss, np.array([(x, CROWN - 0.04, 0.0) for x in _bay_middles()]))
    for degrees in (-45, 0, 45):  # up the half dome
        turn = np.radians(degrees)
        up = np.linspace(0.0, np.pi / 2, 25)
        out = (HALF_NAVE - 0.02) * np.cos(up)
        path = np.stack(
            [HALF_LENGTH + out * np.cos(turn), SPRING + (HALF_NAVE - 0.02) * np.sin(up), out * np.sin(turn)],
            1,
        )
        yield rounded.tube(path, 0.1, 10)


def _tracery() -> Iterator[Triangles]:
    """Stone bars of the round window, and a mullion in every upper one."""
    radius, height = _rose()
    turn = 2 * np.pi * np.arange(65) / 64
    centre = np.array([-HALF_LENGTH - _OUTER / 2, height, 0.0])

    def ring(size: float, thick: float, around: tuple[float, float] = (0.0, 0.0)) -> Triangles:
        y, z = around[0] + size * np.cos(turn), around[1] + size * np.sin(turn)
        return rounded.tube(centre + np.stack([0 * y, y, z], 1), thick, 8)

    yield ring(radius, 0.14)
    yield ring(0.5, 0.08)
    for angle in np.radians(np.arange(0, 360, 45)):
        way = np.array([np.cos(angle), np.sin(angle)])
        yield ring(0.42, 0.06, (1.32 * way[0], 1.32 * way[1]))
        half = angle + np.radians(22.5)
        ends = [np.array([0.0, size * np.cos(half), size * np.sin(half)]) for size in (0.5, radius)]
        yield rounded.tube(centre + np.array(ends), 0.06, 8)
    for side in (-1, 1):
        z = side * (HALF_NAVE + _WALL / 2)
        for x in _bay_middles():
            yield rounded.tube(np.array([(x, 8.4, z), (x, 12.3, z)]), 0.07, 8)


# Floor and furniture --------------------------------------------------------------------------------


def _base() -> Triangles:
    """The slab under everything; its top shows as joints between the tiles."""
    return geometry.box(
        (-HALF_LENGTH - 0.3, -0.7, -HALF_WIDTH - 0.3), (HALF_LENGTH + HALF_NAVE + 0.3, 0.0, HALF_WIDTH + 0.3)
    )


def _tiles() -> tuple[Triangles, Triangles]:
    """Slabs laid as a chequerboard with open joints."""
    size, joint = 1.0, 0.008
    tile = geometry.box((joint, -0.02, joint), (size - joint, 0.012, size - joint))
    i, j = (
        k.ravel() for k in np.meshgrid(np.arange(2 * HALF_LENGTH), np.arange(2 * HALF_WIDTH), indexing="ij")
    )
    corners = np.stack([i - HALF_LENGTH, 0 * i, j - HALF_WIDTH], 1)
    odd = (i + j) % 2 == 1
    return geometry.copies(tile, corners[~odd]), geometry.copies(tile, corners[odd])


def _step_edges() -> list[tuple[float, float]]:
    """Where each step up to the choir begins along x, and its height [m]."""
    return [(_STEPS + 0.4 * i, _CHOIR * (i + 1) / 3) for i in range(3)]


def _choir() -> Iterator[Triangles]:
    """Steps across the nave, and the raised floor behind them up to the apse."""
    for x, height in _step_edges():
        yield rounded.rounded_box((x, -0.2, -3.3), (HALF_LENGTH + 0.3, height, 3.3), 0.02)
    yield geometry.moved(geometry.cylinder(HALF_NAVE + 0.1, _CHOIR + 0.2, 96), (HALF_LENGTH, -0.2 - 0.001, 0))


def _carpet() -> Iterator[Triangles]:
    """A runner along the nave, up the steps to the altar."""
    half, thick = 0.95, 0.03
    starts = [(-HALF_LENGTH + 1.0, 0.0), *_step_edges()]
    ends = [x for x, _ in starts[1:]] + [HALF_LENGTH - 0.6]
    for (x, height), end in zip(starts, ends, strict=True):
        begin = x - thick if height else x
        yield rounded.rounded_box(
            (begin, height - (0.2 if height else 0.05), -half), (end, height + thick, half), 0.012
        )


def _pews() -> Iterator[Triangles]:
    """Benches on both sides of the carpet."""
    half = 0.98
    parts = [
        rounded.rounded_box((-0.20, 0.42, -half), (0.22, 0.47, half), 0.02),
        rounded.rounded_box((-0.26, 0.50, -half), (-0.21, 0.96, half), 0.02),
        rounded.rounded_box((-0.30, 0.93, -half), (-0.16, 0.98, half), 0.02),
        rounded.rounded_box((0.10, 0.10, -half), (0.13, 0.42, half), 0.01),
    ]
    for end in (-half, half):
        parts.append(rounded.rounded_box((-0.32, 0.0, end - 0.03), (0.26, 0.72, end + 0.03), 0.025))
        parts.append(rounded.rounded_box((-0.32, 0.5, end - 0.03), (-0.14, 1.06, end + 0.03), 0.025))
    bench = geometry.merge(parts)
    rows = np.arange(-10.6, 8.0, 1.1)
    places = np.array([(x, 0.01, side * 2.15) for x in rows for side in (-1, 1)])
    # The carpet's way is at z = 0; people look towards the altar at +x.
    yield geometry.copies(bench, places)


def _doors() -> Iterator[Triangles]:
    """The portal in the west front, closed: two leaves of panels under an arch."""
    face = -HALF_LENGTH
    for side in (-1, 1):
        z = sorted((side * 0.02, side * 1.2))
        yield rounded.rounded_box((face - 0.1, 0.0, z[0]), (face + 0.05, 3.2, z[1]), 0.02)
        for k in range(4):
            y = 0.2 + 0.75 * k
            inner = sorted((side * 0.14, side * 1.08))
            yield rounded.rounded_box((face, y, inner[0]), (face + 0.09, y + 0.6, inner[1]), 0.03)
    profile = np.array([(0.0, -0.1), (0.3, -0.1), (0.3, 0.1), (0.0, 0.16)]).repeat(2, axis=0)
    for jamb in (-1.35, 1.35):
        yield rounded.rounded_box((face - 0.1, 0.0, jamb - 0.15), (face + 0.16, 3.3, jamb + 0.15), 0.03)
    lintel = geometry.turned(geometry.arch(1.2, profile, segments=40), 90)
    yield geometry.moved(lintel, (face, 3.25, 0))


def _altar() -> Iterator[Triangles]:
    """A stone table on a step in the apse."""
    x = HALF_LENGTH + 0.9
    yield rounded.rounded_box((x - 1.0, _CHOIR - 0.1, -1.9), (x + 1.0, _CHOIR + 0.16, 1.9), 0.03)
    yield rounded.rounded_box((x - 0.4, _CHOIR + 0.1, -1.15), (x + 0.4, _CHOIR + 1.0, 1.15), 0.03)
    yield rounded.rounded_box((x - 0.55, _CHOIR + 1.0, -1.35), (x + 0.55, _CHOIR + 1.15, 1.35), 0.04)


def _altar_cloth() -> Iterator[Triangles]:
    """Linen over the altar's front."""
    x, top = HALF_LENGTH + 0.9, _CHOIR + 1.17
    hung = geometry.turned(geometry.cloth(1.9, 0.55, folds=5, depth=0.02, cells=(64, 16)), -90)
    yield geometry.moved(hung, (x - 0.6, top, 0))
    yield geometry.quad((x - 0.6, top, -0.92), (0, 0, 1.84), (1.1, 0, 0))


def _gold() -> Iterator[Triangles]:
    """Candlesticks and a cross on the altar."""
    x, top = HALF_LENGTH + 1.0, _CHOIR + 1.16
    outline = [
        (0.11, 0.0),
        (0.12, 0.03),
        (0.05, 0.08),
        (0.03, 0.16),
        (0.055, 0.22),
        (0.03, 0.28),
        (0.024, 0.5),
    ]
    outline += [(0.05, 0.56), (0.075, 0.6), (0.075, 0.62)]
    stick = geometry.lathe(np.array([(0.0, 0.0), (0.11, 0.0), *outline, (0.075, 0.62), (0.0, 0.62)]), 24)
    yield geometry.copies(stick, np.array([(x, top, z) for z in (-1.05, -0.75, 0.75, 1.05)]))
    yield rounded.rounded_box((x - 0.16, top, -0.16), (x + 0.16, top + 0.1, 0.16), 0.03)
    yield rounded.rounded_box((x - 0.03, top, -0.04), (x + 0.03, top + 1.3, 0.04), 0.015)
    yield rounded.rounded_box((x - 0.03, top + 0.82, -0.36), (x + 0.03, top + 0.9, 0.36), 0.015)


def _cameras() -> dict[str, Any]:
    """Along the nave, down the shaded aisle, back from the choir, up to the vault, and from outside."""
    end = HALF_LENGTH
    return {
        "nave": camera((-end + 1.4, 1.9, 0.55), (end, 5.2, -0.15), fov=74),
        "aisle": camera((-end + 1.2, 1.7, -6.9), (4.0, 2.9, -3.6), fov=74),
        "choir": camera((end - 1.6, 2.3, -1.9), (-end, 5.4, 1.2), fov=76),
        "vault": camera((-6.0, 1.6, -0.6), (2.0, 12.0, 0.6), fov=80),
        "outside": camera((33.0, 11.0, 30.0), (-1.0, 6.5, 0.0), fov=52),
    }
