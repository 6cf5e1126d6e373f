"""Relocation by receivers: a probe stands well where the surfaces that read it see it.

Faces are not asked which way they look. What counts is which points a probe is read at: those of its cells
that light reaches on its way to a camera, found by paths traced back from the cameras. A point is well
served if probes that see it count much, and one more is worth the more the fewer there are; so probes
maximize, one after the other, the mean over points of log(LITTLE + trilinear weights of the probes that see
it). No two that share a cell move at once, so no move undoes another.

A move costs, as interpolation is best from where the grid has its probes: measured, probes that leave
walls only because they are near, or to look at them more squarely, light rooms worse (`docs/results.md`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.extrema import at_least
from ddgi.probes import trilinear
from ddgi.probes.grid import ProbeGrid
from ddgi.probes.region import Seen
from ddgi.trace.surface import slack
from ddgi.trace.tracer import Tracer

PER_CELL = 8
"""Points that stand for those of a cell."""
ROW = 8 * PER_CELL
"""Those of a probe's eight cells."""
LITTLE = 0.01
"""What a point has that no probe sees, in trilinear weights."""
WORTH = 0.02
"""Gain of the mean below which a move is not worth it."""
MOVED = 0.6
"""What a move to the limit along all axes takes from the mean."""
CROWDED = 2.0
"""What surfaces all around, nearer than the clearance, take from it."""
SPREADS = (0.5, 0.25)
"""Steps in which a place is looked for, from the best so far, in limits."""
LOT = 0x9E3779B9
"""Times the number of a point, in 32 bits, it is its lot: 2^32 over the golden ratio."""
AT_ONCE = 1 << 22
"""Rays traced together."""
WAYS = np.array(
    [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if abs(x) + abs(y) + abs(z) in (1, 3)],
    np.float32,
)  # fmt: skip
"""Where they lead: along the axes, and between them. (14, 3)."""


@dataclass
class Receivers:
    """Points that read probes: `PER_CELL`, M, of each of C cells, number = cell * M + point."""

    start: mi.Point3f  # (C M,) where rays to probes start [m]
    normal: mi.Vector3f  # (C M,) unit
    # (8 C M,) trilinear weights of the cell's probes, number * 8 + probe; 0 where there is no point
    near: mi.Float


def find(tracer: Tracer, grid: ProbeGrid, seen: Seen) -> Receivers | None:
    """Some of the surfaces seen in each cell; None if none are."""
    counts, origin, spacing = np.array(grid.counts), np.ravel(grid.origin), np.ravel(grid.spacing)
    place = (seen.position - origin) / spacing
    inside = (seen.weight > 0) & ((place > -0.5) & (place < counts - 0.5)).all(-1)
    if not inside.any():
        return None
    place, cells = place[inside], counts - 1
    base = np.clip(np.floor(place), 0, cells - 1)
    cell = (base @ [1, cells[0], cells[0] * cells[1]]).astype(int)
    # The first of each cell in an order by lot: where rounding moves a point to another cell, the others stay chosen.
    lot = np.flatnonzero(inside).astype(np.uint32) * np.uint32(LOT)
    order, many = np.lexsort((lot, cell)), np.bincount(cell, minlength=np.prod(cells))
    first = np.cumsum(many) - many
    pick = first[:, None] + np.arange(PER_CELL) % np.maximum(many, 1)[:, None]
    # Cells without points take another's, for nothing.
    chosen = order[np.minimum(pick, len(order) - 1)].ravel()
    within = np.clip(place - base, 0, 1)[chosen]
    near = np.array(trilinear.regular(mi.Vector3f(within.T))).T * np.repeat(many > 0, PER_CELL)[:, None]
    position = mi.Point3f(seen.position[inside][chosen].T)
    normal = mi.Vector3f(seen.normal[inside][chosen].T)
    start = dr.fma(normal, slack(position, tracer.extent), position)
    dr.eval(start, normal)
    return Receivers(start, normal, mi.Float(near.astype(np.float32).ravel()))


