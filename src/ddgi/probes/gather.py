"""Trace and shade the probes' rays: the radiance and the distance each one brings back.

What a ray hits is lit by the lights and by last frame's field, so light bounces once more with
every frame, without end. MFF traces whole paths instead and feeds nothing back.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ddgi import sampling
from ddgi.lighting.guard import finite
from ddgi.probes import contact
from ddgi.probes.bounce import Illumination, arriving, from_field, from_lamps, reflected
from ddgi.probes.rays import ProbeRays
from ddgi.trace.surface import Surface, matt_bounce


@dataclass
class Gathered:
    """What R P rays brought back, in the lane order of `ProbeRays`."""

    directions: mi.Vector3f  # (R,)
    radiance: mi.Color3f  # (R P,) finite
    distance: mi.Float  # (R P,) in reach units; infinite where nothing was hit
    non_finite: mi.UInt32  # (1,) rays whose radiance was not a number, counted as black


def gather(by: Illumination, rays: ProbeRays, s: contact.Settings) -> Gathered:
    """Trace this frame's rays and shade what they hit with the lights and last frame's field."""
    surface = _first_hits(by, rays.origin, rays.direction)
    radiance, bad = finite(arriving(by, surface, rays.direction) + _along_path(by, surface).radiance)
    distance = surface.distance * dr.rcp(by.vol.reach(by.layout))
    distance = dr.select(surface.back, distance * by.gather.back_face_distance, distance)
    dr.eval(radiance, distance, bad)  # one kernel: each later use alone would trace the rays again
    if s.hits > 0 and by.gather.bounces == "field":
        bad = bad + _add_near(radiance, by, rays, s)
    return Gathered(rays.directions, radiance, distance, bad)


def _first_hits(by: Illumination, origin: mi.Point3f, direction: mi.Vector3f) -> Surface:
    return by.tracer.intersect(
        origin, direction, mi.Bool(True), time=by.time, stream=sampling.PROBE_ALPHA, coherent=True
    )


@dataclass
class _Path:
    """What paths from first hits carry back."""

    radiance: mi.Color3f  # (N,) of the lamps, and of the field at the end
    throughput: mi.Color3f  # (N,) share of what leaves the last surface that arrives at the first
    end: Surface  # (N,) the last surface


def _along_path(by: Illumination, surface: Surface) -> _Path:
    """Radiance that first hits reflect, by a path of `path_length` surfaces and, at its end, the field."""
    width, last = dr.width(surface.distance), by.gather.path_length
    lane = dr.arange(mi.UInt32, width)
    radiance, throughput = dr.zeros(mi.Color3f, width), mi.Color3f(1)
    for length in range(1, last):
        radiance += throughput * reflected(surface, from_lamps(by, surface, sampling.PROBE_LIGHT))
        throughput = dr.select(surface.lit, throughput * surface.albedo, mi.Color3f(0))
        sample = sampling.uniform_2d(by.time, sampling.PROBE_PATH, lane * last + (length - 1))
        # The cosine and the 1/pi of Lambert cancel against the density of the directions.
        origin, direction = matt_bounce(surface, sample)
        surface = by.tracer.intersect(
            origin, direction, surface.lit, time=by.time, stream=sampling.PROBE_ALPHA
        )
        radiance += throughput * arriving(by, surface, direction)
    irradiance = from_lamps(by, surface, sampling.PROBE_LIGHT)
    if by.gather.bounces == "field":
        irradiance += from_field(by, surface)
    return _Path(radiance + throughput * reflected(surface, irradiance), throughput, surface)


def _add_near(radiance: mi.Color3f, by: Illumination, rays: ProbeRays, s: contact.Settings) -> mi.UInt32:
    """Add to what rays brought back the light of what is near the ends of their paths, in one ray of `every`.

    Those few are traced again: cheaper than to keep all that was found. Returns how many were no numbers.
    """
    probes = by.vol.grid.size
    few = max(1, rays.count // s.every)
    lane = dr.arange(mi.UInt32, few * probes)
    row = lane // probes
    ray, probe = contact.thinned(row, s.every, by.time), lane - row * probes
    direction = dr.gather(mi.Vector3f, dr.ravel(rays.directions), ray)
    path = _along_path(by, _first_hits(by, by.vol.grid.position(probe), direction))
    light = contact.near_light(by, path.end, s.hits, sampling.PROBE_CONTACT)
    value, bad = finite(path.throughput * reflected(path.end, light) * (rays.count / few))
    dr.scatter_add(radiance, value, ray * probes + probe)
    return bad
