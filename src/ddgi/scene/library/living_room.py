"""A furnished room with two lamps, the sun in large windows, and a mirror.

After the living room of McGuire, "Dynamic Diffuse Global Illumination" (2019, BLOG): light of lamps and
sun together, subtle bounces on table and sofa, strong ones on the ceiling, and all of it once more in the
mirror.

The windows are in the wall at -z and have no glass; the mirror hangs on the wall at -x.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np

from ddgi.scene.library import foliage, geometry, rounded
from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.geometry import Triangles, rectangle_profile, rectangular_ring
from ddgi.scene.library.ingredients import camera, diffuse, sheet, sun
from ddgi.scene.library.vaulting import windowed_wall
from ddgi.scene.mesh_keys import mesh

HALF = (3.6, 2.6)
"""From the middle of the room to the walls' inner faces along x and z [m]."""

HEIGHT = 2.7
"""Of the ceiling above the floor [m]."""

WINDOWS = (-1.55, 1.55)
"""The windows' middles along x [m]."""

HALF_WINDOW, SILL, HEAD = 0.95, 0.35, 2.35
"""Half a window's width, and the heights of its foot and its head [m]."""

WALL = 0.25
"""Thickness of the outer walls [m]."""

_LAMPS = {"floor-lamp": (-3.05, 1.52, -1.95), "table-lamp": (1.15, 1.32, 2.28)}  # the bulbs [m]
_SOFA = (-3.08, 0.2)  # middle along x and z [m]
_TABLE = (-1.45, 0.2)
_SHELF = 0.34  # depth of the bookshelf [m]


def living_room(
    sun_direction: Point = (0.42, -0.80, 0.85),
    sun_irradiance: tuple[float, float, float] = (26.0, 23.5, 19.5),
    sky_radiance: tuple[float, float, float] = (1.1, 1.4, 1.9),
    lamp_radiance: tuple[float, float, float] = (230.0, 165.0, 95.0),
) -> Blueprint:
    """Build the living room.

    Args:
        sun_direction: The way sunlight travels.
        sun_irradiance: Irradiance of a surface that faces the sun [W/m^2].
        sky_radiance: Of the whole sky [W/(m^2 sr)].
        lamp_radiance: Of each lamp's bulb, 9 cm thick; its shade glows with 1/150 of it [W/(m^2 sr)].
    """
    description: dict[str, Any] = {
        "type": "scene",
        **_cameras(),
        "sun": sun(sun_direction, sun_irradiance),
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": list(sky_radiance)}},
        **_lamps(lamp_radiance),
    }
    for name, (bsdf, parts) in _materials().items():
        shape = geometry.merge(parts)
        description[name] = mesh(name, shape.positions, shape.faces, bsdf=bsdf, normals=shape.normals)
    return Blueprint(description, ((-HALF[0], 0.0, -HALF[1]), (HALF[0], HEIGHT, HALF[1])))


