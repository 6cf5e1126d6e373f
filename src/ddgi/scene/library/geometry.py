"""Triangle meshes out of NumPy: boxes, lathed and swept solids, cloth. Metres, +y up.

Solids are watertight (every edge is shared by exactly two triangles that run along it in opposite
directions, vertices at the same place counted as one) and wound counter-clockwise seen from outside.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int64]
Point = Sequence[float] | Array


class Triangles(NamedTuple):
    """A triangle mesh; without normals its faces are flat."""

    positions: Array  # (V, 3) [m]
    faces: Faces  # (F, 3) vertex numbers, counter-clockwise seen from the front
    normals: Array | None = None  # (V, 3) unit vectors


# Working on meshes ----------------------------------------------------------------------------------


def smooth(shape: Triangles) -> Triangles:
    """Give every vertex the area-weighted mean normal of its triangles."""
    a, b, c = (shape.positions[shape.faces[:, i]] for i in range(3))
    face_normals = np.cross(b - a, c - a)
    count = len(shape.positions)
    normals = np.empty((count, 3))
    for axis in range(3):
        weights = np.repeat(face_normals[:, axis], 3)
        normals[:, axis] = np.bincount(shape.faces.ravel(), weights, minlength=count)
    return shape._replace(normals=normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20))


def flat(shape: Triangles) -> Triangles:
    """Give every triangle its own three vertices and its own normal."""
    corners = shape.positions[shape.faces]  # (F, 3, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20)
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    return Triangles(corners.reshape(-1, 3), faces, np.repeat(normals, 3, axis=0))


def welded(shape: Triangles) -> Triangles:
    """Make vertices at the same place (to a micrometre) one vertex; normals are dropped."""
    _, first, number = np.unique(np.round(shape.positions, 6), axis=0, return_index=True, return_inverse=True)
    return Triangles(shape.positions[first], _without_slivers(number.ravel()[shape.faces]))


def merge(shapes: Iterable[Triangles]) -> Triangles:
    """Many meshes as one. Where some have normals, the others' faces are kept flat."""
    parts = list(shapes)
    if any(part.normals is not None for part in parts):
        parts = [part if part.normals is not None else flat(part) for part in parts]
    starts = np.cumsum([0] + [len(part.positions) for part in parts])
    normals = [part.normals for part in parts if part.normals is not None]
    return Triangles(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=False)]),
        np.concatenate(normals) if normals else None,
    )


def moved(shape: Triangles, offset: Point) -> Triangles:
    """Shift by `offset` [m]."""
    return shape._replace(positions=shape.positions + np.asarray(offset, float))


def turned(shape: Triangles, degrees: float) -> Triangles:
    """Rotate about +y; azimuth runs from +z to +x, so 90 degrees carry +z to +x."""
    angle = np.radians(degrees)
    cos, sin = np.cos(angle), np.sin(angle)
    rotation = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
    normals = None if shape.normals is None else shape.normals @ rotation.T
    return shape._replace(positions=shape.positions @ rotation.T, normals=normals)


def turned_inside_out(shape: Triangles) -> Triangles:
    """The same surface facing the other way."""
    normals = None if shape.normals is None else -shape.normals
    return Triangles(shape.positions, shape.faces[:, ::-1].copy(), normals)


def copies(shape: Triangles, offsets: Array) -> Triangles:
    """One mesh with a copy of `shape` at each of (N, 3) offsets [m]."""
    offsets = np.asarray(offsets, float)
    count, size = len(offsets), len(shape.positions)
    positions = (shape.positions[None] + offsets[:, None]).reshape(-1, 3)
    faces = (shape.faces[None] + size * np.arange(count)[:, None, None]).reshape(-1, 3)
    return Triangles(positions, faces, None if shape.normals is None else np.tile(shape.normals, (count, 1)))


def _without_slivers(faces: Faces) -> Faces:
    """Drop triangles that use a vertex twice."""
    a, b, c = faces.T
    used: Faces = faces[(a != b) & (b != c) & (c != a)]
    return used


