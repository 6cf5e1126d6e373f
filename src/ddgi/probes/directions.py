"""Directions that probes look in: a spherical Fibonacci set, turned at random each frame."""

from __future__ import annotations

import math

import drjit as dr
import mitsuba as mi

from ddgi import sampling
from ddgi.sampling import Clock


def fibonacci(count: int) -> mi.Vector3f:
    """Spherical Fibonacci set of `count` unit vectors (CTU eq. 4.1 to 4.3). (count,)."""
    i = dr.arange(mi.UInt32, count)
    # Fraction of i * golden ratio, in integers: exact for any count.
    turn = mi.Float((i * int((math.sqrt(5) - 1) / 2 * 2**32)) >> 8) * 2.0**-24
    odd = 2 * mi.Float(i) + 1
    z = 1 - odd / count
    radius = dr.sqrt(odd * (2 * count - odd)) / count  # sqrt(1 - z^2) without cancellation
    sin, cos = dr.sincos(turn * (2 * dr.pi))
    return mi.Vector3f(cos * radius, sin * radius, z)


def random_rotation(time: Clock) -> mi.Matrix3f:
    """One uniformly distributed rotation per frame: a unit quaternion (Shoemake 1992).

    Of a low-discrepancy sequence, so that the rays of successive frames fall between each other's.
    """
    u = sampling.low_discrepancy_2d(time, sampling.ROTATION, mi.UInt32(0), time.tick)
    v = sampling.low_discrepancy(time, sampling.ROTATION, mi.UInt32(0), time.tick)
    sin_a, cos_a = dr.sincos(2 * dr.pi * u.y)
    sin_b, cos_b = dr.sincos(2 * dr.pi * v)
    a, b = dr.sqrt(1 - u.x), dr.sqrt(u.x)
    x, y, z, w = a * sin_a, a * cos_a, b * sin_b, b * cos_b
    return mi.Matrix3f(
        1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
        2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
        2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y),
    )  # fmt: skip


def frame_directions(count: int, time: Clock) -> mi.Vector3f:
    """This frame's directions, the same for every probe. (count,) unit vectors."""
    return random_rotation(time) @ fibonacci(count)


def picked(directions: mi.Vector3f, ray: mi.UInt32) -> mi.Vector3f:
    """The directions of some rays. directions: (R,) in memory; ray: (N,) below R; result: (N,)."""
    return mi.Vector3f([dr.gather(mi.Float, axis, ray) for axis in directions])