def _materials() -> dict[str, tuple[dict[str, Any], list[Triangles]]]:
    """Material and parts of every mesh, by the mesh's name."""
    boards = list(_boards())
    books = list(_books())
    frames, canvases = _paintings()
    glaze = {
        "type": "roughplastic",
        "alpha": 0.08,
        "diffuse_reflectance": {"type": "rgb", "value": [0.09, 0.22, 0.30]},
    }
    polished = {
        "type": "roughplastic",
        "alpha": 0.15,
        "diffuse_reflectance": {"type": "rgb", "value": [0.24, 0.12, 0.06]},
    }
    brass = {
        "type": "principled",
        "base_color": {"type": "rgb", "value": [0.72, 0.52, 0.24]},
        "metallic": 1.0,
        "roughness": 0.35,
    }
    silver = {"type": "conductor", "material": "Ag"}
    return {
        "walls": (diffuse(0.74, 0.71, 0.65), list(_walls())),
        "window-wall": (diffuse(0.74, 0.71, 0.65), [_window_wall()]),
        "end-wall": (diffuse(0.36, 0.46, 0.44), [_end_wall()]),
        "ceiling": (diffuse(0.82, 0.81, 0.78), [_ceiling()]),
        "woodwork": (diffuse(0.78, 0.76, 0.72), [*_window_frames(), *_trim(), *_door()]),
        "floor": (diffuse(0.20, 0.12, 0.07), [_base()]),
        "boards-light": (diffuse(0.46, 0.29, 0.16), boards[0::3]),
        "boards-middle": (diffuse(0.40, 0.24, 0.13), boards[1::3]),
        "boards-dark": (diffuse(0.34, 0.20, 0.11), boards[2::3]),
        "rug": (diffuse(0.55, 0.12, 0.09), list(_rug())),
        "rug-border": (diffuse(0.72, 0.63, 0.47), list(_rug_border())),
        "sofa": (diffuse(0.32, 0.35, 0.42), list(_sofa())),
        "cushions": (diffuse(0.70, 0.42, 0.10), list(_cushions())),
        "armchair": (diffuse(0.22, 0.36, 0.24), list(_armchair())),
        "wood": (diffuse(0.36, 0.21, 0.11), [*_feet(), *_sideboard()]),
        "table": (polished, list(_table())),
        "shelves": (diffuse(0.62, 0.56, 0.47), list(_shelves())),
        "books-red": (diffuse(0.45, 0.09, 0.07), books[0::5]),
        "books-blue": (diffuse(0.09, 0.17, 0.36), books[1::5]),
        "books-green": (diffuse(0.14, 0.27, 0.14), books[2::5]),
        "books-cream": (diffuse(0.72, 0.66, 0.52), books[3::5]),
        "books-black": (diffuse(0.07, 0.07, 0.08), books[4::5]),
        "curtains": (sheet(0.66, 0.60, 0.49), list(_curtains())),
        "mirror": (silver, [_mirror()]),
        "brass": (brass, [*_frame(), *_lamp_stands(), *_rods()]),
        "vases": (glaze, list(_vases())),
        "picture-frames": (diffuse(0.10, 0.08, 0.07), frames),
        "picture-ochre": (diffuse(0.66, 0.40, 0.10), canvases[0:1]),
        "picture-blue": (diffuse(0.16, 0.30, 0.44), canvases[1:2]),
        "picture-red": (diffuse(0.58, 0.17, 0.12), canvases[2:3]),
        "plant": (sheet(0.13, 0.32, 0.08), [_plant()]),
        "pot": (diffuse(0.62, 0.34, 0.22), [_pot()]),
        "hedge": (diffuse(0.12, 0.24, 0.06), list(_hedge())),
        "ground": (diffuse(0.22, 0.30, 0.12), [geometry.box((-40, -1.4, -40), (40, -0.4, 40))]),
    }


# The room -------------------------------------------------------------------------------------------


def _walls() -> Iterator[Triangles]:
    """At +z and at -x; they run on behind the floor and the ceiling."""
    x, z = HALF
    yield geometry.box((-x - WALL, -0.2, z), (x + WALL, HEIGHT + WALL, z + WALL))
    yield geometry.box((-x - WALL, -0.2, -z - 0.1), (-x, HEIGHT + WALL, z + 0.1))


def _end_wall() -> Triangles:
    """At +x, behind the books."""
    x, z = HALF
    return geometry.box((x, -0.2, -z - 0.1), (x + WALL, HEIGHT + WALL, z + 0.1))


def _window_wall() -> Triangles:
    """At -z."""
    x, z = HALF
    return windowed_wall(
        (-x - WALL, x + WALL), (-0.2, HEIGHT + WALL), (-z - WALL, -z), WINDOWS, (HALF_WINDOW,) * 2,
        (SILL, SILL), HEAD, rise=0.0, segments=1,
    )  # fmt: skip


def _ceiling() -> Triangles:
    x, z = HALF
    return geometry.box((-x - 0.1, HEIGHT, -z - 0.1), (x + 0.1, HEIGHT + WALL, z + 0.1))