def _without_empty(shape: Triangles) -> Triangles:
    """Drop triangles that have two corners in one place: poles and creases of grids."""
    p = shape.positions
    a, b, c = shape.faces.T
    apart = (p[a] != p[b]).any(1) & (p[b] != p[c]).any(1) & (p[c] != p[a]).any(1)
    return shape._replace(faces=shape.faces[apart])


def grid(points: Array, *, closed_rows: bool = False, closed_columns: bool = False) -> Triangles:
    """Two triangles per cell of (R, C, 3) points; the front is where rows cross columns points.

    Closed rows join the last row to the first, likewise columns.
    """
    rows, columns = points.shape[:2]
    i = np.arange(rows if closed_rows else rows - 1)
    j = np.arange(columns if closed_columns else columns - 1)
    i, j = (index.ravel() for index in np.meshgrid(i, j, indexing="ij"))
    up, right = (i + 1) % rows, (j + 1) % columns
    a, b, c, d = i * columns + j, up * columns + j, up * columns + right, i * columns + right
    faces = np.stack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)], 1).reshape(-1, 3)
    return _without_empty(Triangles(points.reshape(-1, 3), faces))


# Flat things ----------------------------------------------------------------------------------------


def quad(corner: Point, edge_a: Point, edge_b: Point) -> Triangles:
    """A parallelogram whose front is where edge_a x edge_b points."""
    p, a, b = (np.asarray(v, float) for v in (corner, edge_a, edge_b))
    return Triangles(np.stack([p, p + a, p + a + b, p + b]), np.array([[0, 1, 2], [0, 2, 3]]))


def ground(half_size: float, height: float = 0.0) -> Triangles:
    """A horizontal square that faces up."""
    s = half_size
    return quad((-s, height, -s), (0, 0, 2 * s), (2 * s, 0, 0))


def cloth(
    width: float, drop: float, *, folds: float = 6.0, depth: float = 0.07, cells: tuple[int, int] = (96, 56)
) -> Triangles:
    """A curtain: one sheet that hangs from y = 0 down to -drop, centred on x = 0, facing +z.

    Folds are tight at the rod and open downwards; the hem sways a little.

    Args:
        width: How wide it hangs [m].
        drop: How long it is [m].
        folds: Waves across the width.
        depth: Amplitude of the folds at the hem [m].
        cells: Quads across and down.
    """
    u = np.linspace(0.0, 1.0, cells[0] + 1)[None, :]
    v = np.linspace(0.0, 1.0, cells[1] + 1)[:, None]  # 0 at the hem
    fall = 1.0 - v
    phase = 2 * np.pi * folds * (u + 0.02 * np.sin(2 * np.pi * (1.7 * u + 0.3)))
    wave = np.sin(phase + 0.5 * fall * np.sin(3.0 * u + 1.0)) + 0.25 * np.sin(2.3 * phase + 2.0 * fall)
    z = depth * (0.45 + 0.55 * fall) * wave + 0.05 * fall**2 * np.sin(5.0 * u + 0.8)
    x = width * (u - 0.5) * (0.96 + 0.04 * fall)
    y = -drop * fall + 0.015 * drop * fall * np.sin(7.0 * u) ** 2
    points = np.stack(np.broadcast_arrays(x, y, z), -1)[:, ::-1]  # rows run up, columns towards -x
    return smooth(grid(points))


# Solids ---------------------------------------------------------------------------------------------

_BOX_FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)  # fmt: skip


def box(low: Point, high: Point) -> Triangles:
    """An axis-aligned box between two corners."""
    ends = np.stack([np.asarray(low, float), np.asarray(high, float)])
    corner = np.arange(8)
    bits = np.stack([corner >> 2 & 1, corner >> 1 & 1, corner & 1], 1)  # x, y, z
    return Triangles(np.take_along_axis(ends, bits, 0), _BOX_FACES)


