"""Blend what the rays brought back into the probes' maps.

All probes share their directions, so the weighted mean of every texel of every probe is one
matrix product, texel weights times ray values; the rest is a blend with the old value.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import drjit as dr
import mitsuba as mi
import numpy as np
from annotated_types import Ge, Interval
from typing_extensions import Doc

from ddgi import sampling
from ddgi.extrema import at_least, at_most, largest
from ddgi.luminance import LUMINANCE
from ddgi.probes import formats, query, volume
from ddgi.probes.awake import SLEEPING
from ddgi.probes.change import LOBES, Change
from ddgi.probes.directions import picked
from ddgi.probes.gather import Gathered
from ddgi.probes.lamplit import LamplitPoints
from ddgi.probes.octahedral import bordered, direction_to_square, interior, texel_direction
from ddgi.probes.texel_fit import TexelFit
from ddgi.probes.volume import ProbeVolume
from ddgi.sampling import Clock, uniform_2d
from ddgi.settings_group import settings_group


@settings_group("blend")
class Settings:
    """How new light replaces old."""

    hysteresis: Annotated[
        float,
        Interval(ge=0, le=0.9999),
        Doc("share of the old value that stays at each update (SCALE eq. 1)"),
    ] = 0.97
    warm_up: Annotated[
        int,
        Ge(0),
        Doc(
            "first updates that keep nothing old, one bounce each; then a running mean until hysteresis is reached; 0: hysteresis from the second update on"
        ),
    ] = 16
    recency: Annotated[
        float,
        Interval(ge=1, le=16),
        Doc(
            "the n-th update of the running mean counts n^(recency - 1) times, as early ones lack bounces; 1: all alike"
        ),
    ] = 3.0
    growth: Annotated[
        int,
        Interval(ge=0, le=10_000),
        Doc(
            "updates in which hysteresis rises from 0 to its value, as their logarithm (CTU 6.1); 0: as a running mean's, or at once"
        ),
    ] = 0
    watch: Annotated[
        bool,
        Doc(
            "probes whose light lies off what they hold, beyond its scatter and three times running, warm up again"
        ),
    ] = False
    watch_deviations: Annotated[
        float, Interval(ge=0, le=100), Doc("of its scatter, beyond which light counts as changed")
    ] = 4.0
    thresholds: Annotated[
        bool,
        Doc(
            "irradiance texels whose light changes much forget faster: small_change, large_change (SCALE 4.3)"
        ),
    ] = False
    small_change: Annotated[
        float,
        Interval(ge=0, le=1),
        Doc("change of a texel, over the larger of old and new, above which its hysteresis falls by 0.15"),
    ] = 0.25
    large_change: Annotated[float, Interval(ge=0, le=1), Doc("likewise, above which nothing old is kept")] = (
        0.8
    )
    gamma: Annotated[
        float,
        Interval(ge=1, le=16),
        Doc(
            "irradiance is blended as S^(1/gamma) (SCALE 4.2); 5 follows falling light faster, 1 measures best: above it noise darkens the mean"
        ),
    ] = 1.0
    sharpness: Annotated[
        float, Interval(ge=1, le=500), Doc("power of the cosine that weights distances (CTU eq. 4.14)")
    ] = 50.0
    fit_texels: Annotated[
        bool,
        Doc(
            "irradiance texels are fitted to bilinear interpolation, which else lowers peaks (`probes/texel_fit.py`)"
        ),
    ] = True
    long_distances: Annotated[
        Literal["clamp", "reject", "off"],
        Doc("distances beyond volume.longest_distance: shortened to it, left out (MFF 3.3.2), or kept"),
    ] = "clamp"


def blend(
    vol: ProbeVolume,
    found: Gathered,
    points: LamplitPoints | None,
    time: Clock,
    layout: volume.Settings,
    s: Settings,
    q: query.Settings,
) -> ProbeVolume:
    """The volume after one update of the probes that are awake; the others keep what they have."""
    irradiance, change, light_age = _blend_irradiance(vol, found, points, time, layout, s, q)
    maps = {
        "irradiance": irradiance,
        "distance": _blend_distance(vol, found, time, layout, s),
    }
    if layout.radiance_size:
        maps["radiance"] = _blend_radiance(vol, found, points, light_age, time, layout, s)
    states = vol.states.updated() if vol.states is not None else None
    age, haste = _older(vol, s), vol.haste.passing()
    return replace(vol, **maps, age=age, states=states, haste=haste, change=change)


def _older(vol: ProbeVolume, s: Settings) -> mi.UInt32:
    """Ages after an update. (P,). With `growth`, sleepers that were updated get younger: their hysteresis falls again (CTU 6.1)."""
    if vol.awake.numbers is None and vol.states is None:
        return vol.age + 1
    probe = vol.awake.probe(dr.arange(mi.UInt32, vol.awake.count))
    age = dr.gather(mi.UInt32, vol.age, probe)
    after = age + 1
    if vol.states is not None and s.growth:
        asleep = dr.gather(mi.UInt32, vol.states.code, probe) <= SLEEPING
        after = dr.select(asleep, dr.select(age > 1, age, 2) - 1, after)
    ages = mi.UInt32(vol.age)
    dr.scatter(ages, after, probe, mode=dr.ReduceMode.Permute)
    return ages


def hysteresis(age: mi.UInt32, s: Settings) -> mi.Float:
    """Share of the old value at the update number `age` of a probe, counted from zero. (N,)."""
    known = mi.Float(mi.Int32(age) - s.warm_up) + 1  # the last update of the warm-up is the mean's first
    if s.growth:
        share = dr.log(at_least(known, 1)) * (s.hysteresis / math.log(1 + s.growth))
        return at_most(share, mi.Float(s.hysteresis))
    if s.warm_up == 0:
        return dr.select(age == 0, mi.Float(0), mi.Float(s.hysteresis))
    return dr.select(known < 1, 0, at_most(known / (known + s.recency), mi.Float(s.hysteresis)))


@dataclass
class _Texels:
    """The texels of the bordered maps of A probes that are awake, lane by lane. (A (size + 2)^2,) each."""

    place: mi.UInt32  # of the probe in the list of those awake
    source: mi.UInt32  # the interior texel that a texel shows
    old: mi.UInt32  # where its value lay before, of all P probes: borders are read from where they come
    new: mi.UInt32 | None  # where it goes; None: there are no others
    age: mi.UInt32  # of the probe

    @staticmethod
    def of(vol: ProbeVolume, size: int, age: mi.UInt32 | None = None) -> _Texels:
        """Those of maps with size^2 interior texels. age: (A,) of the awake probes, if it is not that of all their maps."""
        area = (size + 2) ** 2
        lane = dr.arange(mi.UInt32, vol.awake.count * area)
        place = lane // area
        within = lane - place * area
        probe, source = vol.awake.probe(place), interior(within, size)
        new = None if vol.awake.numbers is None else probe * area + within
        own = dr.gather(mi.UInt32, vol.age, probe) if age is None else dr.gather(mi.UInt32, age, place)
        return _Texels(place, source, probe * area + bordered(source, size), new, own)

    def before(self, fmt: formats.Format, store):
        """What they held before the update."""
        return formats.read(fmt, store, self.old, mi.Bool(True))

    def stored(self, fmt: formats.Format, store, value, dither: mi.Float):
        """The maps of all probes with the texels' new values."""
        if self.new is None:
            return formats.pack(fmt, value, dither)
        kept = type(store)(store)
        dr.scatter(kept, fmt.encode(value, dither), self.new, mode=dr.ReduceMode.Permute)
        return kept


