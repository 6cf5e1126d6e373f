"""Look a texture up: bilinear taps out of the one buffer that holds every bitmap of a scene.

Agrees with Mitsuba's `bitmap` plugin to half precision: row 0 lies at v = 0, texel centres at
(i + 1/2) / width, and the wrap mode applies to each tap, not to the coordinate alone.
"""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

import ddgi.trace.materials as materials  # the two modules name each other: attributes, not names
from ddgi.extrema import clamp

REPEAT, CLAMP, MIRROR = 0, 1, 2
"""Codes of `Textures.wrap`."""


def lookup(
    textures: materials.Textures, index: mi.UInt32, uv: mi.Point2f, active: mi.Bool | bool = True
) -> tuple[mi.Color3f, mi.Float]:
    """Read textures at texture coordinates.

    Args:
        textures: All textures of the scene.
        index: (N,) which texture, or NO_TEXTURE.
        uv: (N,) the surface's own coordinates; the texture's transform is applied here.
        active: (N,) lanes to read.

    Returns:
        (N,) linear RGB and (N,) alpha; zero where inactive or without a texture.
    """
    # A gather outside the buffer would crash on LLVM: every one is masked.
    active = active & (index != materials.NO_TEXTURE)
    width = dr.gather(mi.UInt32, textures.width, index, active)
    height = dr.gather(mi.UInt32, textures.height, index, active)
    wrap = dr.gather(mi.UInt32, textures.wrap, index, active)
    nearest = dr.gather(mi.Bool, textures.nearest, index, active)
    offset = dr.gather(mi.UInt32, textures.offset, index, active)
    row_u = dr.gather(mi.Vector4f, textures.to_uv, 2 * index, active)
    row_v = dr.gather(mi.Vector4f, textures.to_uv, 2 * index + 1, active)
    u = dr.fma(row_u.x, uv.x, dr.fma(row_u.y, uv.y, row_u.z))
    v = dr.fma(row_v.x, uv.x, dr.fma(row_v.y, uv.y, row_v.z))

    x0, x1, fx = _taps(u, mi.Float(width), wrap, nearest)
    y0, y1, fy = _taps(v, mi.Float(height), wrap, nearest)

    def texel(x: mi.UInt32, y: mi.UInt32) -> mi.Vector4f:
        return mi.Vector4f(dr.gather(mi.Array4f16, textures.texels, offset + y * width + x, active))

    lower = dr.lerp(texel(x0, y0), texel(x1, y0), fx)
    upper = dr.lerp(texel(x0, y1), texel(x1, y1), fx)
    value = dr.lerp(lower, upper, fy)
    return mi.Color3f(value.x, value.y, value.z), value.w


def _taps(
    t: mi.Float, size: mi.Float, wrap: mi.UInt32, nearest: mi.Bool
) -> tuple[mi.UInt32, mi.UInt32, mi.Float]:
    """The two texels on either side of coordinate t along one axis, and how far t is from the first."""
    # Bring t into one period first: far away, a position in texels would lose its fraction.
    repeated = t - dr.floor(t)
    mirrored = t - 2 * dr.floor(0.5 * t)
    t = dr.select(wrap == REPEAT, repeated, dr.select(wrap == MIRROR, mirrored, clamp(t, -1, 2)))
    position = t * size - dr.select(nearest, 0, 0.5)
    first = dr.floor(position)
    fraction = dr.select(nearest, 0, position - first)
    return _wrapped(first, size, wrap), _wrapped(first + 1, size, wrap), fraction


def _wrapped(position: mi.Float, size: mi.Float, wrap: mi.UInt32) -> mi.UInt32:
    """A texel number inside [0, size) from one that may lie one period outside."""
    around = dr.select(position < 0, position + size, dr.select(position >= size, position - size, position))
    beyond = dr.select(position >= size, 2 * size - 1 - position, position)
    folded = dr.select(position < 0, -1 - position, beyond)
    position = dr.select(wrap == REPEAT, around, dr.select(wrap == MIRROR, folded, position))
    # A NaN coordinate reads the first texel instead of crashing.
    return mi.UInt32(clamp(position, 0, size - 1))