def lathe(profile: Array, segments: int, *, flutes: int = 0, fluting: Array | None = None) -> Triangles:
    """Turn a profile about the y axis. Two equal points in a row make a sharp edge there.

    Args:
        profile: (N, 2) radius and height [m], from bottom to top; radius 0 at both ends closes it.
        segments: Steps around the axis; a multiple of `flutes` keeps the grooves even.
        flutes: Grooves around the axis, as of a fluted column.
        fluting: (N,) depth of the grooves at each profile point [m].
    """
    profile = np.asarray(profile, float)
    angle = 2 * np.pi * np.arange(segments) / segments
    radius = np.broadcast_to(profile[:, :1], (len(profile), segments))
    if fluting is not None:
        # A row of half circles cut in, with narrow ridges between: |sin| is deep and round.
        radius = radius - np.asarray(fluting)[:, None] * np.abs(np.sin(0.5 * flutes * angle))
    height = np.broadcast_to(profile[:, 1:], radius.shape)
    points = np.stack([radius * np.cos(angle), height, radius * np.sin(angle)], -1)
    return smooth(grid(points, closed_columns=True))


def cylinder(radius: float, height: float, segments: int = 32) -> Triangles:
    """An upright cylinder that stands on y = 0."""
    profile = [(0, 0), (radius, 0), (radius, 0), (radius, height), (radius, height), (0, height)]
    return lathe(np.array(profile), segments)


def sphere(radius: float, rings: int = 24) -> Triangles:
    """A sphere about the origin of 2 `rings` meridians."""
    polar = np.linspace(-0.5 * np.pi, 0.5 * np.pi, rings + 1)
    profile = radius * np.stack([np.cos(polar), np.sin(polar)], 1)
    profile[[0, -1], 0] = 0.0
    return smooth(welded(lathe(profile, 2 * rings)))


def blob(
    radius: float, *, bumps: float = 2.0, amplitude: float = 0.25, seed: int = 0, rings: int = 40
) -> Triangles:
    """A sphere displaced along its radius by a few random waves.

    Args:
        radius: Mean radius [m].
        bumps: Waves per radian: 2 makes a pebble, 12 a bush.
        amplitude: Size of the displacement, as a share of the radius.
        seed: Which blob.
        rings: Rings of the sphere it starts from.
    """
    base = sphere(1.0, rings)
    rng = np.random.default_rng(seed)
    waves = rng.normal(size=(3, 7))
    waves *= bumps * rng.uniform(0.7, 1.3, 7) / np.linalg.norm(waves, axis=0)
    height = np.sin(base.positions @ waves + rng.uniform(0, 2 * np.pi, 7)).sum(1) / np.sqrt(7)
    return smooth(
        base._replace(positions=base.positions * radius * (1 + amplitude * np.tanh(height))[:, None])
    )


def swept(loops: Array) -> Triangles:
    """A convex loop carried along a path, with both ends closed by fans.

    Args:
        loops: (R, C, 3): R points around the loop, C steps along the path; loop direction cross path
            direction points outwards.
    """
    rows = len(loops)
    i = np.arange(1, rows - 1)
    end_fan = np.stack([np.zeros_like(i), i, i + 1], 1)
    # The ends have vertices of their own, so that smooth normals do not run over their edges.
    start = Triangles(loops[:, 0], end_fan[:, ::-1])
    end = Triangles(loops[:, -1], end_fan)
    return _without_empty(merge([grid(loops, closed_rows=True), start, end]))


def slab_between(x: Array, low: Array, high: Array, z: tuple[float, float]) -> Triangles:
    """A wall from z[0] to z[1] with a given lower and upper outline: (N,) heights over rising x [m]."""
    near, far = np.full_like(x, z[1]), np.full_like(x, z[0])
    outline = [(high, near), (low, near), (low, far), (high, far)]
    return swept(np.stack([np.stack([x, y, depth], -1) for y, depth in outline]))


def arcade(
    centres: Sequence[float], radius: float, pitch: float, spring: float, top: float, z: tuple[float, float],
    segments: int = 40,
) -> Triangles:  # fmt: skip
    """A wall carried by round arches, open below.

    Args:
        centres: Where the arches stand along x [m], `pitch` apart.
        radius: Of the arches [m].
        pitch: Width of one bay [m].
        spring: Height at which the arches begin [m].
        top: Height of the wall's upper edge [m].
        z: Back and front of the wall [m].
        segments: Per arch.
    """
    angle = np.linspace(np.pi, 0.0, segments + 1)
    x = [c + radius * np.cos(angle) for c in centres]
    low = [spring + radius * np.sin(angle)] * len(x)
    xs = np.concatenate([[centres[0] - pitch / 2], *x, [centres[-1] + pitch / 2]])
    lows = np.concatenate([[spring], *low, [spring]])
    return slab_between(xs, lows, np.full_like(xs, top), z)