def _base() -> Triangles:
    """The slab under the boards; it shows in their joints."""
    x, z = HALF
    return geometry.box((-x - 0.1, -0.2, -z - 0.1), (x + 0.1, -0.004, z + 0.1))


def _boards() -> Iterator[Triangles]:
    """Floor boards along x, broken at random."""
    rng = np.random.default_rng(3)
    count = 36
    edges = np.linspace(-HALF[1] - 0.01, HALF[1] + 0.01, count + 1)
    for low, high in itertools.pairwise(edges):
        at = -HALF[0] - 0.01 - rng.uniform(0, 1.4)
        while at < HALF[0]:
            end = at + rng.uniform(1.3, 2.1)
            x = np.clip((at, end), -HALF[0] - 0.01, HALF[0] + 0.01)
            if x[1] - x[0] > 0.01:
                yield rounded.rounded_box(
                    (x[0] + 0.001, -0.03, low + 0.001), (x[1] - 0.001, 0.0, high - 0.001), 0.003, steps=1
                )
            at = end


def _trim() -> Iterator[Triangles]:
    """Skirting board and cornice around the room."""
    yield rectangular_ring(*HALF, rectangle_profile((-0.018, -0.01), (0.05, 0.12)))
    cove = [(0.14 * (np.cos(a) - 1), HEIGHT - 0.14 + 0.14 * np.sin(a)) for a in np.linspace(0, np.pi / 2, 8)]
    outline = [(0.05, HEIGHT + 0.05), *[(x, y) for x, y in cove[::-1]], (0.05, HEIGHT - 0.14)]
    yield rectangular_ring(*HALF, np.array(outline))


def _window_frames() -> Iterator[Triangles]:
    """Casings, sills and bars of both windows."""
    z = -HALF[1]
    middle = z - 0.12
    for x in WINDOWS:
        left, right = x - HALF_WINDOW, x + HALF_WINDOW
        for edge, way in ((left, -1), (right, 1)):
            side = sorted((edge - 0.015 * way, edge + 0.09 * way))
            yield rounded.rounded_box(
                (side[0], SILL - 0.1, z - 0.05), (side[1], HEAD + 0.1, z + 0.025), 0.008
            )
        yield rounded.rounded_box(
            (left - 0.12, HEAD - 0.015, z - 0.05), (right + 0.12, HEAD + 0.12, z + 0.03), 0.008
        )
        yield rounded.rounded_box(
            (left - 0.14, SILL - 0.04, z - WALL), (right + 0.14, SILL + 0.01, z + 0.09), 0.012
        )
        for bar in (left + 0.03, x, right - 0.03):
            yield geometry.box((bar - 0.03, SILL, middle - 0.025), (bar + 0.03, HEAD, middle + 0.025))
        for bar in (SILL + 0.05, SILL + 1.35, HEAD - 0.03):
            yield geometry.box((left, bar - 0.025, middle - 0.024), (right, bar + 0.025, middle + 0.024))


def _door() -> Iterator[Triangles]:
    """Closed, in the wall at +z: a leaf with panels, and its casing."""
    x, z = -2.35, HALF[1]
    yield rounded.rounded_box((x - 0.45, 0.0, z - 0.03), (x + 0.45, 2.05, z + 0.1), 0.005)
    for low, high in ((0.2, 0.9), (1.05, 1.9)):
        for side in (-1, 1):
            panel = sorted((x + side * 0.06, x + side * 0.37))
            yield rounded.rounded_box((panel[0], low, z - 0.042), (panel[1], high, z + 0.05), 0.012)
    for side in (-1, 1):
        casing = sorted((x + side * 0.46, x + side * 0.56))
        yield rounded.rounded_box((casing[0], 0.0, z - 0.045), (casing[1], 2.06, z + 0.05), 0.01)
    yield rounded.rounded_box((x - 0.58, 2.06, z - 0.05), (x + 0.58, 2.18, z + 0.05), 0.012)


# Furniture ------------------------------------------------------------------------------------------


