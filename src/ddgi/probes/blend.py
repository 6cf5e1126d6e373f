"""Blend what the rays brought back into the probes' maps.

All probes share their directions, so the weighted mean of every texel of every probe is one
matrix product, texel weights times ray values; the rest is a blend with the old value.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated, Literal

import drjit as dr
import mitsuba as mi
from annotated_types import Ge, Interval
from typing_extensions import Doc

from ddgi import sampling
from ddgi.extrema import at_least, at_most
from ddgi.probes import formats, query, volume
from ddgi.probes.directions import picked
from ddgi.probes.gather import Gathered
from ddgi.probes.lamplit import LamplitPoints
from ddgi.probes.octahedral import bordered, interior, texel_direction
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
    ] = 12
    recency: Annotated[
        float,
        Interval(ge=1, le=16),
        Doc(
            "the n-th update of the running mean counts n^(recency - 1) times, as early ones lack bounces; 1: all alike"
        ),
    ] = 3.0
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
    """The volume after one update."""
    alpha = hysteresis(vol.age, s)
    return replace(
        vol,
        irradiance=_blend_irradiance(vol, found, points, alpha, time, layout, s, q),
        distance=_blend_distance(vol, found, alpha, time, layout, s),
        radiance=_blend_radiance(vol, found, points, alpha, time, layout) if layout.radiance_size else None,
        age=vol.age + 1,
    )


def hysteresis(age: mi.UInt32, s: Settings) -> mi.Float:
    """Share of the old value at the update number `age`, counted from zero. (1,)."""
    if s.warm_up == 0:
        return dr.select(age == 0, mi.Float(0), mi.Float(s.hysteresis))
    known = mi.Float(mi.Int32(age) - s.warm_up) + 1  # the last update of the warm-up is the mean's first
    return dr.select(known < 1, 0, at_most(known / (known + s.recency), mi.Float(s.hysteresis)))


def _blend_irradiance(vol, found, points, alpha, time, layout, s, q):
    size, fmt = layout.irradiance_size, formats.IRRADIANCE[layout.irradiance_format]
    weights = _weights(size, found.directions, 1)
    lane = dr.arange(mi.UInt32, vol.grid.size * (size + 2) ** 2)
    mean = _mean_radiance(vol, found, points, weights, 1, lane, vol.texel_fit if s.fit_texels else None)
    mean = at_least(mean, 0)  # fitted weights go a little below zero
    old = _old(fmt, vol.irradiance, size, lane)
    # Blend S^(1/gamma); the map holds S^k.
    k = query.lookup_exponent(q)
    mixed = dr.lerp(_power(mean, 1 / s.gamma), _power(old, 1 / (s.gamma * k)), alpha)
    return formats.pack(fmt, _power(mixed, s.gamma * k), _dither(fmt, 16, time, lane, 0))


def _blend_radiance(vol, found, points, alpha, time, layout):
    """Radiance as it arrives, in lobes as wide as a texel: a mean that nothing bends."""
    size, fmt = layout.radiance_size, formats.IRRADIANCE[layout.irradiance_format]
    # A lobe cos^n has 2 pi / (n + 1) of solid angle, a texel 4 pi / size^2.
    sharpness = max(1.0, size * size / 2 - 1)
    weights = _weights(size, found.directions, sharpness)
    lane = dr.arange(mi.UInt32, vol.grid.size * (size + 2) ** 2)
    mean = _mean_radiance(vol, found, points, weights, sharpness, lane)
    old = _old(fmt, vol.radiance, size, lane)
    seen = dr.gather(mi.Float, dr.sum(weights, axis=1).array, _source_texel(lane, size)[1]) > SMALLEST_WEIGHT
    mixed = dr.select(seen, dr.lerp(mean, old, alpha), old)
    mixed = at_least(mixed, 0)  # few samples of what is near may take away more than there is
    return formats.pack(fmt, mixed, _dither(fmt, 16, time, lane, 2))


def _mean_radiance(vol, found, points, weights, sharpness, lane, fit: TexelFit | None = None) -> mi.Color3f:
    """Weighted means of what rays and points brought, for the texels of the bordered maps. (P (size + 2)^2,)."""
    probes, texels = vol.grid.size, weights.shape[0]
    size = math.isqrt(texels)
    weight = at_least(dr.sum(weights, axis=1), SMALLEST_WEIGHT)
    shares = weights / weight[:, None]
    sums = _weighted_sums(fit.apply(shares) if fit else shares, dr.ravel(found.radiance), 3, probes)
    if points:
        # On top of the rays, so divided by what the rays' weights come to; on average, as the mean of one
        # over a sum that varies is more than one over its mean. That of cos^n over all directions is 1 / (2 n + 2).
        even = 2 * (sharpness + 1) / weights.shape[1]
        more = mi.TensorXf(points.weighted_sums(size, sharpness) * even, (3 * probes, texels))
        sums = sums + (fit.apply_to_maps(more) if fit else more).array
    probe, texel = _source_texel(lane, size)
    return mi.Color3f([dr.gather(mi.Float, sums, (probe * 3 + c) * texels + texel) for c in range(3)])


def _old(fmt: formats.Format, store, size: int, lane: mi.UInt32):
    """What bordered maps held before: their borders are read from where they came. (P (size + 2)^2,)."""
    probe, texel = _source_texel(lane, size)
    return formats.read(fmt, store, probe * (size + 2) ** 2 + bordered(texel, size), mi.Bool(True))


def _blend_distance(vol, found, alpha, time, layout, s):
    size, fmt = layout.distance_size, formats.DISTANCE[layout.distance_format]
    probes, texels = vol.grid.size, size * size
    weights = _weights(size, found.directions, s.sharpness)
    channels = _distance_channels(found.distance, s)
    sums = _weighted_sums(weights, dr.ravel(channels), len(channels), probes)

    lane = dr.arange(mi.UInt32, probes * (size + 2) ** 2)
    probe, texel = _source_texel(lane, size)
    column = [
        dr.gather(mi.Float, sums, (probe * len(channels) + c) * texels + texel) for c in range(len(channels))
    ]
    # Without a mask all rays count, so the weights' sum is the same for all probes.
    weight = column[2] if len(channels) == 3 else dr.gather(mi.Float, dr.sum(weights, axis=1).array, texel)
    new = mi.Vector2f(column[0], column[1]) / at_least(weight, 1e-12)
    old = _old(fmt, vol.distance, size, lane)
    # A texel that no ray came near keeps its old value; with none, nothing is near.
    nothing = dr.select(vol.age == 0, mi.Vector2f(1), old)
    moments = dr.select(weight > SMALLEST_WEIGHT, dr.lerp(new, old, alpha), nothing)
    return formats.pack(fmt, moments, _dither(fmt, 8, time, lane, 1))


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


def _source_texel(lane: mi.UInt32, size: int) -> tuple[mi.UInt32, mi.UInt32]:
    """Probe of a bordered texel, and the interior texel it shows."""
    area = (size + 2) ** 2
    probe = lane // area
    return probe, interior(lane - probe * area, size)


def _dither(fmt: formats.Format, exact_bytes: int, time: Clock, lane: mi.UInt32, which: int) -> mi.Float:
    if fmt.bytes == exact_bytes:
        return mi.Float(0)
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
