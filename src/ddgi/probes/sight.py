"""Sight: which probes of a cell see one another, and so which of them a point in the cell may believe.

A distance map cannot tell the front of a wall without thickness from its back, nor a point on a wall
from one just beyond it: both lie as far away as what the probe sees. The probes themselves stand in the
open, so rays between them can. A probe behind the surface that a point lies on counts if those in front
of it see it: around the edge of a table they do, through a wall they do not. And where two probes in
front of it do not see each other, as beside the corner of a wall and a ceiling, one of them may be
hidden from the point: rays from the point find out which.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import drjit as dr
import mitsuba as mi

from ddgi.extrema import at_least
from ddgi.probes.grid import ProbeGrid
from ddgi.trace.tracer import Tracer

PAIRS = tuple(combinations(range(8), 2))
"""Of probes of a cell, by their numbers in it; bit k of a cell's sight stands for pair k."""
ALL = (1 << len(PAIRS)) - 1
"""Sight of a cell in which nothing is in the way."""
COUNTS = 0.01
"""Least share of a probe that rays from the point ask about; the others are left out."""
ASKED = 0.001
"""Likewise, were nothing hidden, for rays from the air."""
FOLDED = 0.01
"""Weight of all that rays from the point find open, as a share of what it were if nothing hid them, below which rays from
the air in front of it decide: maps that say hidden of all would else choose which of them to believe.
"""
KEPT = 0.1
"""Share of its weight that a probe keeps that those find open, whatever its map says."""
LOST = 1e-4
"""Weight of all probes in front of a point below which none of them sees it."""
ASIDE = (0.0017, -0.0023, 0.0029)
"""How far past a probe the rays to it end, in spacings: what is built to the grid has edges just on the way, where rays
slip through.
"""


@dataclass
class Asks:
    """Rays from N points to the probes of their cells."""

    tracer: Tracer
    point: mi.Point3f  # (N,) just off the surface [m]
    air: mi.Point3f | None  # (N,) further off, from where maps are asked [m]; None: it is itself in the air
    grid: ProbeGrid
    first: mi.UInt32  # (N,) first probe of the cell
    to_first: mi.Vector3f  # (N,) from the point to its place [m]
    active: mi.Bool  # (N,)

    def way(self, k: mi.UInt32) -> mi.Vector3f:
        """From the point to a probe of the cell, k from 0 to 7 [m]. (N,)."""
        x, y, z = k & 1, k >> 1 & 1, k >> 2 & 1
        way = dr.fma(mi.Vector3f(x, y, z), self.grid.spacing, self.to_first)
        if self.grid.offset is None:
            return way
        return way + self.grid.moved(self.first + self.grid.number(x, y, z), self.active)


def look(tracer: Tracer, grid: ProbeGrid) -> mi.UInt32:
    """Trace which probes see one another. (cells,) `PAIRS` as bits; cell numbers as of `cell_number`."""
    nx, ny, nz = (n - 1 for n in grid.counts)
    cell = dr.arange(mi.UInt32, nx * ny * nz)
    row = cell // nx
    x, y, z = cell - row * nx, row % ny, row // ny
    place = [grid.position(grid.number(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2 & 1))) for k in range(8)]
    aside = mi.Vector3f(*ASIDE) * grid.spacing
    seen = mi.UInt32(0)
    for bit, (i, j) in enumerate(PAIRS):
        way = place[j] + aside - place[i]
        length = dr.norm(way)
        open_ = tracer.visible(place[i], way / length, length, mi.Bool(True)) > 0.5
        seen |= dr.select(open_, mi.UInt32(1 << bit), mi.UInt32(0))
    dr.eval(seen)
    return seen


def cell_number(grid: ProbeGrid, base: mi.Vector3f) -> mi.UInt32:
    """Number of cells, by the coordinates of their first probes. base, result: (N,)."""
    nx, ny, _ = (n - 1 for n in grid.counts)
    x, y, z = (mi.UInt32(base[i]) for i in range(3))
    return x + nx * (y + ny * z)


