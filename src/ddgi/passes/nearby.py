"""Light from what is near each pixel's surface, and too near for the field to know."""

from __future__ import annotations

import mitsuba as mi

from ddgi import sampling
from ddgi.probes import contact
from ddgi.probes.bounce import Around, Illumination
from ddgi.trace.surface import Surface


def nearby(by: Illumination, surface: Surface, there: Around, s: contact.Settings) -> mi.Color3f:
    """What surfaces nearby add to the field's irradiance in pixels [W/m^2], a sample of it.

    Args:
        by: What lights what is found.
        surface: (W H,) what pixels see.
        there: The field around it.
        s: How far to look.
    """
    if s.pixels == 0:
        return mi.Color3f(0)
    return contact.near_light(by, surface, there, s.pixels, sampling.PIXEL_CONTACT, pixels=True)
