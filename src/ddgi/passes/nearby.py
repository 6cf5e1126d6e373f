"""Light from what is near each pixel's surface, and too near for the field to know."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

from ddgi import sampling
from ddgi.passes import gbuffer
from ddgi.probes import contact
from ddgi.probes.bounce import Illumination
from ddgi.scene.camera import Camera
from ddgi.trace.surface import Surface


def nearby(
    by: Illumination, camera: Camera, surface: Surface, g: gbuffer.Settings, s: contact.Settings
) -> mi.Color3f:
    """What surfaces nearby add to the field's irradiance in pixels [W/m^2], a sample of it.

    Where only one pixel in `s.every` looks for them in a frame, the others have zero, and frames average.

    Args:
        by: What lights what is found.
        camera: Where the picture is taken from.
        surface: (W H,) what all of its pixels see.
        g: How pixels are sampled.
        s: How far to look, and how often.
    """
    if s.pixels == 0:
        return mi.Color3f(0)
    if s.every == 1:
        return contact.near_light(by, surface, s.pixels, sampling.PIXEL_CONTACT, bounded=True)
    width, height = camera.size
    lane = dr.arange(mi.UInt32, -(-width * height // s.every))
    pixel = contact.thinned(lane, s.every, by.time, row=width)
    seen = gbuffer.gbuffer(by.tracer, camera, by.time, g, pixel)
    whole = dr.zeros(mi.Color3f, width * height)
    found = contact.near_light(by, seen, s.pixels, sampling.PIXEL_CONTACT, bounded=True) * s.every
    dr.scatter(whole, found, pixel, pixel < width * height)
    return whole
