"""Trace and shade the probes' rays: the radiance and the distance each one brings back.

What a ray hits is lit by the lights and by last frame's field, so light bounces once more with
every frame, without end. MFF traces whole paths instead and feeds nothing back.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import drjit as dr
import mitsuba as mi
from annotated_types import Interval
from typing_extensions import Doc

from ddgi import sampling
from ddgi.lighting.guard import finite
from ddgi.probes import contact
from ddgi.probes.bounce import Illumination, arriving, from_field, from_lamps, reflected
from ddgi.probes.rays import ProbeRays
from ddgi.settings_group import settings_group
from ddgi.trace.surface import Surface, offset_origin


@settings_group("gather")
class Settings:
    """What a probe's ray brings back."""

    bounces: Annotated[
        Literal["field", "path"],
        Doc("light beyond a ray's path: last frame's field (SCALE 2.3), or none, for full paths (MFF 3.2.5)"),
    ] = "field"
    path_length: Annotated[
        int,
        Interval(ge=1, le=32),
        Doc(
            "surfaces along a ray's path: with 2 and the field, light between things finer than probes is kept"
        ),
    ] = 1
    energy_preservation: Annotated[
        float,
        Interval(ge=0, le=1),
        Doc("multiplies the field's light at hits, so that bounces cannot gain energy (CTU 4.4)"),
    ] = 1.0
    back_face_distance: Annotated[
        float,
        Interval(ge=0, le=1),
        Doc("distance of a back-face hit times this: shortened by 80 % (SCALE 4.1), 0 in MFF"),
    ] = 0.2
    taps: Annotated[
        Literal["bilinear", "stochastic"],
        Doc(
            "texels read from each map at hits: four, or one picked with their weights (faster; the mean is the same)"
        ),
    ] = "stochastic"


@dataclass
class Gathered:
    """What R P rays brought back, in the lane order of `ProbeRays`."""

    directions: mi.Vector3f  # (R,)
    radiance: mi.Color3f  # (R P,) finite
    distance: mi.Float  # (R P,) in reach units; infinite where nothing was hit
    non_finite: mi.UInt32  # (1,) rays whose radiance was not a number, counted as black


def gather(by: Illumination, rays: ProbeRays, s: contact.Settings) -> Gathered:
    """Trace this frame's rays and shade what they hit with the lights and last frame's field."""
    surface = by.tracer.intersect(
        rays.origin, rays.direction, mi.Bool(True), time=by.time, stream=sampling.PROBE_ALPHA, coherent=True
    )
    radiance, bad = finite(arriving(by, surface, rays.direction) + _along_path(by, surface, s))
    distance = surface.distance * dr.rcp(by.vol.reach(by.layout))
    distance = dr.select(surface.back, distance * by.gather.back_face_distance, distance)
    dr.eval(radiance, distance, bad)  # one kernel: each later use alone would trace the rays again
    return Gathered(rays.directions, radiance, distance, bad)


def _along_path(by: Illumination, surface: Surface, s: contact.Settings) -> mi.Color3f:
    """Radiance that first hits reflect, by a path of `path_length` surfaces and, at its end, the field."""
    width, last = dr.width(surface.distance), by.gather.path_length
    lane = dr.arange(mi.UInt32, width)
    radiance, throughput = dr.zeros(mi.Color3f, width), mi.Color3f(1)
    for length in range(1, last + 1):
        irradiance = from_lamps(by, surface, sampling.PROBE_LIGHT)
        if length == last and by.gather.bounces == "field":
            irradiance += _ambient(by, surface, s)
        radiance += throughput * reflected(surface, irradiance)
        if length == last:
            break
        throughput = dr.select(surface.lit, throughput * surface.albedo, mi.Color3f(0))
        sample = sampling.uniform_2d(by.time, sampling.PROBE_PATH, lane * last + (length - 1))
        # Cosine-distributed directions: the cosine and the 1/pi of Lambert cancel against the density.
        direction = mi.Frame3f(surface.normal).to_world(mi.warp.square_to_cosine_hemisphere(sample))
        origin = offset_origin(surface.position, surface.geometric_normal, direction)
        surface = by.tracer.intersect(
            origin, direction, surface.lit, time=by.time, stream=sampling.PROBE_ALPHA
        )
        radiance += throughput * arriving(by, surface, direction)
    return radiance


def _ambient(by: Illumination, surface: Surface, s: contact.Settings) -> mi.Color3f:
    """Irradiance of the field, and of what is near, at the end of a path."""
    e = from_field(by, surface)
    if s.hits > 0:
        e += contact.near_light(by, surface, s.hits, sampling.PROBE_CONTACT)
    return e
