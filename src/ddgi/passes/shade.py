"""Light of each pixel: direct, indirect and emitted."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ddgi import sampling
from ddgi.lighting import brdf, direct
from ddgi.lighting.lights import Lights, environment_radiance
from ddgi.probes import contact, gather, query, volume
from ddgi.probes.bounce import Illumination
from ddgi.probes.field import IrradianceField, irradiance
from ddgi.sampling import Clock
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
    field: IrradianceField,
    surface: Surface,
    specular: bool,
    time: Clock,
    direct_settings: direct.Settings,
    layout: volume.Settings,
    query_settings: query.Settings,
    gather_settings: gather.Settings,
    contact_settings: contact.Settings,
) -> Shaded:
    """Light each pixel: lights exactly or sampled, everything else from the field and what is near."""
    arriving = direct.direct_light(
        tracer, lights, surface, direct_settings,
        time=time, stream=sampling.PIXEL_LIGHT, samples=direct_settings.camera_samples, specular=specular,
    )  # fmt: skip
    ambient = irradiance(
        field,
        surface.position,
        surface.normal,
        surface.to_viewer,
        surface.lit,
        layout,
        query_settings,
        surface.distance,
    )
    if contact_settings.pixels > 0:
        by = Illumination(
            tracer, lights, field.volumes[0], time, gather_settings, direct_settings, query_settings, layout
        )
        ambient += contact.near_light(by, surface, contact_settings.pixels, sampling.PIXEL_CONTACT)
    ambient = dr.select(surface.lit, ambient, mi.Color3f(0))
    background = environment_radiance(lights, -surface.to_viewer, ~surface.valid)
    return Shaded(
        direct=dr.select(surface.lit, brdf.lambert(surface) * arriving.irradiance + arriving.specular, 0),
        # Metals have no diffuse lobe; until reflections are traced, the field stands in for them.
        indirect=surface.albedo * ambient * dr.inv_pi,
        emission=surface.emission + background,
        irradiance=ambient,
    )