def _seat(width: float, depth: float, seats: int) -> list[Triangles]:
    """An upholstered seat that faces +x, its middle on the origin [m]."""
    half, back = width / 2, -depth / 2
    arm = 0.2
    parts = [
        rounded.rounded_box((back, 0.10, -half), (depth / 2 - 0.04, 0.30, half), 0.04, steps=4),
        rounded.rounded_box((back, 0.12, -half + 0.05), (back + 0.20, 0.80, half - 0.05), 0.08, steps=5),
    ]
    for side in (-1, 1):
        z = sorted((side * half, side * (half - arm)))
        parts.append(rounded.rounded_box((back, 0.10, z[0]), (depth / 2 - 0.02, 0.60, z[1]), 0.085, steps=6))
    inside = width - 2 * arm
    for k in range(seats):
        middle = -inside / 2 + inside * (k + 0.5) / seats
        size = inside / seats / 2
        seat = rounded.cushion((depth / 2 - 0.09, 0.09, size - 0.004), power=7, cells=20)
        parts.append(geometry.moved(seat, (0.08, 0.37, middle)))
        rest = rounded.cushion((0.10, 0.24, size - 0.01), power=5, cells=20)
        parts.append(geometry.moved(_leaned(rest, 12), (back + 0.25, 0.66, middle)))
    return parts


def _leaned(shape: Triangles, degrees: float) -> Triangles:
    """Turn about the z axis, tops towards -x."""
    angle = np.radians(degrees)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
    assert shape.normals is not None
    return shape._replace(positions=shape.positions @ turn.T, normals=shape.normals @ turn.T)


def _sofa() -> Iterator[Triangles]:
    for part in _seat(2.3, 0.95, 3):
        yield geometry.moved(part, (_SOFA[0], 0, _SOFA[1]))


def _cushions() -> Iterator[Triangles]:
    """On the sofa and the armchair."""
    for z, turn in ((-0.62, 14.0), (0.78, -18.0)):
        pillow = rounded.cushion((0.075, 0.21, 0.21), power=3.0, cells=18)
        yield geometry.moved(
            geometry.turned(_leaned(pillow, 22), turn), (_SOFA[0] + 0.06, 0.66, _SOFA[1] + z)
        )


def _armchair() -> Iterator[Triangles]:
    for part in _seat(0.92, 0.88, 1):
        yield geometry.moved(geometry.turned(part, 225), (0.75, 0, -1.35))


def _feet() -> Iterator[Triangles]:
    """Of the sofa and the armchair."""
    foot = geometry.lathe(
        np.array([(0, 0), (0.018, 0), (0.018, 0), (0.03, 0.12), (0.03, 0.12), (0, 0.12)]), 20
    )
    for dx in (-0.40, 0.36):
        for dz in (-1.08, 1.08):
            yield geometry.moved(foot, (_SOFA[0] + dx, 0, _SOFA[1] + dz))
    corners = np.array([(dx, 0.0, dz) for dx in (-0.36, 0.32) for dz in (-0.38, 0.38)])
    yield geometry.moved(geometry.turned(geometry.copies(foot, corners), 225), (0.75, 0, -1.35))


def _table() -> Iterator[Triangles]:
    """A low polished table in front of the sofa, with a shelf below."""
    x, z = _TABLE
    yield rounded.rounded_box((x - 0.34, 0.38, z - 0.62), (x + 0.34, 0.42, z + 0.62), 0.018, steps=4)
    yield rounded.rounded_box((x - 0.26, 0.14, z - 0.52), (x + 0.26, 0.165, z + 0.52), 0.01)
    leg = geometry.lathe(
        np.array([(0, 0), (0.016, 0), (0.016, 0), (0.028, 0.385), (0.028, 0.385), (0, 0.385)]), 20
    )
    yield geometry.copies(
        leg, np.array([(x + dx, 0, z + dz) for dx in (-0.28, 0.28) for dz in (-0.55, 0.55)])
    )


def _rug() -> Iterator[Triangles]:
    x, z = _TABLE
    yield rounded.rounded_box((x - 1.15, -0.01, z - 1.45), (x + 1.15, 0.014, z + 1.45), 0.006)


