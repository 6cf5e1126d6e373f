"""Light of each pixel: direct, indirect and emitted."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ddgi import sampling
from ddgi.lighting import brdf, direct
from ddgi.lighting.lights import Lights, environment_radiance
from ddgi.sampling import Clock
from ddgi.trace.lobe import sharp
from ddgi.trace.surface import Surface
from ddgi.trace.tracer import Tracer


@dataclass
class Shaded:
    """Radiance towards the camera, by where it comes from. (N,) each [W/(m^2 sr)]; they add up."""

    direct: mi.Color3f
    indirect: mi.Color3f
    emission: mi.Color3f
    irradiance: mi.Color3f  # (N,) indirect irradiance E [W/m^2], before the albedo


def shade(
    tracer: Tracer,
    lights: Lights,
    surface: Surface,
    specular: bool,
    time: Clock,
    direct_settings: direct.Settings,
    ambient: mi.Color3f,
    mirrored: mi.Color3f | None,
) -> Shaded:
    """Light each pixel: lights exactly or sampled, everything else from the field.

    ambient: (N,) irradiance of the field, with what surfaces nearby add to it (`passes/nearby.py`) [W/m^2].
    mirrored: (N,) radiance that gloss and metals reflect of other surfaces (`passes/gloss.py`); None: not
        known, they reflect the field's light as if they were matt.
    """
    arriving = direct.direct_light(
        tracer, lights, surface, direct_settings,
        time=time, stream=sampling.PIXEL_LIGHT, samples=direct_settings.camera_samples, specular=specular,
        apart=None if mirrored is None else sharp(surface),
    )  # fmt: skip
    ambient = dr.select(surface.lit, ambient, mi.Color3f(0))
    if mirrored is None:
        indirect = surface.albedo * ambient * dr.inv_pi
    else:
        indirect = brdf.matt_under_even_light(surface) * ambient + mirrored
    background = environment_radiance(lights, -surface.to_viewer, ~surface.valid)
    return Shaded(
        direct=dr.select(surface.lit, arriving.matt + arriving.specular, 0),
        indirect=indirect,
        emission=surface.emission + background,
        irradiance=ambient,
    )
