"""Trace and shade the probes' rays: the radiance and the distance each one brings back.

What a ray hits is lit by the lights and by last frame's field, so light bounces once more with
every frame, without end. MFF traces whole paths instead and feeds nothing back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi

from ddgi import sampling
from ddgi.lighting.guard import finite
from ddgi.probes import contact, glossy
from ddgi.probes.bounce import Around, Illumination, around, arriving, from_field, from_lamps, reflected
from ddgi.probes.directions import picked
from ddgi.probes.rays import ProbeRays
from ddgi.trace.surface import Surface, matt_bounce


@dataclass
class Gathered:
    """What R rays of each of A probes brought back, in the lane order of `ProbeRays`."""

    directions: mi.Vector3f  # (R,)
    radiance: mi.Color3f  # (R A,) finite
    distance: mi.Float  # (R A,) in reach units; infinite where nothing was hit
    non_finite: mi.UInt32  # (1,) rays whose radiance was not a number, counted as black


def gather(by: Illumination, rays: ProbeRays, s: contact.Settings) -> Gathered:
    """Trace this frame's rays and shade what they hit with the lights and last frame's field.

    The few that look for light from nearby surfaces too (`contact.every`) are traced apart: in one
    kernel, all would wait for them.
    """
    if s.hits == 0 or by.gather.bounces == "path":
        radiance, distance, bad = _brought_back(by, rays.origin, rays.direction)
        dr.eval(radiance, distance, bad)  # one kernel: each later use alone would trace the rays again
        return Gathered(rays.directions, radiance, distance, bad)
    every, probes, bad = min(s.every, rays.count), by.vol.awake.count, mi.UInt32(0)
    few = rays.count // every
    radiance, distance = dr.empty(mi.Color3f, rays.count * probes), dr.empty(mi.Float, rays.count * probes)
    for first, last, near in ((0, few, s.hits), (few, rays.count, 0.0)):
        if first == last:
            continue
        lane = dr.arange(mi.UInt32, first * probes, last * probes)
        turn = lane // probes
        ray, place = contact.in_turn(turn, few, every, by.time), lane - turn * probes
        # Lanes are counted from zero in both, and random numbers by lanes.
        lit = replace(by, time=sampling.apart(by.time)) if near else by
        origin, direction = by.vol.grid.position(by.vol.awake.probe(place)), picked(rays.directions, ray)
        light, length, wrong = _brought_back(lit, origin, direction, near, rays.count / few)
        dr.scatter(radiance, light, ray * probes + place, mode=dr.ReduceMode.Permute)
        dr.scatter(distance, length, ray * probes + place, mode=dr.ReduceMode.Permute)
        dr.eval(radiance, distance, wrong)
        bad += wrong
    return Gathered(rays.directions, radiance, distance, bad)


def _brought_back(
    by: Illumination, origin: mi.Point3f, direction: mi.Vector3f, near: float = 0, weight: float = 1
) -> tuple[mi.Color3f, mi.Float, mi.UInt32]:
    """Radiance and distance of rays, and how many were no numbers.

    Args:
        by: What lights what they hit.
        origin: (N,) where they start [m].
        direction: (N,) unit.
        near: How far around the ends of their paths light of nearby surfaces is looked for [spacings].
        weight: How many rays each of them stands for in that.
    """
    surface = by.tracer.intersect(
        origin, direction, mi.Bool(True), time=by.time, stream=sampling.PROBE_ALPHA, coherent=True
    )
    path = _along_path(by, surface)
    radiance = arriving(by, surface, direction) + path.radiance
    if near > 0 and path.there is not None:
        light = contact.near_light(by, path.end, path.there, near, sampling.PROBE_CONTACT)
        radiance += weight * path.throughput * reflected(path.end, light)
    radiance, bad = finite(radiance)
    distance = surface.distance * dr.rcp(by.vol.reach(by.layout))
    distance = dr.select(surface.back, distance * by.gather.back_face_distance, distance)
    return radiance, distance, bad


@dataclass
class _Path:
    """What paths from first hits carry back."""

    radiance: mi.Color3f  # (N,) of the lamps, and of the field at the end
    throughput: mi.Color3f  # (N,) share of what leaves the last surface that arrives at the first
    end: Surface  # (N,) the last surface
    there: Around | None  # the field around it; None: paths have no use for it


def _along_path(by: Illumination, surface: Surface) -> _Path:
    """Radiance that first hits reflect, by a path of `path_length` surfaces and, at its end, the field.

    What is seen in gloss and metals comes on top of them.

    Light paths (`lamplit`) bring some of the lamps' light on first hits, and none of what is beyond.
    """
    on = glossy.follow(by, surface)
    share = on.share(by.sharing.of_rays if by.sharing else None)
    radiance, throughput, surface = on.radiance, on.throughput, on.surface
    width, last = dr.width(surface.distance), by.gather.path_length
    lane = dr.arange(mi.UInt32, width)
    for length in range(1, last):
        radiance += throughput * reflected(surface, from_lamps(by, surface, sampling.PROBE_LIGHT, share))
        throughput = dr.select(surface.lit, throughput * surface.albedo, mi.Color3f(0))
        sample = sampling.uniform_2d(by.time, sampling.PROBE_PATH, lane * last + (length - 1))
        # The cosine and the 1/pi of Lambert cancel against the density of the directions.
        origin, direction = matt_bounce(surface, sample)
        surface = by.tracer.intersect(
            origin, direction, surface.lit, time=by.time, stream=sampling.PROBE_ALPHA
        )
        radiance += throughput * arriving(by, surface, direction)
        share = None
    irradiance = from_lamps(by, surface, sampling.PROBE_LIGHT, share)
    there = around(by, surface) if by.gather.bounces == "field" else None
    if there is not None:
        irradiance += from_field(by, there)
    return _Path(radiance + throughput * reflected(surface, irradiance), throughput, surface, there)
