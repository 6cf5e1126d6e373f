"""Receivers: the points that read probes, and which probes they see.

They are those of each cell that light reaches on its way to a camera, found by paths traced back from the
cameras. Which way faces look is not asked.
"""

from __future__ import annotations

from dataclasses import dataclass

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
LOT = 0x9E3779B9
"""Times the number of a point, in 32 bits, it is its lot: 2^32 over the golden ratio."""


@dataclass
class Receivers:
    """Points that read probes: `PER_CELL`, M, of each of C cells, number = cell * M + point.

    Each probe has a row of R = 8 M of them, those of its cells.
    """

    grid: ProbeGrid
    start: mi.Point3f  # (C M,) where rays to probes start [m]
    normal: mi.Vector3f  # (C M,) unit
    # (8 C M,) trilinear weights of the cell's probes, number * 8 + probe; 0 where there is no point
    near: mi.Float

    def of(self, probe: mi.UInt32, place: mi.UInt32) -> tuple[mi.UInt32, mi.Float]:
        """Numbers of receivers in probes' rows, and the probes' trilinear weights, 0 where there is none. (N,)."""
        nx, ny, nz = self.grid.counts
        k = place // PER_CELL
        # Coordinates of the cell in which the probe is number k, plus one.
        x, y, z = (n + 1 - (k >> axis & 1) for axis, n in enumerate(self.grid.coordinates(probe)))
        exists = (x > 0) & (y > 0) & (z > 0) & (x < nx) & (y < ny) & (z < nz)
        cell = (x - 1) + (nx - 1) * ((y - 1) + (ny - 1) * (z - 1))
        number = dr.select(exists, cell * PER_CELL + place % PER_CELL, 0)
        return number, dr.gather(mi.Float, self.near, number * 8 + k, exists)

    def seen(self, tracer: Tracer, number: mi.UInt32, near: mi.Float, probe: mi.Point3f) -> mi.Float:
        """Trilinear weights of probes that receivers see in front of them; 0 of others. (N,).

        Args:
            tracer: The scene.
            number: (N,) of receivers.
            near: (N,) trilinear weights of the probes.
            probe: (N,) where they stand [m].
        """
        start = dr.gather(mi.Point3f, self.start, number)
        way = probe - start
        length = at_least(dr.norm(way), 1e-9)
        direction = way / length
        cosine = dr.dot(dr.gather(mi.Vector3f, self.normal, number), direction)
        return near * tracer.visible(start, direction, length, (near > 0) & (cosine > 0))


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
    return Receivers(grid, start, normal, mi.Float(near.astype(np.float32).ravel()))


def served(tracer: Tracer, grid: ProbeGrid, seen: Seen) -> np.ndarray:
    """Which probes, where they stand, see a point that reads them. (P,)."""
    receivers = find(tracer, grid, seen)
    if receivers is None:
        return np.zeros(grid.size, bool)
    lane = dr.arange(mi.UInt32, grid.size * ROW)
    probe = lane // ROW
    number, near = receivers.of(probe, lane % ROW)
    weight = receivers.seen(tracer, number, near, grid.position(probe))
    return np.array(dr.block_sum(weight, ROW)) > 0