def arch(radius: float, profile: Array, segments: int = 40) -> Triangles:
    """A half ring over the origin that stands on y = 0 and spans x.

    Args:
        radius: Of the line that the profile is carried along [m].
        profile: (N, 2) convex outline: distance outwards from that line and z [m]; it runs from
            outwards to +z. Two equal points in a row make a sharp edge there.
        segments: Steps along the half circle.
    """
    angle = np.linspace(0.0, np.pi, segments + 1)[None]
    outwards, z = np.asarray(profile, float)[:, 0, None], np.asarray(profile, float)[:, 1, None]
    x, y = (radius + outwards) * np.cos(angle), (radius + outwards) * np.sin(angle)
    return smooth(swept(np.stack(np.broadcast_arrays(x, y, z), -1)[:, ::-1]))


def rectangular_ring(half_x: float, half_z: float, profile: Array) -> Triangles:
    """A profile carried around a rectangle with mitred corners: walls, slabs, cornices of a court.

    Args:
        half_x: Half the rectangle's extent along x [m].
        half_z: Half the rectangle's extent along z [m].
        profile: (N, 2) distance outwards from the rectangle and height [m], counter-clockwise with
            outwards to the right.
    """
    outwards, height = np.asarray(profile, float)[:, 0, None], np.asarray(profile, float)[:, 1, None]
    sign_x, sign_z = np.array([1, -1, -1, 1.0]), np.array([1, 1, -1, -1.0])
    points = np.broadcast_arrays(sign_x * (half_x + outwards), height, sign_z * (half_z + outwards))
    return grid(np.stack(points, -1), closed_rows=True, closed_columns=True)


def rectangle_profile(low: Point, high: Point) -> Array:
    """The four corners of a rectangle, counter-clockwise, for `rectangular_ring`."""
    (a, b), (c, d) = low, high
    return np.array([(a, b), (c, b), (c, d), (a, d)], float)


def wall_with_opening(low: Point, high: Point, opening: tuple[float, float], head: float) -> list[Triangles]:
    """A wall between two corners with a doorway down to its foot, as three boxes.

    Args:
        low: Lower corner [m].
        high: Upper corner [m].
        opening: From where to where the doorway runs along the wall's longer horizontal side [m].
        head: Height of the doorway's upper edge [m].
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    along = 0 if high[0] - low[0] > high[2] - low[2] else 2
    left_high, right_low, lintel_low, lintel_high = high.copy(), low.copy(), low.copy(), high.copy()
    left_high[along], right_low[along] = opening
    lintel_low[along], lintel_high[along] = opening
    lintel_low[1] = head
    return [box(low, left_high), box(right_low, high), box(lintel_low, lintel_high)]


def shell(low: Point, high: Point, wall: float) -> dict[str, Triangles]:
    """Six solid slabs that close a box of air between two corners, by name: seen from +z, +y up.

    The floor and ceiling run on over the walls, and left and right over back and front: no cracks.

    Args:
        low: Lower corner of the air [m].
        high: Upper corner of the air [m].
        wall: Thickness of the slabs [m].
    """
    (x0, y0, z0), (x1, y1, z1) = low, high
    return {
        "floor": box((x0 - wall, y0 - wall, z0 - wall), (x1 + wall, y0, z1 + wall)),
        "ceiling": box((x0 - wall, y1, z0 - wall), (x1 + wall, y1 + wall, z1 + wall)),
        "left": box((x0 - wall, y0, z0 - wall), (x0, y1, z1 + wall)),
        "right": box((x1, y0, z0 - wall), (x1 + wall, y1, z1 + wall)),
        "back": box((x0, y0, z0 - wall), (x1, y1, z0)),
        "front": box((x0, y0, z1), (x1, y1, z1 + wall)),
    }