def believed(
    seen: mi.UInt32,
    weights: Sequence[mi.Float],
    unhidden: Sequence[mi.Float],
    facing: Sequence[mi.Bool],
    asks: Asks | None,
    *,
    everywhere: bool = False,
) -> tuple[list[mi.Float], mi.Float]:
    """Weights of the probes of a cell without those that a point cannot believe, and that of all in front of it.

    Args:
        seen: (N,) sight of the points' cells.
        weights: 8 x (N,), after their distance maps.
        unhidden: 8 x (N,), were nothing hidden.
        facing: 8 x (N,) whether the probe is in front of the surface.
        asks: Asks rays about the probes in front; None: they are all believed.
        everywhere: Also in cells where nothing is in the way.
    """

    def trusted(seen, weights, unhidden, facing, asks):
        return list(weights), sum(_of(facing, weights))

    state = seen, list(weights), list(unhidden), list(facing), asks
    if everywhere:
        return _judged(*state)
    # A branch, as in most cells nothing is in the way.
    return dr.if_stmt(state, seen != ALL, _judged, trusted)


def _of(facing: Sequence[mi.Bool], weights: Sequence[mi.Float]) -> list[mi.Float]:
    """Weights of the probes in front, zero for the rest."""
    return [dr.select(f, w, 0) for f, w in zip(facing, weights, strict=True)]


def _judged(seen, weights, unhidden, facing, asks: Asks | None):
    """`believed` in cells where something is in the way."""
    sees = {pair: mi.Float(seen >> bit & 1) for bit, pair in enumerate(PAIRS)}
    front = _of(facing, weights)
    if asks is not None:
        front = _asked(front, _of(facing, unhidden), asks)
    total = sum(front)
    scale = dr.rcp(at_least(total, 1e-20))
    out = []
    for j in range(8):
        agreed = front[j]
        for i in range(8):
            if i != j:
                agreed = dr.fma(sees[min(i, j), max(i, j)], front[i], agreed)
        # Behind a surface, a probe counts as far as more than half of the light in front comes from probes that see it.
        behind = weights[j] * at_least(2 * agreed * scale - 1, 0)
        out.append(dr.select(facing[j], front[j], behind))
    return out, total


def _asked(front: Sequence[mi.Float], unhidden: Sequence[mi.Float], asks: Asks) -> list[mi.Float]:
    """Weights of the probes in front without those that rays find hidden.

    Rays from the point itself say which are open, and their maps what those count for: these are smooth, and rays alone
    would draw the outlines of what stands between a probe and a surface. Where that leaves next to nothing, as in the folds
    of a curtain, rays from the air in front of the point decide, from where maps are asked: there a probe that is open
    keeps `KEPT` at least.
    """
    found = _open(_counting(front, COUNTS), asks, asks.point)
    seen = [dr.select((found >> k & 1) == 1, weight, 0) for k, weight in enumerate(front)]
    if asks.air is None:
        return seen
    lost = sum(seen) < FOLDED * sum(unhidden)
    found = _open(dr.select(lost, _counting(unhidden, ASKED), mi.UInt32(0)), asks, asks.air)
    out = []
    for k, (own, weight, whole) in enumerate(zip(seen, front, unhidden, strict=True)):
        kept = dr.select((found >> k & 1) == 1, at_least(weight, KEPT * whole), 0)
        out.append(dr.select(lost, kept, own))
    return out


def _counting(weights: Sequence[mi.Float], share: float) -> mi.UInt32:
    """Which probes weigh more than a share of all, as bits."""
    least, out = share * sum(weights), mi.UInt32(0)
    for k, weight in enumerate(weights):
        out |= dr.select(weight > least, mi.UInt32(1 << k), mi.UInt32(0))
    return out


def _open(pending: mi.UInt32, asks: Asks, start: mi.Point3f) -> mi.UInt32:
    """Which of the probes named by bits rays from a start find open, as bits. A ray at a time: few points ask about many."""

    def ask(pending, found):
        k = dr.tzcnt(pending)
        way = asks.way(k) - (start - asks.point)
        length = at_least(dr.norm(way), 1e-9)
        seen = asks.tracer.visible(start, way / length, length, asks.active) > 0.5
        return pending & (pending - 1), found | dr.select(seen, mi.UInt32(1) << k, mi.UInt32(0))

    state = dr.select(asks.active, pending, mi.UInt32(0)), dr.zeros(mi.UInt32, dr.width(pending))
    _, found = dr.while_loop(state, lambda pending, _: pending != 0, ask, label="probes asked about")
    return found