def served(tracer: Tracer, grid: ProbeGrid, seen: Seen) -> np.ndarray:
    """Which probes, where they stand, see a point that reads them. (P,)."""
    receivers = find(tracer, grid, seen)
    if receivers is None:
        return np.zeros(grid.size, bool)
    search = _Search(tracer, grid, receivers, np.zeros(3, np.float32), 0.0)
    probes = np.arange(grid.size)
    return np.any(search.counted(probes, grid.offsets()) > 0, axis=-1)


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
    receivers = find(tracer, grid, seen)
    if receivers is None:
        return offset
    search = _Search(tracer, grid, receivers, (limit * np.ravel(grid.spacing)).astype(np.float32), clearance)
    everyone = np.arange(grid.size)
    counted = search.counted(everyone, offset)
    parity = np.array(grid.coordinates(mi.UInt32(everyone))).T % 2 @ [1, 2, 4]
    for _ in range(iterations):
        for turn in range(8):
            others = search.others(counted)
            probes = search.promising(np.flatnonzero(parity == turn), offset, others, counted)
            if len(probes):
                offset[probes] = search.best(probes, offset[probes], others)
                counted[probes] = search.counted(probes, offset[probes])
    return offset


class _Search:
    """Probes, and for each the R = 8 M receivers of its cells, in a row."""

    def __init__(
        self, tracer: Tracer, grid: ProbeGrid, receivers: Receivers, limit: np.ndarray, clearance: float
    ):
        self.tracer, self.grid, self.receivers = tracer, grid, receivers
        self.limit, self.clearance = limit, dr.opaque(mi.Float, clearance)
        lane = dr.arange(mi.UInt32, grid.size * ROW)
        number, near = self._of(lane // ROW, lane % ROW)
        self.numbers, self.near = (np.array(x).reshape(-1, ROW) for x in (number, near))
        self.many = np.maximum((self.near > 0).sum(-1), 1)

    def counted(self, probes: np.ndarray, offset: np.ndarray) -> np.ndarray:
        """What probes count for their receivers: nothing where they do not see them.

        probes: (p,) numbers; offset: (p, 3) [m]; result: (p, R).
        """
        return self._in_chunks(self._counted, probes, offset[:, None]).reshape(-1, ROW)

    def others(self, counted: np.ndarray) -> np.ndarray:
        """What all other probes count for the receivers of each. counted: (P, R), of all; result: (P, R)."""
        total = np.bincount(self.numbers.ravel(), counted.ravel(), dr.width(self.receivers.start))
        return np.maximum(total[self.numbers] - counted, 0).astype(np.float32)

    def promising(
        self, probes: np.ndarray, offset: np.ndarray, others: np.ndarray, counted: np.ndarray
    ) -> np.ndarray:
        """Those of some probes that could gain enough, if they saw all and nothing were too near.

        probes: (p,); offset: (P, 3) [m]; others, counted: (P, R).
        """
        others, near = LITTLE + others[probes], self.near[probes]
        gain = np.log((others + near) / (others + counted[probes])).sum(-1) / self.many[probes]
        crowded = self._in_chunks(self._crowded, probes, offset[probes][:, None])
        return probes[gain + CROWDED * crowded > WORTH]

    def best(self, probes: np.ndarray, offset: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Better offsets than those that probes have, or the same.

        probes: (p,); offset, result: (p, 3) [m]; others: (P, R).
        """
        served_else = mi.Float(others.ravel())
        for spread in SPREADS:
            ahead = offset[:, None] + WAYS * (spread * self.limit)
            options = np.concatenate([offset[:, None], np.zeros_like(offset)[:, None], ahead], 1)
            options = np.clip(options, -self.limit, self.limit)
            worth = self._in_chunks(partial(self._worth, served_else), probes, options).reshape(
                options.shape[:2]
            )
            worth -= MOVED * np.square(options / self.limit).mean(-1)
            worth[:, 1:] -= WORTH * (options[:, 1:] != 0).any(-1)
            offset = options[np.arange(len(probes)), worth.argmax(-1)]
        return offset

    def _in_chunks(
        self, find: Callable[[mi.UInt32, mi.Point3f, int], mi.Float], probes: np.ndarray, options: np.ndarray
    ) -> np.ndarray:
        """What is found of probes with as many options each, some probes after the other.

        probes: (p,) numbers; options: (p, count, 3) offsets [m]; result: flat.
        """
        count = options.shape[1]
        chunk = max(1, AT_ONCE // (count * ROW))
        found = []
        for i in range(0, len(probes), chunk):
            some = mi.UInt32(probes[i : i + chunk].astype(np.uint32))
            at = mi.Point3f(options[i : i + chunk].reshape(-1, 3).T)
            found.append(np.array(find(some, at, count)))
        return np.concatenate(found) if found else np.zeros(0, np.float32)

    def _worth(self, others: mi.Float, probes: mi.UInt32, options: mi.Point3f, count: int) -> mi.Float:
        """What options are worth, but for what their distance takes from it. others: (P R,); options, result: (p count,)."""
        lane = dr.arange(mi.UInt32, dr.width(options) * ROW)
        option, receiver = lane // ROW, lane % ROW
        probe = dr.gather(mi.UInt32, probes, option // count)
        served = dr.gather(mi.Float, others, probe * ROW + receiver)
        counted, near = self._weights(probe, dr.gather(mi.Point3f, options, option), receiver)
        served = dr.select(near > 0, dr.log(LITTLE + served + counted), 0)
        many = at_least(dr.block_sum(dr.select(near > 0, mi.Float(1), mi.Float(0)), ROW), 1)
        return dr.block_sum(served, ROW) / many - CROWDED * self._crowded(probes, options, count)

    def _counted(self, probes: mi.UInt32, options: mi.Point3f, count: int) -> mi.Float:
        """`counted` of options. (p count R,)."""
        lane = dr.arange(mi.UInt32, dr.width(options) * ROW)
        option = lane // ROW
        probe = dr.gather(mi.UInt32, probes, option // count)
        return self._weights(probe, dr.gather(mi.Point3f, options, option), lane % ROW)[0]

    def _weights(
        self, probe: mi.UInt32, offset: mi.Point3f, receiver: mi.UInt32
    ) -> tuple[mi.Float, mi.Float]:
        """What moved probes count for receivers, and would if they saw them straight ahead. (N,)."""
        number, near = self._of(probe, receiver)
        start = dr.gather(mi.Point3f, self.receivers.start, number)
        way = self.grid.place(probe) + offset - start
        length = at_least(dr.norm(way), 1e-9)
        direction = way / length
        cosine = dr.dot(dr.gather(mi.Vector3f, self.receivers.normal, number), direction)
        visible = self.tracer.visible(start, direction, length, (near > 0) & (cosine > 0))
        return near * visible, near

    def _of(self, probe: mi.UInt32, receiver: mi.UInt32) -> tuple[mi.UInt32, mi.Float]:
        """Numbers of receivers in the rows of probes, and trilinear weights, 0 where there is none. (N,)."""
        nx, ny, nz = self.grid.counts
        k = receiver // PER_CELL
        # Coordinates of the cell in which the probe is number k, plus one.
        x, y, z = (n + 1 - (k >> axis & 1) for axis, n in enumerate(self.grid.coordinates(probe)))
        exists = (x > 0) & (y > 0) & (z > 0) & (x < nx) & (y < ny) & (z < nz)
        cell = (x - 1) + (nx - 1) * ((y - 1) + (ny - 1) * (z - 1))
        number = dr.select(exists, cell * PER_CELL + receiver % PER_CELL, 0)
        return number, dr.gather(mi.Float, self.receivers.near, number * 8 + k, exists)

    def _crowded(self, probes: mi.UInt32, options: mi.Point3f, count: int) -> mi.Float:
        """Share of the ways from options that end before the clearance. (p count,)."""
        ways = mi.Vector3f((WAYS / np.linalg.norm(WAYS, axis=-1, keepdims=True)).T)
        lane = dr.arange(mi.UInt32, dr.width(options) * len(WAYS))
        option = lane // len(WAYS)
        start = self.grid.place(dr.gather(mi.UInt32, probes, option // count)) + dr.gather(
            mi.Point3f, options, option
        )
        direction = dr.gather(mi.Vector3f, ways, lane % len(WAYS))
        free = self.tracer.visible(start, direction, self.clearance, mi.Bool(True))
        return 1 - dr.block_sum(free, len(WAYS)) / len(WAYS)
