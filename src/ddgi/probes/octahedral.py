"""The octahedral map: directions on the unit sphere to and from the unit square.

The sphere is projected on the octahedron |x| + |y| + |z| = 1, whose lower half is folded over the
edges of its upper half (Cigolle et al. 2014; SCALE 3). Squares run from -1 to 1 here.
"""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

from ddgi.extrema import at_least, clamp


def direction_to_square(direction: mi.Vector3f) -> mi.Vector2f:
    """Map directions to [-1, 1]^2. direction: (N,) any length but zero. Inverse: `square_to_direction`."""
    scale = dr.rcp(at_least(dr.abs(direction.x) + dr.abs(direction.y) + dr.abs(direction.z), 1e-30))
    x, y = direction.x * scale, direction.y * scale
    lower = direction.z < 0
    return mi.Vector2f(
        dr.select(lower, dr.mulsign(1 - dr.abs(y), x), x),
        dr.select(lower, dr.mulsign(1 - dr.abs(x), y), y),
    )


def square_to_direction(square: mi.Vector2f) -> mi.Vector3f:
    """Map [-1, 1]^2 to unit directions. square: (N,). Inverse: `direction_to_square`."""
    z = 1 - dr.abs(square.x) - dr.abs(square.y)
    fold = at_least(-z, 0)
    return dr.normalize(
        mi.Vector3f(square.x - dr.mulsign(fold, square.x), square.y - dr.mulsign(fold, square.y), z)
    )


def texel_directions(size: int) -> mi.Vector3f:
    """Directions of the centres of a size x size map's interior texels, row by row. (size^2,)."""
    return texel_direction(dr.arange(mi.UInt32, size * size), size)


def texel_direction(texel: mi.UInt32, size: int) -> mi.Vector3f:
    """Direction of the centre of interior texels, counted row by row. texel: (N,); result: (N,)."""
    x, y = mi.Float(texel % size), mi.Float(texel // size)
    return square_to_direction(mi.Vector2f((x + 0.5) * (2 / size) - 1, (y + 0.5) * (2 / size) - 1))


def bordered(texel: mi.UInt32, size: int) -> mi.UInt32:
    """Place of an interior texel in the map with its border. Inverse on the interior: `interior`."""
    row = texel // size
    return (row + 1) * (size + 2) + (texel - row * size) + 1


def interior(texel: mi.UInt32, size: int) -> mi.UInt32:
    """Which interior texel a texel of the bordered map shows.

    A map of size^2 interior texels carries a border one texel wide, so that bilinear
    interpolation never leaves it: crossing an edge of the octahedral square comes back on the
    same edge, mirrored (CTU 4.5, Figure 4.9).

    Args:
        texel: (N,) numbers below (size + 2)^2, row by row.
        size: Interior texels per side.

    Returns:
        (N,) numbers below size^2, row by row.
    """
    row = texel // (size + 2)
    x, y = mi.Int32(texel - row * (size + 2)) - 1, mi.Int32(row) - 1
    out_x, out_y = (x < 0) | (x >= size), (y < 0) | (y >= size)
    x, y = clamp(x, 0, size - 1), clamp(y, 0, size - 1)
    x, y = dr.select(out_y, size - 1 - x, x), dr.select(out_x, size - 1 - y, y)
    return mi.UInt32(y * size + x)


def texel_at(
    square: mi.Vector2f, size: int, tap: mi.Point2f | None = None
) -> tuple[mi.UInt32, tuple[mi.Float, mi.Float] | None]:
    """Which texel of a bordered map to read at a point of the square, and how far towards the next.

    Args:
        square: (N,) in [-1, 1]^2.
        size: Interior texels per side.
        tap: (N,) uniform numbers. With them one of the four texels around is picked with its bilinear
            weight, and there are no fractions.

    Returns:
        Number of the first of the four texels, (N,), and the fractions in x and y, or none.
    """
    x, y = (dr.fma(c, size / 2, size / 2 + 0.5) for c in (square.x, square.y))
    if tap is not None:
        x, y = x + tap.x, y + tap.y
    column, row = mi.UInt32(x), mi.UInt32(y)
    texel = row * (size + 2) + column
    if tap is not None:
        return texel, None
    return texel, (x - mi.Float(column), y - mi.Float(row))
