"""Nothing that is not a number may enter the field or a picture: it would spread from there."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi


def finite(radiance: mi.Color3f) -> tuple[mi.Color3f, mi.UInt32]:
    """Replace colours that are not finite by black, and count them. radiance: (N,); count: (1,)."""
    good = dr.all(dr.isfinite(radiance))
    count = dr.opaque(mi.UInt32, 0)
    # Directly: hardly ever does one add to it, which a copy of the count for each thread would not be worth.
    one, mode = mi.UInt32(1), dr.ReduceMode.Direct
    dr.scatter_reduce(dr.ReduceOp.Add, count, one, mi.UInt32(0), ~good, mode=mode)
    return dr.select(good, radiance, mi.Color3f(0)), count