def _blend_irradiance(vol, found, points, time, layout, s, q):
    """The map; what is known of how light scatters, and the age of each awake probe's light if that has one of its own."""
    size, fmt = layout.irradiance_size, formats.IRRADIANCE[layout.irradiance_format]
    weights = _weights(size, found.directions, 1)
    sums = _mean_radiance(vol, found, points, weights, 1, vol.texel_fit if s.fit_texels else None)
    change, light_age = _watched(vol, sums, layout, s) if s.watch else (vol.change, None)
    texels = _Texels.of(vol, size, light_age)
    mean = at_least(
        _picked(sums, texels.place, texels.source, size), 0
    )  # fitted weights go a little below zero
    old = texels.before(fmt, vol.irradiance)
    # Blend S^(1/gamma); the map holds S^k.
    k = query.lookup_exponent(q)
    alpha = vol.haste.light_kept(hysteresis(texels.age, s))
    new, before = _power(mean, 1 / s.gamma), _power(old, 1 / (s.gamma * k))
    if s.thresholds:
        alpha = _where_little_changes(alpha, new, before, s)
    mixed = dr.lerp(new, before, alpha)
    value = _power(mixed, s.gamma * k)
    stored = texels.stored(fmt, vol.irradiance, value, _dither(fmt, 16, time, texels, 0))
    return stored, change, light_age


