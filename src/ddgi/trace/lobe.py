"""How the light that surfaces reflect is shared out between their GGX lobe and their matt part."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

from ddgi.extrema import at_least
from ddgi.trace import albedo
from ddgi.trace.surface import Surface

LEAST = 0.2
"""Share of what a surface reflects that its lobe has, from which on the lobe is followed: gloss on paint has less,
and little of the light in a room goes that way.
"""
SHARPEST = 0.15
"""GGX alpha below which rays of the lobe find lamps that have a size more surely than samples of those meet it."""


def sharp(surface: Surface) -> mi.Bool:
    """Where rays of the lobe bring the light of lamps that have a size. (N,)."""
    return surface.alpha < SHARPEST


def lobe_share(surface: Surface) -> mi.Float:
    """Of the light that surfaces reflect, the share that goes along their lobe; 0 below `LEAST`. (N,)."""
    f0 = dr.lerp(mi.Color3f(surface.specular), surface.base, surface.metallic)
    lobe = mi.luminance(albedo.gloss(f0, surface.alpha))
    part = lobe / at_least(lobe + mi.luminance(_matt(surface)), 1e-6)
    return dr.select(surface.lit & (part > LEAST), part, 0)


def matt_rest(surface: Surface) -> mi.Color3f:
    """What is left of `Surface.albedo` without the lobe, as a share of it; 1 where `lobe_share` is 0. (N,)."""
    rest = _matt(surface) / at_least(surface.albedo, 1e-6)
    return dr.select(lobe_share(surface) > 0, rest, mi.Color3f(1))


def _matt(surface: Surface) -> mi.Color3f:
    return albedo.matt(surface.base, surface.metallic, surface.alpha, surface.disney)
