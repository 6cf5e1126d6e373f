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


@dataclass
class Around:
    """Last frame's field around N surfaces: found once, read as often as wanted."""

    at: query.Receiver
    probes: query.Shares
    tap: mi.Point2f | None  # (N,) picks the texel that is read of each map; None: all four are


def around(by: Illumination, surface: Surface, *, whole: bool = False) -> Around:
    """The field around surfaces. whole: All texels are read, whatever `gather.taps` says of hits. surface: (N,)."""
    at, tap = query.Receiver.on(surface), None
    if not whole and by.gather.taps == "stochastic":
        lane = dr.arange(mi.UInt32, dr.width(surface.distance))
        tap = sampling.uniform_2d(by.time, sampling.PROBE_TAP, lane)
    return Around(at, query.shares(by.vol, at, by.layout, by.query, by.tracer, tap), tap)


def from_field(by: Illumination, there: Around) -> mi.Color3f:
    """Irradiance E [W/m^2] of last frame's field, as much as one bounce hands on (CTU 4.4). (N,)."""
    e = query.irradiance_by(by.vol, there.at, there.probes, by.layout, by.query, there.tap)
    return e * by.gather.energy_preservation


def known(by: Illumination, there: Around, direction: mi.Vector3f) -> mi.Color3f:
    """Radiance [W/(m^2 sr)] that the probes around surfaces saw in a direction. (N,)."""
    return query.radiance_by(by.vol, there.at, there.probes, direction, by.layout, there.tap)


def reflected(surface: Surface, irradiance: mi.Color3f) -> mi.Color3f:
    """Radiance that surfaces, taken as Lambertian, reflect of an irradiance. (N,)."""
    return dr.select(surface.lit, surface.albedo * irradiance * dr.inv_pi, mi.Color3f(0))
