"""What a ray found: one record for camera, probe and mirror rays."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ddgi.extrema import largest

MOST_REACH = 200.0
"""Coordinates up to this are exact enough for Mitsuba's epsilon, whose unit is 1 [m]."""


@dataclass
class Surface:
    """N ray hits. Lanes that missed hold safe values (unit normals, zero colours), never NaN."""

    valid: mi.Bool  # (N,) something was hit
    back: mi.Bool  # (N,) a single-sided surface from behind: black and opaque
    distance: mi.Float  # (N,) along the ray [m]; infinite for a miss
    position: mi.Point3f  # (N,) [m], from the scene's origin
    slack: mi.Float  # (N,) how far off the surface a ray starts, so as not to meet it again [m]
    normal: mi.Normal3f  # (N,) shading normal, unit, on the side the ray came from
    geometric_normal: mi.Normal3f  # (N,) unit, likewise
    to_viewer: mi.Vector3f  # (N,) unit, back along the ray
    albedo: mi.Color3f  # (N,) in [0, 1]: reflectance of the surface taken as Lambertian
    metallic: mi.Float  # (N,) in [0, 1]
    alpha: mi.Float  # (N,) GGX roughness in (0, 1]
    specular: mi.Float  # (N,) reflectance at normal incidence of the non-metal part
    emission: mi.Color3f  # (N,) emitted radiance towards the viewer

    @property
    def lit(self) -> mi.Bool:
        """Lanes that can reflect light: valid hits on a front."""
        return self.valid & ~self.back


def offset_origin(surface: Surface, direction: mi.Vector3f) -> mi.Point3f:
    """Start of a ray that leaves a surface without meeting it again.

    Moves by `slack` along the geometric normal, to the side of `direction`.
    """
    side = dr.mulsign(surface.slack, dr.dot(surface.geometric_normal, direction))
    return dr.fma(mi.Vector3f(surface.geometric_normal), side, surface.position)


def slack(position: mi.Point3f, unit: mi.Float) -> mi.Float:
    """How inexact positions on surfaces are at most: Mitsuba's epsilon, with a unit that fits the scene [m].

    Args:
        position: (N,) [m].
        unit: (1,) of the scene (`unit_for`).
    """
    return mi.math.RayEpsilon * (unit + largest(dr.abs(position)))


def unit_for(reach: float) -> float:
    """What stands for Mitsuba's 1 in a scene whose largest coordinate is `reach` [m].

    1 in scenes of ordinary size. In smaller ones a ray would start beyond things nearby; in larger
    ones it would start on the surface, where large triangles pass by the origin.
    """
    return min(max(1.0, reach / MOST_REACH), reach)
