"""Direct light: what surfaces reflect of the lights, from the lights alone.

Point, spot and directional lights are exact. Area lights and the environment are either sampled
here, or left to the field; then the probes' rays that hit them carry their radiance instead, so
the energy is the same either way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Literal, TypeAlias

import drjit as dr
import mitsuba as mi
from annotated_types import Interval
from typing_extensions import Doc

from ddgi.extrema import at_least, largest
from ddgi.lighting import brdf
from ddgi.lighting.lights import (
    DeltaLight,
    Lights,
    LightSample,
    area_light,
    delta_light,
    environment_light,
    from_delta,
    pick_area_light,
)
from ddgi.sampling import Clock, low_discrepancy, low_discrepancy_2d
from ddgi.settings_group import settings_group
from ddgi.trace.surface import Surface, offset_origin
from ddgi.trace.tracer import Tracer

Source = Literal["sampled", "field"]

Share: TypeAlias = "Callable[[DeltaLight, mi.UInt32, Surface], mi.Float]"
"""How much of a lamp, with its number, counts on each surface, in [0, 1]. (N,)."""

UNROLLED_LIGHTS = 4
"""Up to this many delta lights each have their own code; more are looped over."""


@settings_group("direct")
class Settings:
    """Where direct light comes from."""

    area: Annotated[Source, Doc("area lights: sampled with shadow rays, or left to the probes")] = "sampled"
    environment: Annotated[
        Source, Doc("the environment: sampled with shadow rays, or left to the probes")
    ] = "field"
    camera_samples: Annotated[
        int, Interval(ge=1, le=256), Doc("shadow rays per pixel and frame to sampled lights of each kind")
    ] = 4
    probe_samples: Annotated[
        int, Interval(ge=1, le=64), Doc("shadow rays per probe hit to sampled lights of each kind")
    ] = 1


@dataclass
class Reflected:
    """Direct light on N surfaces, and what leaves them towards the viewer, by lobe [W/(m^2 sr)]."""

    irradiance: mi.Color3f  # (N,) irradiance E [W/m^2] on the surface
    matt: mi.Color3f  # (N,) radiance reflected by the matt part
    specular: mi.Color3f  # (N,) radiance reflected by the GGX lobe


def direct_light(
    tracer: Tracer,
    lights: Lights,
    surface: Surface,
    s: Settings,
    *,
    time: Clock,
    stream: int,
    samples: int,
    specular: bool,
    share: Share | None = None,
    apart: mi.Bool | None = None,
) -> Reflected:
    """Light that reaches surfaces straight from the lights.

    Args:
        tracer: Answers the shadow rays.
        lights: All lights of the scene.
        surface: (N,) where the light arrives.
        s: Which lights are sampled.
        time: Random source.
        stream: Which stream of it (`ddgi.sampling`).
        samples: Shadow rays per point to each kind of sampled light.
        specular: Evaluate the GGX lobe too.
        share: How much of every delta light counts here; None: all of it.
        apart: (N,) points whose GGX lobe has the sampled lights from elsewhere; None: all have them from here.
    """
    out = Reflected(mi.Color3f(0), mi.Color3f(0), mi.Color3f(0))
    out = _add_delta_lights(out, tracer, lights, surface, specular, share)
    sampled = []
    if s.area == "sampled" and lights.area_count:
        sampled.append(_area_sample)
    if s.environment == "sampled" and lights.environment is not None:
        sampled.append(_environment_sample)
    lane = dr.arange(mi.UInt32, dr.width(surface.distance))
    for kind, draw in enumerate(sampled):
        for number in range(samples):
            # Points of one low-discrepancy sequence over the samples of a frame and over frames.
            sequence = time.tick * samples + number
            point = low_discrepancy_2d(time, stream, lane * 2 + kind, sequence)
            light = draw(lights, surface, point, low_discrepancy(time, stream, lane * 2 + kind, sequence))
            light.power *= 1 / samples
            out = _add(out, tracer, surface, light, specular, apart)
    return out


def _add_delta_lights(out, tracer, lights, surface, specular, share) -> Reflected:
    count = lights.delta.count

    def shone(row: DeltaLight, number: mi.UInt32) -> LightSample:
        light = from_delta(row, surface.position)
        return light if share is None else replace(light, power=light.power * share(row, number, surface))

    if count <= UNROLLED_LIGHTS:
        for number in range(count):
            row = delta_light(lights.delta, mi.UInt32(number))
            if not dr.flag(dr.JitFlag.SymbolicScope):  # inside a branch nothing can be evaluated
                dr.eval(row)  # scalars in memory: else every lane would gather the row for itself
            out = _add(out, tracer, surface, shone(row, mi.UInt32(number)), specular)
        return out

    def body(number, *before):
        light = shone(delta_light(lights.delta, number), number)
        got = _add(Reflected(*before), tracer, surface, light, specular)
        return number + 1, got.irradiance, got.matt, got.specular

    nothing = dr.zeros(mi.Color3f, dr.width(surface.distance))
    start = (mi.UInt32(0), nothing, nothing, nothing)
    _, *sums = dr.while_loop(start, lambda number, *_: number < count, body, label="delta lights")
    return Reflected(*sums)


def _area_sample(lights: Lights, surface: Surface, point: mi.Point2f, choice: mi.Float) -> LightSample:
    """One point on one emitter."""
    if lights.area_count == 1:
        return area_light(lights, mi.UInt32(0), surface.position, point, surface.lit)
    number, chance = pick_area_light(lights, surface.position, choice)
    light = area_light(lights, number, surface.position, point, surface.lit & (chance > 0))
    light.power /= at_least(chance, 1e-12)
    return light


def _environment_sample(lights: Lights, surface: Surface, point: mi.Point2f, choice: mi.Float) -> LightSample:
    return environment_light(lights, surface.position, point, surface.lit)


def _add(
    out: Reflected, tracer, surface: Surface, light: LightSample, specular: bool, apart: mi.Bool | None = None
) -> Reflected:
    """Add one light sample, if nothing stands in its way."""
    cosine = dr.dot(mi.Vector3f(surface.normal), light.direction)
    # A bumped normal may see a light that the surface itself turns away from.
    outside = dr.dot(mi.Vector3f(surface.geometric_normal), light.direction) > 0
    active = surface.lit & (cosine > 0) & outside & (largest(light.power) > 0)
    origin = offset_origin(surface, light.direction)
    ahead = dr.dot(origin - surface.position, light.direction)  # or the ray might end behind a near lamp
    shadow_end = (light.distance - ahead) * (1 - 1e-3)
    visible = tracer.visible(origin, light.direction, shadow_end, active)
    arriving = light.power * (at_least(cosine, 0) * visible)
    lobe = out.specular
    if specular:
        shown = active if apart is None else active & ~apart
        lobe = lobe + dr.select(shown, brdf.ggx(surface, light.direction) * arriving, mi.Color3f(0))
    matt = out.matt + brdf.matt(surface, light.direction) * arriving
    return Reflected(out.irradiance + arriving, matt, lobe)
