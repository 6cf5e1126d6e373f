"""What probes see of the surfaces that lamps light: points where light paths landed, beside their own rays.

A point is entered like a ray of the probe that looks its way, with as much radiance as makes the sum over
rays and points right. Eight neighbours, between which the field interpolates, see eight different sets of
points (as in interleaved sampling; Keller and Heidrich 2001), and every probe all sets in turn.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi

from ddgi.extrema import at_least
from ddgi.lighting import light_paths
from ddgi.lighting.guard import finite
from ddgi.lighting.lamp_cells import Disc
from ddgi.lighting.light_paths import Aim, Landed
from ddgi.lighting.lights import DeltaLight, Lights
from ddgi.probes.awake import Awake
from ddgi.probes.grid import ProbeGrid
from ddgi.probes.octahedral import texel_direction
from ddgi.sampling import Clock
from ddgi.trace.lobe import matt_rest
from ddgi.trace.surface import Surface
from ddgi.trace.tracer import Tracer

SETS = 8


@dataclass
class LampPaths:
    """This update's light paths."""

    aim: Aim
    landed: Landed


@dataclass
class LamplitPoints:
    """S points as each of A probes that are awake sees them; number = place in the list of those * S + point."""

    count: int  # S
    direction: mi.Float  # (4 A S,) x y z, unit, from the probe; unused
    radiance: mi.Float  # (4 A S,) r g b, as of a ray; unused
    non_finite: mi.UInt32  # (1,) values that were not numbers, counted as black

    def weighted_sums(self, size: int, sharpness: float) -> mi.Float:
        """Sums of max(0, cos)^sharpness times radiance, for every texel. Flat (A, 3, size^2)."""
        texels = size * size
        probes = dr.width(self.direction) // (4 * self.count)
        lane = dr.arange(mi.UInt32, probes * texels)
        probe = lane // texels
        texel = lane - probe * texels
        axis = texel_direction(texel, size)

        def add(point: mi.UInt32, total: mi.Color3f) -> tuple[mi.UInt32, mi.Color3f]:
            number = probe * self.count + point
            cosine = at_least(dr.dot(axis, dr.gather(mi.Vector4f, self.direction, number).xyz), 0)
            if sharpness != 1:
                cosine = dr.select(cosine > 0, dr.power(cosine, sharpness), 0)
            radiance = mi.Color3f(dr.gather(mi.Vector4f, self.radiance, number).xyz)
            return point + 1, dr.fma(radiance, cosine, total)

        start = (mi.UInt32(0), dr.zeros(mi.Color3f, probes * texels))
        _, total = dr.while_loop(start, lambda point, _: point < self.count, add, label="points lit by lamps")
        sums = dr.empty(mi.Float, probes * 3 * texels)
        for channel in range(3):
            place = (probe * 3 + channel) * texels + texel
            dr.scatter(sums, total[channel], place, mode=dr.ReduceMode.Permute)
        return sums


@dataclass
class Sharing:
    """How the light of lamps is shared between the rays of a probe and the paths it sees land."""

    aim: Aim
    rays: int

    def of_rays(self, row: DeltaLight, number: mi.UInt32, surface: Surface) -> mi.Float:
        """The rays' share of a lamp's light on what they hit, in (0, 1]. (N,).

        Args:
            row: The lamp.
            number: Of the lamp.
            surface: (N,) hit by rays of probes.
        """
        toward = dr.dot(mi.Vector3f(surface.geometric_normal), surface.to_viewer)
        rays = ray_density(toward, surface.distance, self.rays)
        paths = light_paths.density(row, number, surface, self.aim) * (1 / SETS)
        return dr.select(paths > 0, rays / (rays + paths), 1)


def ray_density(toward: mi.Float, distance: mi.Float, rays: int) -> mi.Float:
    """Rays of a probe that meet a surface per area [1/m^2]. (N,).

    Args:
        toward: (N,) cosine between the surface's normal and the way to the probe.
        distance: (N,) to the probe [m].
        rays: That the probe has, in all directions.
    """
    return at_least(toward, 0) * (rays / (4 * dr.pi)) / at_least(dr.square(distance), 1e-12)


def send(
    tracer: Tracer, lights: Lights, grid: ProbeGrid, count: int, matt_alone: bool, time: Clock
) -> LampPaths | None:
    """This update's light paths; None without lamps that they could come from.

    Args:
        tracer: Says where they land.
        lights: Where they come from.
        grid: The probes.
        count: For every probe.
        matt_alone: What lobes reflect is left to the rays (`probes/glossy.py`).
        time: Random source.
    """
    if count == 0 or lights.delta.count == 0:
        return None
    low, high = grid.place(mi.UInt32(0)), grid.place(mi.UInt32(grid.size - 1))
    around = Disc((low + high) / 2, 0.5 * dr.norm(high - low))
    aim = light_paths.aim(tracer, lights, around, count * SETS, time)
    landed = light_paths.land(tracer, lights, aim, time)
    if matt_alone:
        landed = replace(landed, intensity=landed.intensity * matt_rest(landed.surface))
        dr.eval(landed)
    return LampPaths(aim, landed)


def seen(
    tracer: Tracer, grid: ProbeGrid, awake: Awake, paths: LampPaths, rays: int, time: Clock
) -> LamplitPoints:
    """The points where paths landed, as each probe sees those of its set.

    Args:
        tracer: Says whether it sees them.
        grid: Where the probes stand.
        awake: Those that are asked about.
        paths: `SETS` times as many as a probe sees.
        rays: That each probe has beside.
        time: Moves on to the next set.
    """
    count = paths.aim.count // SETS
    lane = dr.arange(mi.UInt32, awake.count * count)
    place = lane // count
    probe = awake.probe(place)
    x, y, z = grid.coordinates(probe)
    chosen = ((x & 1) + 2 * (y & 1) + 4 * (z & 1) + time.tick) % SETS
    landed = dr.gather(Landed, paths.landed, chosen * count + lane - place * count)
    surface, density = landed.surface, landed.density * (1 / SETS)

    to_probe = grid.position(probe) - surface.position
    distance = dr.norm(to_probe)
    direction = to_probe / at_least(distance, 1e-9)
    normal = mi.Vector3f(surface.geometric_normal)
    toward = dr.dot(normal, direction)
    start = dr.fma(normal, surface.slack, surface.position)
    visible = tracer.visible(start, direction, distance * (1 - 1e-3), (toward > 0) & (density > 0))
    by_rays = ray_density(toward, distance, rays)
    weight = density / at_least(density + by_rays, 1e-30)
    radiance, bad = finite(landed.intensity * (visible * by_rays * weight * SETS))
    out = LamplitPoints(
        count,
        dr.ravel(mi.Vector4f(-direction.x, -direction.y, -direction.z, 0)),
        dr.ravel(mi.Vector4f(radiance.x, radiance.y, radiance.z, 0)),
        bad,
    )
    dr.eval(out)
    return out
