"""What glossy surfaces and metals reflect of other surfaces and of the sky: a traced path a pixel."""

from __future__ import annotations

from typing import Annotated

import drjit as dr
import mitsuba as mi
from annotated_types import Interval
from typing_extensions import Doc

from ddgi import sampling
from ddgi.extrema import at_least, at_most
from ddgi.lighting import brdf
from ddgi.lighting.direct import direct_light
from ddgi.probes.bounce import Illumination, around, arriving, from_field, reflected
from ddgi.sampling import Clock
from ddgi.settings_group import settings_group
from ddgi.trace.lobe import sharp
from ddgi.trace.surface import Surface, offset_origin

MOST = 10.0
"""Times the mean radiance around a pixel's point that a ray of a wide lobe brings at most, lamps aside."""
METAL = 0.5
"""How metallic a surface is that a path goes on from, if it came from a sharp lobe; others end it, as if they were
matt. Lamps' highlights in metal seen by wide lobes would be dots (caustics).
"""


@settings_group("gloss")
class Settings:
    """How pixels see reflections of what is not a lamp."""

    bounces: Annotated[
        int,
        Interval(ge=0, le=8),
        Doc(
            "reflections in a row that are traced, one path a pixel and frame, where frames add up: single ones would show its grain; 0: none, gloss and metals reflect the field's light as if they were matt"
        ),
    ] = 2


def mirrored(by: Illumination, surface: Surface, ambient: mi.Color3f, s: Settings) -> mi.Color3f | None:
    """Radiance that the GGX lobe sends to the viewer: a sample of it.

    Lamps that are sampled count where the lobe is `sharp`; elsewhere direct light has their highlights.

    Args:
        by: What lights what is found.
        surface: (W H,) what pixels see.
        ambient: (W H,) irradiance of the field there [W/m^2].
        s: How far paths go.

    Returns:
        (W H,) [W/(m^2 sr)]; None where nothing is to be traced.
    """
    if s.bounces == 0:
        return None
    shining = surface.lit & ((surface.metallic > 0) | (surface.specular > 0))
    usual = ambient * dr.inv_pi
    return dr.if_stmt(
        (surface, usual),
        shining,
        lambda surface, usual: _path(by, surface, usual, 0, s),
        lambda *_: mi.Color3f(0),
    )


def _path(by: Illumination, surface: Surface, usual: mi.Color3f, bounce: int, s: Settings) -> mi.Color3f:
    """Radiance that the lobe sends back, by one ray and what follows from where it ends. (W H,).

    usual: (W H,) the mean radiance around the pixels' points. bounce: How many reflections came before.
    """
    lane = dr.arange(mi.UInt32, dr.width(surface.distance))
    direction, share = brdf.sample_ggx(surface, _numbers(by.time, lane * s.bounces + bounce, bounce))
    outside = dr.dot(mi.Vector3f(surface.geometric_normal), direction) > 0
    origin = offset_origin(surface, direction)
    seen = by.tracer.intersect(
        origin, direction, outside, time=by.time, stream=sampling.PIXEL_GLOSS_ALPHA, bumps=True
    )
    onward = mi.Bool(False)
    further = mi.Color3f(0)
    if bounce + 1 < s.bounces:
        onward = seen.lit & (seen.metallic > METAL) & sharp(surface)
        # A branch, as few paths go on.
        further = dr.if_stmt(
            (seen, usual),
            onward,
            lambda seen, usual: _path(by, seen, usual, bounce + 1, s),
            lambda *_: mi.Color3f(0),
        )
    back = _bounded(_sent_back(by, seen, onward), surface, usual)
    met = arriving(by, seen, direction, whole=sharp(surface)) + back + further
    return dr.select(outside, share * met, mi.Color3f(0))


def _numbers(time: Clock, index: mi.UInt32, bounce: int) -> mi.Point2f:
    """Random numbers of a bounce. (N,).

    The first has a sequence that is not the one that lamps are sampled with, as in `probes/contact.py`.
    Further bounces have none at all: two of a kind move in step, and what they show together would not
    converge.
    """
    if bounce == 0:
        return sampling.kronecker_2d(time, sampling.PIXEL_GLOSS, index, time.tick)
    return sampling.uniform_2d(time, sampling.PIXEL_GLOSS, index)


def _bounded(radiance: mi.Color3f, surface: Surface, usual: mi.Color3f) -> mi.Color3f:
    """Of what wide lobes meet, at most `MOST` times the usual: walls right beside lamps are seen by a ray in a
    thousand, and leave dots that no number of frames takes away. (W H,) each.
    """
    most = MOST * mi.luminance(usual)
    scale = at_most(most / at_least(mi.luminance(radiance), 1e-30), 1)
    return dr.select(sharp(surface), radiance, radiance * scale)


def _sent_back(by: Illumination, surface: Surface, onward: mi.Bool) -> mi.Color3f:
    """Radiance of what paths meet: of metals that they go on from, the lamps' highlight alone. (W H,)."""
    lamps = direct_light(
        by.tracer, by.lights, surface, by.direct,
        time=by.time, stream=sampling.PIXEL_GLOSS, samples=by.direct.probe_samples, specular=True,
        apart=sharp(surface),
    )  # fmt: skip
    matt = reflected(surface, lamps.irradiance + from_field(by, around(by, surface)))
    return dr.select(onward, lamps.specular, matt)
