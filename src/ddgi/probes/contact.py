"""Contact: light between surfaces nearer to each other than probes are to any of them.

The field stands for what probes see, a cell away: the groove between two slabs, the dark under a
table, are not in it. So one short ray leaves each point, as light leaves a matt surface. Where it
meets something near, the light of that replaces what the probes saw in the same direction; where it
does not, the field stands. SDF 3.5 has the idea, for what the picture shows and mixed by occlusion;
here it is everything around a point, and what is replaced is known, as probes keep a map of the
radiance itself (`volume.radiance_size`):

    E = E_field + pi * mean over cosine-distributed directions of near * (L_hit - L_probes)

Pixels look for it twice over: what is near them has near things of its own, which the field does not
know either. In the corner under a beam both faces are half as bright as the field says.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import drjit as dr
import mitsuba as mi
from annotated_types import Interval
from typing_extensions import Doc

from ddgi.extrema import at_most, clamp
from ddgi.probes.bounce import (
    Around,
    Illumination,
    around,
    arriving,
    from_field,
    from_lamps,
    known,
    reflected,
)
from ddgi.sampling import Clock, apart, kronecker_2d, uniform_2d
from ddgi.settings_group import settings_group
from ddgi.trace.surface import Surface, matt_bounce

MOST = 2.0
"""Times the field's light at a pixel's point that one ray takes away at most.

In front of a window that something near hides, few rays take away all and more: without a bound they leave
dark dots in pictures, with one of 1 half of what should go stays.
"""


@settings_group("contact")
class Settings:
    """How far light from nearby surfaces is traced, in spacings of the probes."""

    pixels: Annotated[
        float,
        Interval(ge=0, le=1000),
        Doc(
            "from pixels, one ray each a frame [spacings], where frames add up: single ones would show its grain; 0: not at all"
        ),
    ] = 0.6
    hits: Annotated[
        float,
        Interval(ge=0, le=1000),
        Doc(
            "from what the probes' rays hit, one ray each an update [spacings]; 0: not at all, as with full paths (gather.bounces)"
        ),
    ] = 0.8
    every: Annotated[
        int,
        Interval(ge=1, le=64),
        Doc("only one in so many hits has such a ray each time, and it counts so many times"),
    ] = 4


def in_turn(number: mi.UInt32, few: int, every: int, time: Clock) -> mi.UInt32:
    """The order of rays in which those whose turn it is come first, `few` spread over all of them.

    Args:
        number: (N,) places in the order.
        few: How many have their turn; `few * every` of the rays ever have.
        every: One in how many they are.
        time: Moves on to the next of the many.
    """
    spread = number % few * every + (time.tick + number // few) % every
    return dr.select(number < few * every, spread, number)


def near_light(
    by: Illumination, surface: Surface, there: Around, reach: float, stream: int, *, pixels: bool = False
) -> mi.Color3f:
    """What nearby surfaces add to the field's irradiance, a sample of it; it may be negative.

    Args:
        by: What lights what is found.
        surface: (N,) the points.
        there: The field around them.
        reach: Length of the rays, in the smallest spacing of the probes. What is met in its second
            half counts less and less, down to nothing at its end.
        stream: Of random numbers (`ddgi.sampling`).
        pixels: For a picture: what is met has what is near it too, and a ray takes away `MOST` times the field's
            light at most. In the field, where many samples are averaged, a bound would only be wrong.

    Returns:
        (N,) irradiance [W/m^2].
    """
    # Not of the sequence that lamps are sampled with: what is met and how it is lit would go together.
    sample = kronecker_2d(by.time, stream, dr.arange(mi.UInt32, dr.width(surface.distance)), by.time.tick)
    return _sampled(by, surface, there, reach, stream, sample, for_picture=pixels)


def _sampled(
    by: Illumination,
    surface: Surface,
    there: Around,
    reach: float,
    stream: int,
    sample: mi.Point2f,
    *,
    for_picture: bool = False,
) -> mi.Color3f:
    """`near_light` of one direction, chosen by uniform numbers. sample, result: (N,)."""
    length = by.vol.grid.smallest_spacing * reach
    origin, direction = matt_bounce(surface, sample)
    # A bumped normal sees the surface that it stands on.
    active = surface.lit & (dr.dot(mi.Vector3f(surface.geometric_normal), direction) > 0)
    near = by.tracer.intersect(origin, direction, active, time=by.time, stream=stream, reach=length)
    share = dr.select(near.valid, clamp(2 - 2 * near.distance / length, 0, 1), 0)

    def gained(near: Surface, there: Around, direction: mi.Vector3f, share: mi.Float) -> mi.Color3f:
        around_near = around(by, near)
        light = from_lamps(by, near, stream) + from_field(by, around_near)
        if for_picture:
            onward = replace(by, time=apart(by.time))
            numbers = uniform_2d(onward.time, stream, dr.arange(mi.UInt32, dr.width(share)))
            light += _sampled(onward, near, around_near, reach, stream, numbers)
        replaced = known(by, there, direction)
        if for_picture:
            replaced = at_most(replaced, MOST * from_field(by, there) * dr.inv_pi)
        return dr.pi * share * (arriving(by, near, direction) + reflected(near, light) - replaced)

    # A branch, as most points have nothing near them, nor have their neighbours.
    return dr.if_stmt((near, there, direction, share), share > 0, gained, lambda *_: mi.Color3f(0))