def _watched(vol, sums, layout, s) -> tuple[Change, mi.UInt32]:
    """What is known of how light scatters after this update, and the age of each awake probe's light. (A,)."""
    size = layout.irradiance_size
    place = dr.arange(mi.UInt32, vol.awake.count)
    light = []
    for lobe in LOBES:
        square = np.ravel(direction_to_square(mi.Vector3f(*lobe)))
        x, y = (min(int((u + 1) / 2 * size), size - 1) for u in square)
        light.append(_luminance(at_least(_picked(sums, place, mi.UInt32(y * size + x), size), 0)))
    return vol.change.after(vol.awake.probe(place), light, s.warm_up, s.watch_deviations)


def _luminance(light: mi.Color3f) -> mi.Float:
    return sum(float(w) * c for w, c in zip(LUMINANCE, light, strict=True))


def _where_little_changes(alpha: mi.Float, new: mi.Color3f, old: mi.Color3f, s: Settings) -> mi.Float:
    """Hysteresis of texels, lower where their light changes much (SCALE 4.3).

    Listing 3 takes the largest component of new - old, which overlooks light that falls, and compares it with fixed
    numbers; the text has shares "of maximum value". So: the largest absolute component, over the largest of both.
    """
    change = largest(dr.abs(new - old)) / at_least(dr.maximum(largest(new), largest(old)), 1e-12)
    alpha = dr.select(change > s.small_change, at_least(alpha - LOWERED, 0), alpha)
    return dr.select(change > s.large_change, 0, alpha)


LOWERED = 0.15
"""By how much hysteresis falls at a small change (SCALE 4.3)."""


def _blend_radiance(vol, found, points, light_age, time, layout, s):
    """Radiance as it arrives, in lobes as wide as a texel: a mean that nothing bends."""
    size, fmt = layout.radiance_size, formats.IRRADIANCE[layout.irradiance_format]
    # A lobe cos^n has 2 pi / (n + 1) of solid angle, a texel 4 pi / size^2.
    sharpness = max(1.0, size * size / 2 - 1)
    weights = _weights(size, found.directions, sharpness)
    texels = _Texels.of(vol, size, light_age)
    sums = _mean_radiance(vol, found, points, weights, sharpness)
    mean = _picked(sums, texels.place, texels.source, size)
    old = texels.before(fmt, vol.radiance)
    seen = dr.gather(mi.Float, dr.sum(weights, axis=1).array, texels.source) > SMALLEST_WEIGHT
    alpha = vol.haste.light_kept(hysteresis(texels.age, s))
    mixed = dr.select(seen, dr.lerp(mean, old, alpha), old)
    mixed = at_least(mixed, 0)  # few samples of what is near may take away more than there is
    return texels.stored(fmt, vol.radiance, mixed, _dither(fmt, 16, time, texels, 2))


def _mean_radiance(vol, found, points, weights, sharpness, fit: TexelFit | None = None) -> mi.Float:
    """Weighted means of what rays and points brought, texel by texel of each awake probe. Flat, (A, 3, texels)."""
    probes, count = vol.awake.count, weights.shape[0]
    size = math.isqrt(count)
    weight = at_least(dr.sum(weights, axis=1), SMALLEST_WEIGHT)
    shares = weights / weight[:, None]
    sums = _weighted_sums(fit.apply(shares) if fit else shares, dr.ravel(found.radiance), 3, probes)
    if points:
        # On top of the rays, so divided by what the rays' weights come to; on average, as the mean of one
        # over a sum that varies is more than one over its mean. That of cos^n over all directions is 1 / (2 n + 2).
        even = 2 * (sharpness + 1) / weights.shape[1]
        more = mi.TensorXf(points.weighted_sums(size, sharpness) * even, (3 * probes, count))
        sums = sums + (fit.apply_to_maps(more) if fit else more).array
    return sums


