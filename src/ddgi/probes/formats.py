"""How the two maps of a probe are stored: a codec per format, one texel at a time.

Irradiance texels hold the value that the query interpolates; distance texels hold mean and mean
square in units of the longest distance kept, so half precision neither overflows nor loses small
scenes. Formats below 32 bits round at random (dither), else a blend of 97 % old and 3 % new would
stall as soon as its step is smaller than half a unit of the format.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from ddgi.extrema import at_least, at_most, clamp, largest


@dataclass(frozen=True)
class Format:
    """A texel format: array type of a packet, and the two directions of its codec."""

    bytes: int
    """Bytes of one texel."""
    packet: Callable[[], type]
    """The Dr.Jit type of one texel, its leading dimension the channels (after a backend is chosen)."""
    encode: Callable[[Any, mi.Float], Any]
    """(value, dither in [0, 1)) -> packet."""
    decode: Callable[[Any], Any]
    """packet -> value."""


def _scalar(packet: type) -> type:
    return dr.leaf_t(packet)


def allocate(fmt: Format, texels: int) -> Any:
    """A flat array of `texels` zero texels, in memory (not a literal)."""
    packet = fmt.packet()
    return dr.opaque(_scalar(packet), 0, texels * dr.size_v(packet))


def read(fmt: Format, store: Any, texel: mi.UInt32, active: mi.Bool) -> Any:
    """Values of texels; zero on inactive lanes."""
    return fmt.decode(dr.gather(fmt.packet(), store, texel, active))


def pack(fmt: Format, value: Any, dither: mi.Float) -> Any:
    """The flat array of all texels' values, in order."""
    return dr.ravel(fmt.encode(value, dither))


# ---- irradiance: three channels ---------------------------------------------------------------


def _shorten(x: mi.Float, mantissa: int, dither: mi.Float) -> mi.Float:
    """Round to a float of five exponent bits (bias 15) and fewer mantissa bits, up or down at random.

    x: >= 0. The mean over dithers is x itself, up to the format's largest value, where it saturates.
    """
    top = (2 - 2.0**-mantissa) * 2.0**15
    x = clamp(x, 0, top)
    spare = 23 - mantissa
    bits = dr.reinterpret_array(mi.UInt32, x) + mi.UInt32(dither * 2**spare)
    normal = dr.reinterpret_array(
        mi.Float, bits & (0xFFFFFFFF << spare & 0xFFFFFFFF)
    )  # a carry goes on into the exponent
    unit = 2.0 ** (-14 - mantissa)
    return dr.select(x < 2.0**-14, dr.floor(x / unit + dither) * unit, at_most(normal, top))


def _f16(value: mi.Float, dither: mi.Float) -> Any:
    return dr.float16_array_t(mi.Float)(_shorten(value, 10, dither))


def _rgbe_encode(c: mi.Color3f, dither: mi.Float) -> Any:
    """Eight bits a channel with a shared exponent (Ward 1991)."""
    # The exponent that brings the largest channel to at most 255, so that no rounding overflows.
    exponent = clamp(dr.ceil(dr.log2(largest(c) * (256 / 255)) - 1e-6), -120, 120)
    scale = dr.exp2(8 - exponent)
    quantise = lambda x: at_most(dr.floor(x * scale + dither), 255)  # noqa: E731
    return _packet_u8(4)(quantise(c.x), quantise(c.y), quantise(c.z), exponent + 128)


def _rgbe_decode(t: Any) -> mi.Color3f:
    scale = dr.exp2(mi.Float(t.w) - 136)
    return mi.Color3f(mi.Float(t.x) * scale, mi.Float(t.y) * scale, mi.Float(t.z) * scale)


def _packet_u8(channels: int) -> type:
    return dr.uint8_array_t(mi.Vector4f if channels == 4 else mi.Vector2f)


