"""What a ray found: one record for camera, probe and mirror rays."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ddgi.extrema import largest
from ddgi.trace.albedo import albedo

SHARE_OF_EXTENT = 1 / 200
"""Measured: hits on triangles as large as the scene are 3e-8 of its extent off, and no ray met its own
triangle again down to a share of 1/1000.
"""
SHARE_OF_EPSILON = 1 / 4
"""Mitsuba's whole, 1500 roundings, moves the edges of shadows by millimetres where a scene of kilometres lies to one side of
the origin: a mean FLIP of 0.0008 in `house`, and 0.0002 with this.
"""


@dataclass
class Surface:
    """N ray hits. Lanes that missed hold safe values (unit normals, zero colours), never NaN."""

    valid: mi.Bool  # (N,) something was hit
    front: mi.Bool  # (N,) seen from the side that its normals look to
    back: mi.Bool  # (N,) a single-sided surface from behind: black and opaque
    distance: mi.Float  # (N,) along the ray [m]; infinite for a miss
    position: mi.Point3f  # (N,) [m], from the scene's origin
    slack: mi.Float  # (N,) how far off the surface a ray starts, so as not to meet it again [m]
    normal: mi.Normal3f  # (N,) shading normal, unit, on the side the ray came from
    geometric_normal: mi.Normal3f  # (N,) unit, likewise
    to_viewer: mi.Vector3f  # (N,) unit, back along the ray
    base: mi.Color3f  # (N,) base colour in [0, 1]: of the matt part, or of a metal at normal incidence
    metallic: mi.Float  # (N,) in [0, 1]
    alpha: mi.Float  # (N,) GGX roughness in (0, 1]
    specular: mi.Float  # (N,) reflectance at normal incidence of the non-metal part
    disney: mi.Bool  # (N,) the matt part is Disney's, else Lambert's
    emission: mi.Color3f  # (N,) emitted radiance towards the viewer

    @property
    def lit(self) -> mi.Bool:
        """Lanes that can reflect light: valid hits on a front."""
        return self.valid & ~self.back

    @property
    def albedo(self) -> mi.Color3f:
        """Reflectance of the surface taken as Lambertian, in [0, 1]: gloss included. (N,)."""
        whole = albedo(self.base, self.metallic, self.alpha, self.specular, self.disney)
        return dr.select(self.back, mi.Color3f(0), whole)


def offset_origin(surface: Surface, direction: mi.Vector3f) -> mi.Point3f:
    """Start of a ray that leaves a surface without meeting it again.

    Moves by `slack` along the geometric normal, to the side of `direction`.
    """
    side = dr.mulsign(surface.slack, dr.dot(surface.geometric_normal, direction))
    return dr.fma(mi.Vector3f(surface.geometric_normal), side, surface.position)


def matt_bounce(surface: Surface, sample: mi.Point2f) -> tuple[mi.Point3f, mi.Vector3f]:
    """Rays that leave surfaces as light leaves a matt one. sample: (N,) uniform numbers."""
    direction = frame(surface.normal).to_world(mi.warp.square_to_cosine_hemisphere(sample))
    return offset_origin(surface, direction), direction


def frame(normal: mi.Normal3f) -> mi.Frame3f:
    """Axes on a surface, in which random directions are drawn (Duff et al. 2017). normal: (N,) unit.

    They turn over where the normal's z passes -0.0001, and not 0 as Mitsuba's: walls along the axes have
    rounding errors there, by which a scene that is moved would get other random directions.
    """
    n = mi.Vector3f(normal)
    sign = dr.select(n.z > -1e-4, mi.Float(1), mi.Float(-1))
    a = -dr.rcp(sign + n.z)
    b = n.x * n.y * a
    across = mi.Vector3f(dr.fma(sign * n.x * n.x, a, 1), sign * b, -sign * n.x)
    along = mi.Vector3f(b, dr.fma(n.y * n.y, a, sign), -n.y)
    return mi.Frame3f(across, along, n)


def slack(position: mi.Point3f, extent: mi.Float) -> mi.Float:
    """How far from a surface rays start that leave it [m], (N,).

    A share of Mitsuba's epsilon times the largest coordinate, and a share of the scene's extent, for where
    large triangles pass by the origin. Mitsuba has 1 [m] in place of that share, which in a scene of ten
    centimetres passes over things, and in one of kilometres is less than the error.

    Args:
        position: (N,) on surfaces [m].
        extent: (1,) the largest coordinate in the scene [m].
    """
    return mi.math.RayEpsilon * (extent * SHARE_OF_EXTENT + largest(dr.abs(position)) * SHARE_OF_EPSILON)
