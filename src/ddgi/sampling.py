"""Random numbers as a pure function of (seed, tick, stream, index): nothing to store or advance.

The same seed and tick give the same numbers on every run, and streams never share any, so a
picture is reproducible and two uses of randomness stay independent.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

# One stream per use of randomness.
(
    ROTATION,
    PROBE_LIGHT,
    PROBE_ALPHA,
    PROBE_TAP,
    PROBE_PATH,
    PIXEL,
    PIXEL_LIGHT,
    PIXEL_ALPHA,
    ROUNDING,
    WALLS,
    REGION,
    PIXEL_CONTACT,
    PROBE_CONTACT,
    SURVEY,
    SURVEY_ALPHA,
    VIEWPOINT,
    LAMP_PATH,
    LAMP_TRIAL,
    LAMP_TRIAL_ONWARD,
    PIXEL_GLOSS,
    PIXEL_GLOSS_ALPHA,
    PLACEMENT,
    PROBE_GLOSS,
    PROBE_GLOSS_CHOICE,
    PROBE_GLOSS_ALPHA,
) = range(25)
_STREAMS = 64
_GOLDEN = 0x9E3779B9  # 2^32 divided by the golden ratio
_PLASTIC = (0xC13FA9A9, 0x91E10DA5)  # and by the plastic number p, and by its square


@dataclass
class Clock:
    """Which frame of which run: the only source of randomness in a frame."""

    seed: mi.UInt32  # (1,)
    tick: mi.UInt32  # (1,)


def clock(seed: int, tick: int) -> Clock:
    """Clock of one frame; opaque, so that advancing it never compiles anything anew."""
    return Clock(dr.opaque(mi.UInt32, seed & 0xFFFFFFFF), dr.opaque(mi.UInt32, tick & 0xFFFFFFFF))


def apart(time: Clock) -> Clock:
    """The same frame, with random numbers that nothing else in it has."""
    return Clock(time.seed ^ 0x80000000, time.tick)


def uniform_2d(time: Clock, stream: int, index: mi.UInt32) -> mi.Point2f:
    """Two uniform numbers in [0, 1) for each index. index: (N,); result: (N,)."""
    a, b = _hash(time.seed, time.tick * _STREAMS + stream, index)
    return mi.Point2f(_fraction(a), _fraction(b))


def _hash(seed: mi.UInt32, use: mi.UInt32, index: mi.UInt32) -> tuple[mi.UInt32, mi.UInt32]:
    """64 random bits for each index, given the seed and what they are used for.

    The Tiny Encryption Algorithm (Zafar et al. 2010) under a key that is scattered first: keys of
    neighbouring ticks and streams differ in a bit or two, which few rounds alone do not hide.
    """
    key = _scatter(use ^ _scatter(seed + 1))
    return mi.sample_tea_32(index, key, 6)


def _scatter(x: mi.UInt32) -> mi.UInt32:
    """A bijection on 32 bits that spreads every bit over all (the finaliser of MurmurHash3)."""
    x = (x ^ (x >> 16)) * 0x85EBCA6B
    x = (x ^ (x >> 13)) * 0xC2B2AE35
    return x ^ (x >> 16)


def _fraction(bits: mi.UInt32) -> mi.Float:
    """[0, 1) from the upper 24 bits: they fill a float's mantissa and keep the result below one."""
    return mi.Float(bits >> 8) * 2.0**-24


def low_discrepancy_2d(time: Clock, stream: int, index: mi.UInt32, sample: mi.UInt32) -> mi.Point2f:
    """Point number `sample` of a Sobol (0, 2)-sequence, scrambled at random per index but not per tick.

    Successive samples of one index fill the square evenly, so the mean over frames converges
    faster than with independent numbers.
    """
    a, b = _hash(time.seed, mi.UInt32(stream), index)
    return mi.Point2f(mi.radical_inverse_2(sample, a), mi.sobol_2(sample, b))


def low_discrepancy(time: Clock, stream: int, index: mi.UInt32, sample: mi.UInt32) -> mi.Float:
    """Point number `sample` of the golden-ratio sequence on [0, 1), shifted at random per index.

    Independent of the pairs of `low_discrepancy_2d`, of which it may serve as third dimension.
    """
    start, _ = _hash(time.seed, mi.UInt32(stream + _STREAMS), index)
    return _fraction(start + sample * _GOLDEN)


def kronecker_2d(time: Clock, stream: int, index: mi.UInt32, sample: mi.UInt32) -> mi.Point2f:
    """Point number `sample` of a Kronecker sequence on the unit square, shifted at random per index.

    Multiples of 1/p and 1/p^2 with p^3 = p + 1 (Roberts 2018). Nearly as even as `low_discrepancy_2d`, and
    independent of it: two points of that with the same number, however scrambled, tell each other.
    """
    a, b = _hash(time.seed, mi.UInt32(stream + 2 * _STREAMS), index)
    return mi.Point2f(_fraction(a + sample * _PLASTIC[0]), _fraction(b + sample * _PLASTIC[1]))
