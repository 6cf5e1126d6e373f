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
from ddgi.lighting import direct
from ddgi.lighting.guard import finite
from ddgi.lighting.lights import Lights, environment_radiance
from ddgi.probes import query, volume
from ddgi.probes.rays import ProbeRays
from ddgi.probes.volume import ProbeVolume
from ddgi.sampling import Clock
from ddgi.settings_group import settings_group
from ddgi.trace.surface import Surface, offset_origin
from ddgi.trace.tracer import Tracer


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


def gather(
    tracer: Tracer,
    lights: Lights,
    vol: ProbeVolume,
    rays: ProbeRays,
    time: Clock,
    s: Settings,
    direct_settings: direct.Settings,
    query_settings: query.Settings,
    layout: volume.Settings,
) -> Gathered:
    """Trace this frame's rays and shade what they hit with the lights and last frame's field."""
    surface = tracer.intersect(
        rays.origin, rays.direction, mi.Bool(True), time=time, stream=sampling.PROBE_ALPHA, coherent=True
    )
    first = _arriving(lights, surface, rays.direction, direct_settings)
    reflected = _reflected(tracer, lights, vol, surface, time, s, direct_settings, query_settings, layout)
    radiance = first + reflected
    radiance, bad = finite(radiance)
    distance = surface.distance * dr.rcp(vol.reach(layout))
    distance = dr.select(surface.back, distance * s.back_face_distance, distance)
    dr.eval(radiance, distance, bad)  # one kernel: each later use alone would trace the rays again
    return Gathered(rays.directions, radiance, distance, bad)


def _arriving(lights, surface: Surface, direction, s: direct.Settings) -> mi.Color3f:
    """Light of emitters that the ray meets itself, if they are left to the field."""
    radiance = mi.Color3f(0)
    if s.area == "field":
        radiance += surface.emission
    if s.environment == "field" and lights.environment is not None:
        radiance += environment_radiance(lights, direction, ~surface.valid)
    return radiance


def _feedback(vol, surface: Surface, time: Clock, s: Settings, q: query.Settings, layout) -> mi.Color3f:
    """Irradiance of last frame's field at the hits."""
    tap = None
    if s.taps == "stochastic":
        lane = dr.arange(mi.UInt32, dr.width(surface.distance))
        tap = sampling.uniform_2d(time, sampling.PROBE_TAP, lane)
    return query.irradiance(
        vol,
        surface.position,
        surface.normal,
        surface.to_viewer,
        surface.lit,
        layout,
        q,
        tap,
        surface.distance,
    )


def _reflected(
    tracer, lights, vol, surface: Surface, time: Clock, s: Settings, d: direct.Settings, q, layout
):
    """Radiance that first hits reflect, by a path of `path_length` surfaces and, at its end, the field."""
    width = dr.width(surface.distance)
    lane = dr.arange(mi.UInt32, width)
    radiance, throughput = dr.zeros(mi.Color3f, width), mi.Color3f(1)
    for length in range(1, s.path_length + 1):
        lit = direct.direct_light(
            tracer, lights, surface, d,
            time=time, stream=sampling.PROBE_LIGHT, samples=d.probe_samples, specular=False,
        )  # fmt: skip
        irradiance = lit.irradiance
        if length == s.path_length and s.bounces == "field":
            irradiance += _feedback(vol, surface, time, s, q, layout) * s.energy_preservation
        throughput = dr.select(surface.lit, throughput * surface.albedo, mi.Color3f(0))
        radiance += throughput * irradiance * dr.inv_pi
        if length == s.path_length:
            break
        sample = sampling.uniform_2d(time, sampling.PROBE_PATH, lane * s.path_length + (length - 1))
        # Cosine-distributed directions: the cosine and the 1/pi of Lambert cancel against the density.
        direction = mi.Frame3f(surface.normal).to_world(mi.warp.square_to_cosine_hemisphere(sample))
        origin = offset_origin(surface, direction)
        surface = tracer.intersect(origin, direction, surface.lit, time=time, stream=sampling.PROBE_ALPHA)
        radiance += throughput * _arriving(lights, surface, direction, d)
    return radiance