def _rug_border() -> Iterator[Triangles]:
    """A pale band, diamonds down the middle, and a fringe at both ends."""
    x, z = _TABLE
    low, high = 0.0, 0.017
    for side in (-1, 1):
        a = sorted((x + side * 0.98, x + side * 1.06))
        yield geometry.box((a[0], low, z - 1.36), (a[1], high, z + 1.36))
        b = sorted((z + side * 1.28, z + side * 1.36))
        yield geometry.box((x - 0.98, low, b[0]), (x + 0.98, high, b[1]))
        for dx in np.linspace(-1.13, 1.13, 75):
            end = z + side * 1.45
            path = np.array([(x + dx, 0.006, end - 0.01 * side), (x + dx + 0.006, 0.004, end + 0.06 * side)])
            yield rounded.tube(path, 0.004, 5)
    diamond = geometry.turned(geometry.box((-0.19, low, -0.19), (0.19, high, 0.19)), 45)
    for dz in (-0.95, -0.32, 0.32, 0.95):
        for dx in (-0.62, 0.0, 0.62):
            yield geometry.moved(diamond, (x + dx, 0, z + dz))


def _sideboard() -> Iterator[Triangles]:
    """A low cupboard on the wall at +z, with three doors."""
    z = HALF[1]
    low, high = -0.25, 1.45
    yield rounded.rounded_box((low, 0.12, z - 0.45), (high, 0.70, z - 0.02), 0.012)
    yield rounded.rounded_box((low - 0.02, 0.70, z - 0.47), (high + 0.02, 0.73, z - 0.02), 0.01)
    width = (high - low) / 3
    for k in range(3):
        yield rounded.rounded_box(
            (low + k * width + 0.02, 0.15, z - 0.468), (low + (k + 1) * width - 0.02, 0.68, z - 0.44), 0.008
        )
        knob = (low + (k + 0.5) * width, 0.60, z - 0.48)
        yield geometry.moved(geometry.sphere(0.015, rings=10), knob)
    for x in (low + 0.1, high - 0.1):
        for dz in (-0.40, -0.08):
            yield geometry.box((x - 0.02, 0, z + dz - 0.02), (x + 0.02, 0.13, z + dz + 0.02))


def _shelf_heights() -> list[float]:
    """Upper sides of the bookshelf's boards [m]."""
    return [0.10, 0.48, 0.86, 1.24, 1.62, 2.0]


def _shelves() -> Iterator[Triangles]:
    """A bookshelf along the wall at +x."""
    x, half = HALF[0], 1.5
    for height in _shelf_heights():
        yield rounded.rounded_box((x - _SHELF, height - 0.028, -half), (x - 0.01, height, half), 0.004)
    for z in (-half, -0.5, 0.5, half):
        yield rounded.rounded_box((x - _SHELF - 0.004, 0.0, z - 0.016), (x - 0.005, 2.03, z + 0.016), 0.004)
    yield geometry.box((x - 0.03, 0.0, -half), (x - 0.001, 2.02, half))


def _books() -> Iterator[Triangles]:
    """Upright on the shelves, some leaning back a little; and a pile on the table."""
    rng = np.random.default_rng(11)
    back = HALF[0] - 0.04
    for height in _shelf_heights()[:-1]:
        for start in (-1.5, -0.5, 0.5):
            at, end = start + 0.03, start + 1.0 - 0.03 - rng.uniform(0.0, 0.3)
            while at < end:
                thick = rng.uniform(0.018, 0.055)
                tall, deep = rng.uniform(0.19, 0.32), rng.uniform(0.15, 0.24)
                yield rounded.rounded_box(
                    (back - 0.03 - deep, height, at), (back - 0.03, height + tall, at + thick - 0.001),
                    0.3 * thick, steps=1,
                )  # fmt: skip
                at += thick
    x, z = _TABLE
    at = 0.42
    for k, turn in enumerate((8.0, -12.0, 25.0)):
        book = rounded.rounded_box((-0.12 + 0.01 * k, 0, -0.16), (0.12, 0.032, 0.16), 0.006)
        yield geometry.moved(geometry.turned(book, turn), (x + 0.05, at, z + 0.3))
        at += 0.032


