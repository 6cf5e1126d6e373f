"""Reflection of light from one direction: Lambert plus a GGX lobe."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

from ddgi.extrema import at_least, clamp, largest
from ddgi.trace.surface import Surface


def lambert(surface: Surface) -> mi.Color3f:
    """The Lambertian part of the BRDF [1/sr], (N,); metals have none."""
    return surface.albedo * ((1 - surface.metallic) * dr.inv_pi)


def ggx(surface: Surface, to_light: mi.Vector3f) -> mi.Color3f:
    """The specular part of the BRDF [1/sr], (N,).

    Microfacets with the GGX distribution (Walter et al. 2007), Smith's height-correlated
    visibility (Heitz 2014) and Schlick's Fresnel term.
    """
    n, v = mi.Vector3f(surface.normal), surface.to_viewer
    half = dr.normalize(v + to_light)
    n_h, n_l = at_least(dr.dot(n, half), 0), at_least(dr.dot(n, to_light), 1e-4)
    n_v, v_h = at_least(dr.dot(n, v), 1e-4), clamp(dr.dot(v, half), 0, 1)
    a2 = dr.square(at_least(surface.alpha, 1e-3))
    distribution = a2 * dr.inv_pi / dr.square(dr.square(n_h) * (a2 - 1) + 1)
    shadow = n_l * dr.sqrt(a2 + (1 - a2) * dr.square(n_v)) + n_v * dr.sqrt(a2 + (1 - a2) * dr.square(n_l))
    f0 = dr.lerp(mi.Color3f(surface.specular), surface.albedo, surface.metallic)
    grazing = dr.power(1 - v_h, 5)
    fresnel = f0 + (1 - f0) * dr.select(largest(f0) > 0, grazing, 0)
    return fresnel * (distribution * 0.5 / at_least(shadow, 1e-6))
