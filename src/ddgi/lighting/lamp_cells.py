"""The ways light leaves the point, spot and directional lights, laid out on squares.

Each lamp's light is a disc, and that a unit square (concentric map; Shirley and Chiu 1997): directions of a
point light, of the cone of a spot, and places through which a distant light shines at the probes. Equal
areas of the square are equal solid angles, or areas. Squares are cut into cells, so that paths can be sent where they are of use.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ddgi.extrema import at_least, at_most, clamp
from ddgi.lighting.lights import DIRECTIONAL, SPOT, DeltaLight
from ddgi.luminance import LUMINANCE

BELOW_ONE = 1 - 2**-24
"""The largest number below one."""


@dataclass
class Disc:
    """What distant lights shine at: a sphere, which looks like a disc from any side."""

    centre: mi.Point3f  # (1,) [m]
    radius: mi.Float  # (1,) [m]


def leave(
    row: DeltaLight, square: mi.Point2f, disc: Disc, extent: mi.Float
) -> tuple[mi.Point3f, mi.Vector3f]:
    """Rays that leave lamps at places of their squares: origin [m] and direction. (N,) each.

    Args:
        row: (N,) the lamps.
        square: (N,) in [0, 1).
        disc: For distant lights.
        extent: (1,) no coordinate of the scene is larger [m]: they start outside.
    """
    axis = mi.Vector3f(row.direction.xyz)
    frame = mi.Frame3f(axis)
    round_ = mi.warp.square_to_uniform_disk_concentric(square)
    away = dr.squared_norm(round_) * _cap(row)  # 1 - cosine
    aside = round_ * dr.sqrt(at_least(_cap(row) * (2 - away), 0))
    near = frame.to_world(mi.Vector3f(aside.x, aside.y, 1 - away))
    beyond = dr.norm(mi.Vector3f(disc.centre)) + 2 * extent
    across = round_ * disc.radius
    far = disc.centre + frame.to_world(mi.Vector3f(across.x, across.y, -beyond))
    distant = row.kind == DIRECTIONAL
    return dr.select(distant, far, mi.Point3f(row.position.xyz)), dr.select(distant, axis, near)


def square_at(row: DeltaLight, position: mi.Point3f, disc: Disc) -> tuple[mi.Point2f, mi.Bool]:
    """Where on a lamp's square the ray to a point leaves, and whether any does. position: (N,) [m]."""
    frame = mi.Frame3f(mi.Vector3f(row.direction.xyz))
    distant = row.kind == DIRECTIONAL
    start = dr.select(distant, disc.centre, mi.Point3f(row.position.xyz))
    local = frame.to_local(position - start)
    aside2 = dr.square(local.x) + dr.square(local.y)
    length2 = at_least(aside2 + dr.square(local.z), 1e-20)
    cosine = local.z * dr.rsqrt(length2)
    # 1 - cosine, without cancellation straight ahead.
    away = dr.select(cosine > 0, aside2 / length2 / (1 + cosine), 1 - cosine)
    radius2 = dr.select(distant, aside2 / dr.square(disc.radius), away / _cap(row))
    round_ = mi.Point2f(local.x, local.y) * dr.sqrt(radius2 / at_least(aside2, 1e-20))
    return mi.warp.uniform_disk_to_square_concentric(round_), radius2 < 1


def size(row: DeltaLight, disc: Disc) -> mi.Float:
    """Solid angle [sr] of a lamp's square; of a distant light the area [m^2]. (N,)."""
    return dr.select(row.kind == DIRECTIONAL, dr.pi * dr.square(disc.radius), 2 * dr.pi * _cap(row))


def power(row: DeltaLight, disc: Disc) -> mi.Float:
    """Luminous power through a lamp's square, as if even over it [W]. (N,)."""
    r, g, b = (float(share) for share in LUMINANCE)
    return (row.intensity.x * r + row.intensity.y * g + row.intensity.z * b) * size(row, disc)


def cell(square: mi.Point2f, side: int) -> mi.UInt32:
    """Number of the cell that a place is in, of side^2. (N,)."""
    x, y = (mi.UInt32(clamp(u * side, 0, side - 0.5)) for u in square)
    return y * side + x


def within(cell: mi.UInt32, place: mi.Point2f, side: int) -> mi.Point2f:
    """Places on squares from places in cells. cell: (N,); place: (N,) in [0, 1)."""
    row = cell // side
    corner = mi.Point2f(mi.Float(cell - row * side), mi.Float(row))
    return mi.Point2f([at_most((corner[i] + place[i]) * (1 / side), BELOW_ONE) for i in range(2)])


def _cap(row: DeltaLight) -> mi.Float:
    """1 - the cosine of the angle that a lamp shines in. (N,)."""
    return dr.select(row.kind == SPOT, 2 * dr.square(dr.sin(0.5 * row.cone.x)), 2)
