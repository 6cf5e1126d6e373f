"""Reflection of light from one direction: a matt part plus a GGX lobe."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

from ddgi.extrema import at_least, clamp, largest
from ddgi.trace import disney
from ddgi.trace.surface import Surface, frame

NARROWEST = 0.05
"""GGX alpha of the narrowest highlight of a lamp: one without size would else be seen in no pixel, or in one."""


def matt(surface: Surface, to_light: mi.Vector3f) -> mi.Color3f:
    """The matt part of the BRDF [1/sr], (N,): Lambert's or Disney's; metals have none."""
    n, v = mi.Vector3f(surface.normal), surface.to_viewer
    light, viewer = (clamp(dr.dot(n, way), 0, 1) for way in (to_light, v))
    more = disney.towards(light, viewer, dr.dot(v, to_light), dr.sqrt(surface.alpha))
    return _lambert(surface) * dr.select(surface.disney, more, 1)


def matt_under_even_light(surface: Surface) -> mi.Color3f:
    """The mean of the matt part over light from everywhere, by the cosine [1/sr]. (N,)."""
    viewer = clamp(dr.dot(mi.Vector3f(surface.normal), surface.to_viewer), 0, 1)
    more = disney.under_even_light(viewer, dr.sqrt(surface.alpha))
    return _lambert(surface) * dr.select(surface.disney, more, 1)


def _lambert(surface: Surface) -> mi.Color3f:
    return surface.base * ((1 - surface.metallic) * dr.inv_pi)


def ggx(surface: Surface, to_light: mi.Vector3f) -> mi.Color3f:
    """The specular part of the BRDF [1/sr], (N,).

    Microfacets with the GGX distribution (Walter et al. 2007), Smith's height-correlated
    visibility (Heitz 2014) and Schlick's Fresnel term. The lobe is no narrower than that of `NARROWEST`.
    """
    n, v = mi.Vector3f(surface.normal), surface.to_viewer
    half = dr.normalize(v + to_light)
    n_h, n_l = at_least(dr.dot(n, half), 0), at_least(dr.dot(n, to_light), 1e-4)
    n_v, v_h = at_least(dr.dot(n, v), 1e-4), clamp(dr.dot(v, half), 0, 1)
    a2 = dr.square(at_least(surface.alpha, NARROWEST))
    distribution = a2 * dr.inv_pi / dr.square(dr.square(n_h) * (a2 - 1) + 1)
    shadow = n_l * dr.sqrt(a2 + (1 - a2) * dr.square(n_v)) + n_v * dr.sqrt(a2 + (1 - a2) * dr.square(n_l))
    return fresnel(surface, v_h) * (distribution * 0.5 / at_least(shadow, 1e-6))


def fresnel(surface: Surface, v_h: mi.Float) -> mi.Color3f:
    """Schlick's reflectance of a facet, (N,). v_h: (N,) cosine between its normal and the viewer."""
    f0 = dr.lerp(mi.Color3f(surface.specular), surface.base, surface.metallic)
    return f0 + (1 - f0) * dr.select(largest(f0) > 0, dr.power(1 - v_h, 5), 0)


def sample_ggx(surface: Surface, sample: mi.Point2f) -> tuple[mi.Vector3f, mi.Color3f]:
    """Directions of light that the specular part reflects to the viewer.

    Facets are picked as the viewer sees them (Heitz 2018), by spherical caps (Dupuy and Benyoub 2023).

    Args:
        surface: (N,) points.
        sample: (N,) uniform numbers.

    Returns:
        (N,) unit directions, and the BRDF times the cosine over their density, in [0, 1]; 0 for those
        that lead below the shading normal's horizon.
    """
    axes = frame(surface.normal)
    alpha = at_least(surface.alpha, 1e-3)
    v = axes.to_local(surface.to_viewer)
    v.z = at_least(v.z, 1e-4)
    stretched = dr.normalize(mi.Vector3f(v.x * alpha, v.y * alpha, v.z))
    z = dr.fma(1 - sample.y, 1 + stretched.z, -stretched.z)
    radius = dr.sqrt(at_least(1 - z * z, 0))
    sine, cosine = dr.sincos(dr.two_pi * sample.x)
    half = mi.Vector3f(radius * cosine, radius * sine, z) + stretched
    half = dr.normalize(mi.Vector3f(half.x * alpha, half.y * alpha, at_least(half.z, 1e-6)))
    v_h = clamp(dr.dot(v, half), 0, 1)
    light = 2 * v_h * half - v
    masked = 1 + _smith(v.z, alpha)
    share = fresnel(surface, v_h) * (masked / (masked + _smith(light.z, alpha)))
    return axes.to_world(light), dr.select(light.z > 0, share, mi.Color3f(0))


def _smith(cosine: mi.Float, alpha: mi.Float) -> mi.Float:
    """Smith's Lambda for GGX: facets hidden per facet seen, from a direction above the horizon."""
    c2 = at_least(cosine * cosine, 1e-8)
    return 0.5 * (dr.sqrt(1 + alpha * alpha * (1 - c2) / c2) - 1)
