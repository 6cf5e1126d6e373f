"""How much of even light a metallic-roughness material sends back, in all directions together.

The field takes every surface as Lambertian, so this is the albedo it needs. Fits to what Mitsuba's
`roughconductor`, `principled` and `plastic` reflect (single scattering, GGX with Smith's shadowing:
Walter et al. 2007), within 0.008 for any roughness. They take Dr.Jit's numbers as well as Python's.
"""

from __future__ import annotations

from typing import Any

import drjit as dr

from ddgi.extrema import at_most
from ddgi.trace.disney import even as disney_even


def rough_share(alpha: Any) -> Any:
    """Share in (0, 1] of light that GGX microfacets send back which themselves lose none.

    The rest would meet a second facet, which the models do not follow. alpha: GGX roughness in [0, 1].
    """
    return 1 / (1 + 5 / 3 * alpha**1.85)


def grazing(alpha: Any) -> Any:
    """What Schlick's term adds over all directions, per 1 - F0. Rough surfaces have little of it."""
    return 0.056 / (1 + 4.5 * alpha)


def gloss(f0: Any, alpha: Any) -> Any:
    """Reflectance of a GGX lobe over all directions, in [0, 1].

    Args:
        f0: At normal incidence, in [0, 1]; 0 is no lobe at all.
        alpha: GGX roughness in [0, 1].
    """
    return rough_share(alpha) * (f0 + dr.select(f0 > 0, grazing(alpha) * (1 - f0), 0))


def facing(whole: Any, alpha: Any) -> Any:
    """F0 of a metal whose reflectance over all directions is `whole`: the inverse of `gloss`."""
    g = grazing(alpha)
    return (whole / rough_share(alpha) - g) / (1 - g)


def matt(base: Any, metallic: Any, alpha: Any, disney: Any) -> Any:
    """Reflectance of the matt part. Arguments as of `albedo`."""
    share = base * (1 - metallic)
    return dr.select(disney, share * disney_even(dr.sqrt(alpha)), share)


def albedo(base: Any, metallic: Any, alpha: Any, specular: Any, disney: Any) -> Any:
    """Reflectance in [0, 1] of the material as a whole, gloss included.

    Args:
        base: Base colour in [0, 1]: what the matt part reflects, or a metal at normal incidence.
        metallic: In [0, 1].
        alpha: GGX roughness in [0, 1].
        specular: Reflectance of the gloss at normal incidence, in [0, 1].
        disney: Whether the matt part is Disney's (`ddgi.trace.disney`), else it is Lambert's.
    """
    f0 = specular + (base - specular) * metallic
    return at_most(matt(base, metallic, alpha, disney) + gloss(f0, alpha), 1.0)