def _small_float(x: mi.Float, mantissa: int, dither: mi.Float) -> mi.UInt32:
    """The bits of an unsigned float with five exponent bits, as in R11G11B10."""
    x = _shorten(x, mantissa, dither)
    bits = dr.reinterpret_array(mi.UInt32, x) >> (23 - mantissa)
    subnormal = mi.UInt32(dr.round(x * 2.0 ** (14 + mantissa)))
    return dr.select(x < 2.0**-14, subnormal, bits - ((127 - 15) << mantissa))


def _small_float_decode(bits: mi.UInt32, mantissa: int) -> mi.Float:
    exponent, fraction = mi.Float(bits >> mantissa), mi.Float(bits & (2**mantissa - 1))
    normal = exponent > 0
    significand = dr.select(normal, fraction + 2**mantissa, fraction)
    return significand * dr.exp2(at_least(exponent, 1) - 15 - mantissa)


def _r11g11b10_encode(c: mi.Color3f, dither: mi.Float) -> Any:
    return _wrap1(
        _small_float(c.x, 6, dither)
        | (_small_float(c.y, 6, dither) << 11)
        | (_small_float(c.z, 5, dither) << 22)
    )


def _r11g11b10_decode(t: Any) -> mi.Color3f:
    bits = t[0]
    return mi.Color3f(
        _small_float_decode(bits & 0x7FF, 6),
        _small_float_decode((bits >> 11) & 0x7FF, 6),
        _small_float_decode(bits >> 22, 5),
    )


def _wrap1(x: mi.UInt32) -> Any:
    return dr.uint32_array_t(mi.Vector1f)(x)


IRRADIANCE: dict[str, Format] = {
    "float32": Format(
        16,
        lambda: mi.Vector4f,
        lambda c, _: mi.Vector4f(c.x, c.y, c.z, 0),
        lambda t: mi.Color3f(t.x, t.y, t.z),
    ),
    "float16": Format(
        8,
        lambda: dr.float16_array_t(mi.Vector4f),
        lambda c, d: dr.float16_array_t(mi.Vector4f)(_f16(c.x, d), _f16(c.y, d), _f16(c.z, d), 0),
        lambda t: mi.Color3f(mi.Float(t.x), mi.Float(t.y), mi.Float(t.z)),
    ),
    "rgbe8": Format(4, lambda: _packet_u8(4), _rgbe_encode, _rgbe_decode),
    "r11g11b10": Format(4, lambda: dr.uint32_array_t(mi.Vector1f), _r11g11b10_encode, _r11g11b10_decode),
}
"""Formats of the irradiance map. R11G11B10 is what BLOG uses; rgbe8 is eight bits a channel."""

# ---- distance: mean and mean square, in [0, 1] unless long distances are kept ------------------


def _unorm8_encode(m: mi.Vector2f, dither: mi.Float) -> Any:
    # The root of the mean square has the range and the resolution of the mean.
    quantise = lambda x: clamp(dr.floor(x * 255 + dither), 0, 255)  # noqa: E731
    return _packet_u8(2)(quantise(m.x), quantise(dr.sqrt(m.y)))


def _unorm8_decode(t: Any) -> mi.Vector2f:
    mean, rms = mi.Float(t.x) / 255, mi.Float(t.y) / 255
    return mi.Vector2f(mean, rms * rms)


DISTANCE: dict[str, Format] = {
    "float32": Format(8, lambda: mi.Vector2f, lambda m, _: m, lambda t: t),
    "float16": Format(
        4,
        lambda: dr.float16_array_t(mi.Vector2f),
        lambda m, d: dr.float16_array_t(mi.Vector2f)(_f16(m.x, d), _f16(m.y, d)),
        lambda t: mi.Vector2f(mi.Float(t.x), mi.Float(t.y)),
    ),
    "unorm8": Format(2, lambda: _packet_u8(2), _unorm8_encode, _unorm8_decode),
}
"""Formats of the distance map."""
