"""What surfaces send back along the rays that found them: light of the lamps and of last frame's field.

The field's share makes light bounce once more with every frame, without end.
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
from ddgi.lighting.lights import Lights, environment_radiance
from ddgi.probes import query, volume
from ddgi.probes.lamplit import Sharing
from ddgi.probes.volume import ProbeVolume
from ddgi.sampling import Clock
from ddgi.settings_group import settings_group
from ddgi.trace.surface import Surface
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
    gloss: Annotated[
        Literal["traced", "matt"],
        Doc("metals and gloss that rays meet: rays go on along their lobe, or they count as matt"),
    ] = "traced"


def follows_lobes(tracer: Tracer, s: Settings) -> bool:
    """Whether rays go on from gloss and metals (`probes/glossy.py`)."""
    return s.gloss == "traced" and tracer.shining


@dataclass
class Illumination:
    """All that lights what a ray finds, and how."""

    tracer: Tracer
    lights: Lights
    vol: ProbeVolume
    time: Clock
    gather: Settings
    direct: direct.Settings
    query: query.Settings
    layout: volume.Settings
    sharing: Sharing | None = None  # of the lamps' light on what rays hit; None: it is all theirs


def arriving(
    by: Illumination, surface: Surface, direction: mi.Vector3f, whole: mi.Bool | None = None
) -> mi.Color3f:
    """Radiance of emitters that a ray meets itself, if they are left to the field. (N,).

    whole: (N,) rays that bring the light of sampled emitters too; None: none does.
    """
    whole = mi.Bool(False) if whole is None else whole
    radiance = dr.select(mi.Bool(by.direct.area == "field") | whole, surface.emission, mi.Color3f(0))
    if by.lights.environment is not None:
        counted = mi.Bool(by.direct.environment == "field") | whole
        radiance += environment_radiance(by.lights, direction, ~surface.valid & counted)
    return radiance


def from_lamps(
    by: Illumination, surface: Surface, stream: int, share: direct.Share | None = None
) -> mi.Color3f:
    """Irradiance E [W/m^2] that comes straight from the lamps, or the `share` of it that counts. (N,)."""
    return direct.direct_light(
        by.tracer, by.lights, surface, by.direct,
        time=by.time, stream=stream, samples=by.direct.probe_samples, specular=False, share=share,
    ).irradiance  # fmt: skip


def from_field(by: Illumination, surface: Surface) -> mi.Color3f:
    """Irradiance E [W/m^2] of last frame's field, as much as one bounce hands on (CTU 4.4). (N,)."""
    receiver = query.Receiver.on(surface)
    width = dr.width(surface.distance)
    e = query.irradiance(by.vol, receiver, by.layout, by.query, by.tracer, tap(by, width))
    return e * by.gather.energy_preservation


def tap(by: Illumination, width: int) -> mi.Point2f | None:
    """Which texel of each map a lookup takes, for `gather.taps`; None: all four. (width,)."""
    if by.gather.taps == "bilinear":
        return None
    return sampling.uniform_2d(by.time, sampling.PROBE_TAP, dr.arange(mi.UInt32, width))


def reflected(surface: Surface, irradiance: mi.Color3f) -> mi.Color3f:
    """Radiance that surfaces, taken as Lambertian, reflect of an irradiance. (N,)."""
    return dr.select(surface.lit, surface.albedo * irradiance * dr.inv_pi, mi.Color3f(0))
