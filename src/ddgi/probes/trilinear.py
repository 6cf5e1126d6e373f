"""Trilinear weights of the eight probes of a cell, also where probes were moved from their places.

MFF 3.3.1 asks of weights for moved probes that each stays in [0, 1] and that they add up to one; its
listing 3.12 gives neither. Here a point's place between two probes is measured from where they stand, as
far as that is in the cell: along the four edges that lead along x first, then between those, then between
the two faces. Where a cell ends, the next one has the same weights, and for probes in their places they
are the common ones.
"""

from __future__ import annotations

from collections.abc import Sequence

import drjit as dr
import mitsuba as mi

from ddgi.extrema import at_least, at_most, clamp

NARROWEST = 1e-3
"""Least distance between two probes along an edge of their cell, for both may come to its middle."""


def regular(place: mi.Vector3f) -> list[mi.Float]:
    """Weights of probes in their places. place: (N,) points in a cell, in [0, 1]^3; result: 8 x (N,)."""
    parts = [(1 - place[i], place[i]) for i in range(3)]
    return [parts[0][k & 1] * parts[1][k >> 1 & 1] * parts[2][k >> 2 & 1] for k in range(8)]


def corrected(place: mi.Vector3f, moved: Sequence[mi.Vector3f]) -> list[mi.Float]:
    """Weights of probes that were moved.

    Args:
        place: (N,) points in a cell, in [0, 1]^3.
        moved: 8 x (N,) from the probes' places to where they stand [spacings].
    """
    weights, ends = [mi.Float(1)] * 8, list(moved)
    for axis in range(3):
        joined = []
        for low, high in zip(ends[::2], ends[1::2], strict=True):
            first, last = at_least(low[axis], 0), at_most(1 + high[axis], 1)
            share = clamp((place[axis] - first) / at_least(last - first, NARROWEST), 0, 1)
            joined.append((share, dr.lerp(low, high, share)))
        for k in range(8):
            share = joined[k >> (axis + 1)][0]
            weights[k] = weights[k] * (share if k >> axis & 1 else 1 - share)
        ends = [end for _, end in joined]
    return weights
