"""Disney's diffuse term: how the matt part of `principled`, and so of glTF materials here, differs from Lambert's.

Burley 2012, 5.3: (1 + F a)(1 + F b) times Lambert's, with a = (1 - cos)^5 of the angle to the light, b of that
to the viewer, and F = 2 roughness cos^2 - 1/2 of the angle between the light and the half vector, whose cos^2
is (1 + cos) / 2 of the angle between light and viewer. Rough surfaces are brighter along the surface, smooth
ones darker. The means below are over light from everywhere, or from there to everywhere, by the cosine.
They take Dr.Jit's numbers as well as Python's.
"""

from __future__ import annotations

from typing import Any


def towards(light: Any, viewer: Any, between: Any, roughness: Any) -> Any:
    """Times Lambert's, in [0.25, 6.25], for one direction of light.

    Args:
        light: Cosine of the angle between normal and light, in [0, 1].
        viewer: Of that between normal and viewer, in [0, 1].
        between: Of that between light and viewer, in [-1, 1].
        roughness: In [0, 1]; the square root of GGX alpha.
    """
    more = roughness * (1 + between) - 0.5
    return (1 + more * (1 - light) ** 5) * (1 + more * (1 - viewer) ** 5)


def under_even_light(viewer: Any, roughness: Any) -> Any:
    """Times Lambert's, in [0.50, 1.98], where as much light comes from everywhere. Arguments as of `towards`."""
    # Means of F, of F a and of F^2 a; those of a, of a cos, of a cos^2 are 1/21, 1/84, 1/252.
    first = roughness * (1 + viewer * (2 / 3)) - 0.5
    weighted = roughness * (1 / 21 + viewer / 84) - 0.5 / 21
    across = viewer**2 / 252 + (1 - viewer**2) * (11 / 504)
    squared = 0.25 / 21 - roughness * (1 / 21 + viewer / 84) + roughness**2 * (1 / 21 + viewer / 42 + across)
    return 1 + weighted + (1 - viewer) ** 5 * (first + squared)


def even(roughness: Any) -> Any:
    """Times Lambert's, over all directions of both: 0.953 for smooth surfaces, 1.065 for rough ones."""
    return 0.95295 + roughness * (0.10870 + roughness * 0.00352)