# What hangs and stands about ------------------------------------------------------------------------


def _mirror() -> Triangles:
    """The glass, on the wall at -x above the sofa; only its front reflects."""
    x = -HALF[0]
    return geometry.box((x, 1.22, _SOFA[1] - 0.85), (x + 0.03, 2.17, _SOFA[1] + 0.85))


def _frame() -> Iterator[Triangles]:
    """Of the mirror: four rounded bars."""
    x, z = -HALF[0], _SOFA[1]
    for y in (1.22, 2.17):
        yield rounded.rounded_box((x, y - 0.05, z - 0.9), (x + 0.06, y + 0.05, z + 0.9), 0.025, steps=4)
    for side in (-1, 1):
        yield rounded.rounded_box(
            (x, 1.17, z + side * 0.85 - 0.05), (x + 0.06, 2.22, z + side * 0.85 + 0.05), 0.025, steps=4
        )


def _lamps(radiance: tuple[float, float, float]) -> dict[str, Any]:
    """Two lamps: a bulb each, and a shade open above and below that glows outwards."""
    shapes: dict[str, Any] = {}
    for name, place in _LAMPS.items():
        wide = 0.24 if name == "floor-lamp" else 0.19
        shapes[f"{name}-bulb"] = {
            "type": "sphere",
            "center": list(place),
            "radius": 0.045,
            "bsdf": diffuse(0.5, 0.5, 0.5),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": list(radiance)}},
        }
        outline = np.array([(wide, -0.15), (0.72 * wide, 0.17)])
        shade = geometry.moved(geometry.lathe(outline, 64), place)
        glow = {"type": "area", "radiance": {"type": "rgb", "value": [value / 150 for value in radiance]}}
        shapes[f"{name}-shade"] = mesh(
            f"{name}-shade",
            shade.positions,
            shade.faces,
            bsdf=sheet(0.72, 0.66, 0.55),
            emitter=glow,
            normals=shade.normals,
        )
    return shapes


def _lamp_stands() -> Iterator[Triangles]:
    """Foot and stem of both lamps."""
    for name, (x, y, z) in _LAMPS.items():
        foot, wide = (0.0, 0.16) if name == "floor-lamp" else (0.73, 0.08)
        edge = [(wide, 0.0), (wide, 0.0), (wide, 0.015), (0.35 * wide, 0.035), (0.012, 0.06)]
        profile = [
            (0.0, 0.0),
            *edge,
            (0.012, y - foot - 0.05),
            (0.012, y - foot - 0.05),
            (0.0, y - foot - 0.05),
        ]
        yield geometry.moved(geometry.lathe(np.array(profile), 32), (x, foot, z))


def _curtains() -> Iterator[Triangles]:
    """Drawn aside at both windows, their hems just above the floor."""
    for x in WINDOWS:
        for side in (-1, 1):
            hung = geometry.cloth(0.62, 2.42, folds=6, depth=0.05, cells=(96, 40))
            yield geometry.moved(hung, (x + side * (HALF_WINDOW + 0.05), 2.45, -HALF[1] + 0.14))


def _rods() -> Iterator[Triangles]:
    """The curtains hang from them."""
    y, z = 2.47, -HALF[1] + 0.14
    for x in WINDOWS:
        yield rounded.tube(np.array([(x - 1.42, y, z), (x + 1.42, y, z)]), 0.014, 16)
        for end in (-1.42, 1.42):
            yield geometry.moved(geometry.sphere(0.03, rings=12), (x + end, y, z))


