"""What probes see in metals and gloss: rays that meet them go on along their GGX lobe.

Taken as matt, a metal floor lights the walls around it evenly, and a lamp above it sends on no bright patch.
Each ray takes one of two ways, with chances as what the lobe and the matt part reflect: it stops, and the
surface counts with its matt part alone, or it goes on to what is seen in the lobe. What it brings is divided
by the chance, so the mean is right, and one look-up of the lamps and the field is enough for either way.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ddgi import sampling
from ddgi.extrema import at_least
from ddgi.lighting import brdf
from ddgi.lighting.direct import Share, direct_light
from ddgi.lighting.lights import DeltaLight
from ddgi.probes.bounce import Illumination, arriving, follows_lobes
from ddgi.trace.lobe import lobe_share, matt_rest, sharp
from ddgi.trace.surface import Surface, offset_origin


@dataclass
class Onward:
    """Where rays end that go on from gloss, or stop at once. (N,) each."""

    surface: Surface  # the last
    throughput: mi.Color3f  # share of what leaves it, taken as matt, that comes back along the ray
    radiance: mi.Color3f  # of lamps and surroundings seen in the lobe [W/(m^2 sr)]
    reflected: mi.Bool  # the ray has gone on

    def share(self, of_first: Share | None) -> Share | None:
        """How much of lamps' light counts where rays end, if of first hits it is `of_first`: light paths end there."""
        if of_first is None:
            return None

        def counted(row: DeltaLight, number: mi.UInt32, surface: Surface) -> mi.Float:
            return dr.select(self.reflected, 1, of_first(row, number, surface))

        return counted


def follow(by: Illumination, surface: Surface) -> Onward:
    """Let rays go on from gloss, where `gather.gloss` says so. surface: (N,) what they met first."""
    width = dr.width(surface.distance)
    nothing = dr.zeros(mi.Color3f, width)
    if not follows_lobes(by.tracer, by.gather):
        return Onward(surface, mi.Color3f(1), nothing, mi.Bool(False))
    chance = lobe_share(surface)
    choice = sampling.uniform_2d(by.time, sampling.PROBE_GLOSS_CHOICE, dr.arange(mi.UInt32, width)).x
    onward = choice < chance
    stops = Onward(surface, matt_rest(surface) / at_least(1 - chance, 1e-6), nothing, onward)
    # A branch, as in most rooms few rays meet gloss, and their neighbours with them.
    return dr.if_stmt(
        (surface, chance, stops),
        onward,
        lambda surface, chance, _: _reflected(by, surface, dr.rcp(chance)),
        lambda surface, chance, stops: stops,
    )


def _reflected(by: Illumination, surface: Surface, weight: mi.Float) -> Onward:
    """One ray of the lobe of each surface, and the lamps that a ray would hardly find. weight: (N,)."""
    lane = dr.arange(mi.UInt32, dr.width(surface.distance))
    direction, reflectance = brdf.sample_ggx(
        surface, sampling.uniform_2d(by.time, sampling.PROBE_GLOSS, lane)
    )
    outside = dr.dot(mi.Vector3f(surface.geometric_normal), direction) > 0
    throughput = dr.select(outside, reflectance * weight, mi.Color3f(0))
    seen = by.tracer.intersect(
        offset_origin(surface, direction), direction, outside, time=by.time, stream=sampling.PROBE_GLOSS_ALPHA
    )
    lamps = direct_light(
        by.tracer, by.lights, surface, by.direct,
        time=by.time, stream=sampling.PROBE_GLOSS, samples=by.direct.probe_samples, specular=True,
        apart=sharp(surface),
    )  # fmt: skip
    met = throughput * arriving(by, seen, direction, whole=sharp(surface))
    return Onward(seen, throughput, weight * lamps.specular + met, mi.Bool(True))
