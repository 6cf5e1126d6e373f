"""Primary visibility: what each pixel of the camera sees."""

from __future__ import annotations

from typing import Annotated

import drjit as dr
import mitsuba as mi
from typing_extensions import Doc

from ddgi import sampling
from ddgi.sampling import Clock
from ddgi.scene.camera import Camera, camera_rays
from ddgi.settings_group import settings_group
from ddgi.trace.surface import Surface
from ddgi.trace.tracer import Tracer


@settings_group("gbuffer")
class Settings:
    """How pixels are sampled."""

    antialias: Annotated[
        bool, Doc("move the sample within the pixel from frame to frame; frames then average to a box filter")
    ] = True


def gbuffer(tracer: Tracer, camera: Camera, time: Clock, s: Settings) -> Surface:
    """The surface behind each pixel, row by row from the top left, (W H,) lanes."""
    # All pixels share one offset per frame: neighbouring rays stay alike.
    within = mi.Point2f(0.5)
    if s.antialias:
        within = sampling.low_discrepancy_2d(time, sampling.PIXEL, mi.UInt32(0), time.tick)
    pixel = dr.arange(mi.UInt32, camera.size[0] * camera.size[1])
    origin, direction = camera_rays(camera, tracer.origin, pixel, within)
    return tracer.intersect(
        origin, direction, mi.Bool(True), time=time, stream=sampling.PIXEL_ALPHA, coherent=True, bumps=True
    )