def _picked(sums: mi.Float, place: mi.UInt32, texel: mi.UInt32, size: int) -> mi.Color3f:
    """Means of texels of a map with size^2, of awake probes by their place in the list. (N,)."""
    return mi.Color3f([dr.gather(mi.Float, sums, (place * 3 + c) * size * size + texel) for c in range(3)])


def _blend_distance(vol, found, time, layout, s):
    size, fmt = layout.distance_size, formats.DISTANCE[layout.distance_format]
    weights = _weights(size, found.directions, s.sharpness)
    channels = _distance_channels(found.distance, s)
    many = len(channels)
    sums = _weighted_sums(weights, dr.ravel(channels), many, vol.awake.count)
    texels = _Texels.of(vol, size)
    first = texels.place * (many * size * size) + texels.source
    column = [dr.gather(mi.Float, sums, first + c * size * size) for c in range(many)]
    # Without a mask all rays count, so the weights' sum is the same for all probes.
    weight = column[2] if many == 3 else dr.gather(mi.Float, dr.sum(weights, axis=1).array, texels.source)
    new = mi.Vector2f(column[0], column[1]) / at_least(weight, 1e-12)
    old = texels.before(fmt, vol.distance)
    # A texel that no ray came near keeps its old value; with none, nothing is near.
    nothing = dr.select(texels.age == 0, mi.Vector2f(1), old)
    alpha = vol.haste.distance_kept(hysteresis(texels.age, s))
    moments = dr.select(weight > SMALLEST_WEIGHT, dr.lerp(new, old, alpha), nothing)
    return texels.stored(fmt, vol.distance, moments, _dither(fmt, 8, time, texels, 1))


SMALLEST_WEIGHT = 1e-7
"""Sum of weights below which a distance texel saw no ray."""


def _distance_channels(distance: mi.Float, s: Settings):
    """Mean, mean square and, where samples may be left out, a mask: the columns to average."""
    if s.long_distances == "clamp":
        t = at_most(distance, 1)
        return mi.Vector2f(t, t * t)
    if s.long_distances == "off":
        # A miss has no distance; it counts as just beyond what matters (CTU 6.1).
        t = dr.select(dr.isfinite(distance), distance, 1)
        return mi.Vector2f(t, t * t)
    near = distance <= 1
    t = dr.select(near, distance, 0)
    return mi.Vector3f(t, t * t, dr.select(near, mi.Float(1), mi.Float(0)))


def _weights(size: int, directions: mi.Vector3f, sharpness: float) -> mi.TensorXf:
    """max(0, cos)^sharpness between every texel and every ray. (texels, R)."""
    texels, rays = size * size, dr.width(directions)
    lane = dr.arange(mi.UInt32, texels * rays)
    texel = lane // rays
    direction = picked(directions, lane - texel * rays)
    cosine = dr.dot(texel_direction(texel, size), direction)
    cosine = at_least(cosine, 0)
    if sharpness != 1:
        cosine = dr.select(cosine > 0, dr.power(cosine, sharpness), 0)
    return mi.TensorXf(cosine, (texels, rays))


def _weighted_sums(weights: mi.TensorXf, values: mi.Float, channels: int, probes: int) -> mi.Float:
    """Sum of weight times value over the rays. values: (R P channels); result: flat (P channels, texels)."""
    rays = weights.shape[1]
    table = mi.TensorXf(values, (rays, probes * channels))
    return dr.matmul(table, weights, At=True, Bt=True).array


def _dither(fmt: formats.Format, exact_bytes: int, time: Clock, texels: _Texels, which: int) -> mi.Float:
    if fmt.bytes == exact_bytes:
        return mi.Float(0)
    lane = dr.arange(mi.UInt32, dr.width(texels.place))
    return uniform_2d(time, sampling.ROUNDING, lane * 3 + which).x


def _power(x, exponent: float):
    """x^exponent for x >= 0, without a general power where a root or a square will do."""
    match exponent:
        case 1:
            return x
        case 2:
            return dr.square(x)
        case 0.5:
            return dr.sqrt(x)
        case 2.5:
            return dr.square(x) * dr.sqrt(x)
    return dr.select(x > 0, dr.power(x, exponent), 0)
