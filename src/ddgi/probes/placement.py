"""Relocation by receivers: a probe stands well where the surfaces that read it see it, and see what it sees.

Faces are not asked which way they look. A point (`receivers.py`) is well served if probes that see it count
much, and one more is worth the more the fewer there are; and if the room ahead of it (`openness.py`),
interpolated between them, is the room that it has. So probes maximize, one after the other, the mean over
points of log(LITTLE + counts of the probes that see it) - UNLIKE log(room interpolated / its own)^2. A probe
counts by its trilinear weight, less the further it has moved, as interpolation is best from where the grid
has its probes, and less where a surface is nearer than the clearance. No two that share a cell move at once,
so no move undoes another.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.extrema import at_least, at_most
from ddgi.probes import openness, receivers
from ddgi.probes.grid import ProbeGrid
from ddgi.probes.receivers import ROW, Receivers
from ddgi.probes.region import Seen
from ddgi.trace.tracer import Tracer

LITTLE = 0.01
"""What a point has that no probe sees, in trilinear weights."""
UNLIKE = 10.0
"""What it costs, per squared logarithm, that probes have more or less room ahead than the points they serve."""
UTTERLY = 1.5
"""Logarithm beyond which they are no more unlike."""
UNSEEN = 1.0
"""The same, of points that no probe sees."""
NEARBY = 0.25
"""Surfaces at that distance take half of the room, in the smallest spacing."""
SLIGHT = 0.02
"""Room below which there is as good as none."""
WORTH = 0.02
"""Gain of the mean below which a move is not worth it."""
MOVED = 1.0
"""Share that a probe no longer counts which has moved to the limit along all axes; as its distance squared."""
CROWDED = 0.3
"""Share that one no longer counts with a surface nearer than the clearance."""
SPREADS = (1.0, 0.5, 0.25)
"""Steps in which a place is looked for, from the best so far, in limits."""
AT_ONCE = 1 << 22
"""Rays traced together."""
WAYS = np.array(
    [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if abs(x) + abs(y) + abs(z) in (1, 3)],
    np.float32,
)  # fmt: skip
"""Where they lead: along the axes, and between them. (14, 3)."""


def place(
    tracer: Tracer, grid: ProbeGrid, seen: Seen, limit: float, clearance: float, iterations: int
) -> np.ndarray:
    """Find where probes serve their receivers best.

    Args:
        tracer: The scene.
        grid: The probes' places.
        seen: Surfaces that light reaches on its way to the cameras.
        limit: Farthest move along each axis [spacings].
        clearance: Surfaces nearer than that are too near [m].
        iterations: How often each probe has its turn.

    Returns:
        (P, 3) from the probes' places to where they are to stand [m].
    """
    offset = np.zeros((grid.size, 3), np.float32)
    found = receivers.find(tracer, grid, seen)
    if found is None:
        return offset
    search = _Search(tracer, found, (limit * np.ravel(grid.spacing)).astype(np.float32), clearance)
    everyone = np.arange(grid.size)
    given = search.given(everyone, offset)
    parity = np.array(grid.coordinates(mi.UInt32(everyone))).T % 2 @ [1, 2, 4]
    for _ in range(iterations):
        for turn in range(8):
            others = search.others(given)
            probes = search.promising(np.flatnonzero(parity == turn), given, others)
            if len(probes):
                offset[probes] = search.best(probes, offset[probes], others)
                given[:, probes] = search.given(probes, offset[probes])
    return offset


@dataclass
class _Options:
    """Places that probes could stand at, and what receivers would have of them. (p count R,) lanes."""

    probe: mi.UInt32
    receiver: mi.UInt32  # its place in the probe's row
    number: mi.UInt32  # its number
    near: mi.Float  # trilinear weight
    weight: mi.Float  # what the probe counts for it
    room: mi.Float  # ahead of the probe, the way that the receiver faces


class _Search:
    """Probes and their rows of R receivers. What they give those is (2, p, R): counts, and room times counts."""

    def __init__(self, tracer: Tracer, found: Receivers, limit: np.ndarray, clearance: float):
        self.tracer, self.receivers, self.grid, self.limit = tracer, found, found.grid, limit
        self.clearance = dr.opaque(mi.Float, clearance)
        self.nearby = NEARBY * float(np.ravel(self.grid.spacing).min())
        self.room = openness.of_surfaces(tracer, found.start, found.normal, self.nearby)
        lane = dr.arange(mi.UInt32, self.grid.size * ROW)
        numbers, near = found.of(lane // ROW, lane % ROW)
        self.numbers, self.near = (np.array(x).reshape(-1, ROW) for x in (numbers, near))
        dr.eval(self.room)

    def given(self, probes: np.ndarray, offset: np.ndarray) -> np.ndarray:
        """What probes give the receivers in their rows. probes: (p,); offset: (p, 3) [m]; result: (2, p, R)."""
        return self._in_chunks(self._given, probes, offset[:, None]).reshape(2, -1, ROW)

    def others(self, given: np.ndarray) -> np.ndarray:
        """What all other probes give the receivers in each one's row. given, result: (2, P, R)."""
        count = dr.width(self.receivers.start)
        total = np.stack([np.bincount(self.numbers.ravel(), part.ravel(), count) for part in given])
        return np.maximum(total[:, self.numbers] - given, 0).astype(np.float32)

    def promising(self, probes: np.ndarray, given: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Those of some probes, (p,), that could gain enough, if they gave all they can. given, others: (2, P, R)."""
        given, others, near = given[:, probes], others[:, probes], self.near[probes]
        number = mi.UInt32(self.numbers[probes].ravel())
        weight, room = (mi.Float((a + b).ravel()) for a, b in zip(others, given, strict=True))
        now = self._worth(mi.Float(near.ravel()), weight, room, number)
        best = np.log(LITTLE + others[0] + near, where=near > 0, out=np.zeros_like(near)).sum(-1)
        many = np.maximum((near > 0).sum(-1), 1)
        return probes[best / many - np.array(now) > WORTH]

    def best(self, probes: np.ndarray, offset: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Better offsets than those that probes have, or the same.

        probes: (p,); offset, result: (p, 3) [m]; others: (2, P, R).
        """
        served = [mi.Float(part.ravel()) for part in others]
        for spread in SPREADS:
            ahead = offset[:, None] + WAYS * (spread * self.limit)
            options = np.concatenate([offset[:, None], np.zeros_like(offset)[:, None], ahead], 1)
            options = np.clip(options, -self.limit, self.limit)
            worth = self._in_chunks(partial(self._with_others, served), probes, options)
            worth = worth.reshape(options.shape[:2])
            worth[:, 1:] -= WORTH * (options[:, 1:] != 0).any(-1)
            offset = options[np.arange(len(probes)), worth.argmax(-1)]
        return offset

    def _in_chunks(
        self, find: Callable[[mi.UInt32, mi.Point3f, int], mi.Float], probes: np.ndarray, options: np.ndarray
    ) -> np.ndarray:
        """What is found of probes with as many options each, some probes after the other.

        probes: (p,) numbers; options: (p, count, 3) offsets [m]; result: (N,) or (n, N) as of `find`.
        """
        count = options.shape[1]
        chunk = max(1, AT_ONCE // (count * ROW))
        found = []
        for i in range(0, len(probes), chunk):
            some = mi.UInt32(probes[i : i + chunk].astype(np.uint32))
            at = mi.Point3f(options[i : i + chunk].reshape(-1, 3).T)
            found.append(np.array(find(some, at, count)))
        return np.concatenate(found, -1)

    def _given(self, probes: mi.UInt32, options: mi.Point3f, count: int) -> mi.Vector2f:
        """`given` of options. (p count R,)."""
        at = self._options(probes, options, count)
        return mi.Vector2f(at.weight, at.weight * at.room)

    def _with_others(
        self, others: list[mi.Float], probes: mi.UInt32, options: mi.Point3f, count: int
    ) -> mi.Float:
        """What options are worth beside what others give, 2 x (P R,). (p count,)."""
        at = self._options(probes, options, count)
        weight, room = (dr.gather(mi.Float, part, at.probe * ROW + at.receiver) for part in others)
        return self._worth(at.near, weight + at.weight, dr.fma(at.weight, at.room, room), at.number)

    def _worth(self, near: mi.Float, weight: mi.Float, room: mi.Float, number: mi.UInt32) -> mi.Float:
        """How well receivers are served, means over rows.

        Args:
            near: (N R,) trilinear weights of the row's probe; 0 where there is no receiver.
            weight: (N R,) what all probes of the cell count for the receiver.
            room: (N R,) sums of counts times the room ahead of those probes.
            number: (N R,) of the receivers.

        Returns:
            (N,).
        """
        own = dr.gather(mi.Float, self.room, number)
        seen = room / at_least(weight, 1e-6)
        unlike = at_most(dr.abs(dr.log((seen + SLIGHT) / (own + SLIGHT))), UTTERLY)
        unlike = dr.select(weight > 0, unlike, UNSEEN)
        served = dr.log(LITTLE + weight) - UNLIKE * dr.square(unlike)
        many = at_least(dr.block_sum(dr.select(near > 0, mi.Float(1), mi.Float(0)), ROW), 1)
        return dr.block_sum(dr.select(near > 0, served, 0), ROW) / many

    def _options(self, probes: mi.UInt32, options: mi.Point3f, count: int) -> _Options:
        """What receivers would have of probes with `count` options each. options: (p count,) [m]."""
        option = dr.arange(mi.UInt32, dr.width(options))
        stands = self.grid.place(dr.gather(mi.UInt32, probes, option // count)) + options
        dr.eval(stands)
        around = openness.of_places(self.tracer, stands, self.nearby)
        moved = dr.squared_norm(options / mi.Vector3f(self.limit[:, None])) / 3
        crowded = dr.select(around.nearest < self.clearance, mi.Float(CROWDED), mi.Float(0))
        counts = (1 - MOVED * moved) * (1 - crowded)
        dr.eval(counts)

        lane = dr.arange(mi.UInt32, dr.width(options) * ROW)
        option, receiver = lane // ROW, lane % ROW
        probe = dr.gather(mi.UInt32, probes, option // count)
        number, near = self.receivers.of(probe, receiver)
        sees = self.receivers.seen(self.tracer, number, near, dr.gather(mi.Point3f, stands, option))
        weight = sees * dr.gather(mi.Float, counts, option)
        room = around.along(option, dr.gather(mi.Vector3f, self.receivers.normal, number))
        return _Options(probe, receiver, number, near, weight, room)