def _vases() -> Iterator[Triangles]:
    """On the table and on the sideboard."""
    outline = [
        (0.05, 0.0),
        (0.05, 0.0),
        (0.09, 0.07),
        (0.10, 0.13),
        (0.07, 0.21),
        (0.035, 0.26),
        (0.045, 0.30),
    ]
    outline += [(0.045, 0.30), (0.037, 0.30), (0.03, 0.26)]
    vase = geometry.lathe(np.array([(0.0, 0.0), *outline, (0.0, 0.26)]), 48)
    yield geometry.moved(vase, (_TABLE[0] - 0.08, 0.42, _TABLE[1] - 0.28))
    yield geometry.moved(vase, (0.05, 0.73, HALF[1] - 0.26))
    bowl = [
        (0.0, 0.0),
        (0.07, 0.0),
        (0.07, 0.0),
        (0.13, 0.04),
        (0.16, 0.09),
        (0.16, 0.09),
        (0.145, 0.09),
        (0.0, 0.03),
    ]
    yield geometry.moved(geometry.lathe(np.array(bowl), 48), (0.42, 0.73, HALF[1] - 0.24))


def _paintings() -> tuple[list[Triangles], list[Triangles]]:
    """Three pictures above the sideboard, and their frames."""
    z, middle = HALF[1], 1.75
    frames: list[Triangles] = []
    canvases: list[Triangles] = []
    for x, width, height in ((-0.35, 0.42, 0.56), (0.35, 0.62, 0.46), (1.02, 0.36, 0.5)):
        for part, shrink, out in ((frames, 0.0, 0.03), (canvases, 0.045, 0.034)):
            half, tall = width / 2 - shrink, height / 2 - shrink
            low, high = (x - half, middle - tall, z - out), (x + half, middle + tall, z - 0.001)
            part.append(rounded.rounded_box(low, high, 0.008))
    return frames, canvases


def _pot() -> Triangles:
    """For the plant, in the corner beside the window."""
    outline = [(0.15, 0.0), (0.20, 0.34), (0.215, 0.34), (0.215, 0.38), (0.19, 0.38), (0.185, 0.33)]
    profile = [(0.0, 0.0), *(point for point in outline for _ in range(2)), (0.0, 0.33)]  # all edges sharp
    return geometry.moved(geometry.lathe(np.array(profile), 48), (3.1, 0, -2.1))


def _plant() -> Triangles:
    """Broad leaves that arch out of the pot."""
    rng = np.random.default_rng(5)
    count = 46
    azimuth = 2.4 * np.arange(count)
    steep = rng.uniform(0.5, 1.35, count)
    out = np.stack([np.sin(azimuth), 0 * azimuth, np.cos(azimuth)], 1)
    up = np.array([0, 1.0, 0])
    along = np.cos(steep)[:, None] * out + np.sin(steep)[:, None] * up
    base = np.array([3.1, 0.34, -2.1]) + 0.05 * out + 0.4 * rng.uniform(0, 1, (count, 1)) * along
    length = rng.uniform(0.35, 0.62, count)
    lower = foliage.leaves(base, along, np.cross(np.cross(along, up), along), length, 0.24)
    bow = along + 0.5 * out - 0.6 * up
    bow /= np.linalg.norm(bow, axis=1, keepdims=True)
    tips = base + 0.72 * length[:, None] * along
    return geometry.merge([lower, foliage.leaves(tips, bow, up + 0 * bow, 0.5 * length, 0.3)])


def _hedge() -> Iterator[Triangles]:
    """Bushes outside, so that the windows look out on something."""
    rng = np.random.default_rng(2)
    for k, x in enumerate(np.linspace(-17, 17, 24)):
        bush = geometry.blob(rng.uniform(1.0, 2.2), bumps=8, amplitude=0.2, seed=60 + k, rings=20)
        yield geometry.moved(bush, (x, 0.2, -10.5 - rng.uniform(0, 2)))


def _cameras() -> dict[str, Any]:
    """Towards the sofa and the windows, to the books, straight into the mirror, and to the wall without windows."""
    return {
        "room": camera((2.75, 1.5, 2.1), (-1.9, 0.85, -0.75), fov=78),
        "books": camera((-2.2, 1.5, -2.0), (3.0, 0.95, 0.9), fov=74),
        "reflection": camera((0.9, 1.5, 0.35), (-3.6, 1.3, 0.15), fov=68),
        "sideboard": camera((-1.0, 1.45, -1.1), (0.75, 1.05, 2.6), fov=74),
    }
