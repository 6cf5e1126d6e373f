"""Colours and opacities that vertices carry, interpolated over the triangle that a ray met."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

NO_COLORS = 0xFFFFFFFF
"""In `VertexColors.first`: the vertices of this row have none."""


@dataclass
class VertexColors:
    """All coloured meshes of a scene in one buffer: F triangles, V vertices, S rows of the material table."""

    first: mi.UInt32  # (S,) first triangle of each row, or NO_COLORS
    corners: mi.UInt32  # (3 F,) vertex numbers
    values: mi.Float  # (4 V,) linear RGB, then opacity, in [0, 1]


@dataclass
class Corner:
    """Where on its mesh each of N rays met it."""

    face: mi.UInt32  # number of the triangle
    weights: mi.Point2f  # barycentric, of the second and third vertex


def lookup(
    colors: VertexColors, row: mi.UInt32, corner: Corner, active: mi.Bool
) -> tuple[mi.Color3f, mi.Float]:
    """Colour and opacity to multiply those of the material with; one where a row has none."""
    first = dr.gather(mi.UInt32, colors.first, row, active)
    active = active & (first != NO_COLORS)
    vertices = [dr.gather(mi.UInt32, colors.corners, 3 * (first + corner.face) + k, active) for k in range(3)]
    a, b, c = (dr.gather(mi.Vector4f, colors.values, vertex, active) for vertex in vertices)
    u, v = corner.weights.x, corner.weights.y
    value = dr.select(active, dr.fma(c - a, v, dr.fma(b - a, u, a)), 1)
    return mi.Color3f(value.x, value.y, value.z), value.w
