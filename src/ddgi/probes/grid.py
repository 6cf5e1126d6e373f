"""The probe grid: numbers, coordinates and positions of probes.

A grid has counts (nx, ny, nz); probe (x, y, z) has the number x + nx (y + ny z) and its place at
origin + (x, y, z) * spacing. It stands there, or near it where it was moved (`placement.py`). Counts
are compile-time, origin and spacing are data, so volumes of one shape share their kernels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated

import drjit as dr
import mitsuba as mi
import numpy as np
from annotated_types import Ge, Gt, Interval
from typing_extensions import Doc

from ddgi.box import Box
from ddgi.errors import SettingsError
from ddgi.extrema import at_most
from ddgi.own_memory import own
from ddgi.probes.walls import Walls, best_margins
from ddgi.settings_group import settings_group


@settings_group("grid")
class Settings:
    """Where the probes stand."""

    box: Annotated[
        Box | None, Doc("region to light [m], low and high corner; none: the scene's box of interest")
    ] = None
    counts: Annotated[
        tuple[int, int, int] | None, Doc("probes along x, y and z, 2 or more each; none: from the spacing")
    ] = None
    spacing: Annotated[
        Annotated[float, Gt(0)] | None, Doc("distance between probes [m]; none: from the budget of probes")
    ] = None
    budget: Annotated[
        int,
        Interval(ge=8, le=4_194_304),
        Doc("most probes to place when neither counts nor spacing are given"),
    ] = 2048
    margin: Annotated[
        Annotated[float, Interval(ge=-0.45, le=4)] | None,
        Doc(
            "how far the grid reaches beyond the box on each side, in spacings: -0.1 puts the outermost probes just "
            "inside walls at the box's faces, 0 in them, 0.45 behind them; none: fitted to the walls of the scene"
        ),
    ] = None
    memory_limit: Annotated[float, Ge(1), Doc("most memory the field may need [MB]")] = 4096.0


@dataclass
class ProbeGrid:
    """One regular grid of P = nx ny nz probes."""

    counts: tuple[int, int, int]
    origin: mi.Point3f  # (1,) position of probe 0 [m]
    spacing: mi.Vector3f  # (1,) [m]
    # (4 P,) x y z from each place to where its probe stands [m], then 1 if it gives light, else 0; None: all are there and do
    offset: mi.Float | None = None

    @property
    def size(self) -> int:
        """Number of probes P."""
        return math.prod(self.counts)

    @property
    def diagonal(self) -> mi.Float:
        """Main diagonal of a cell [m], (1,)."""
        return dr.norm(self.spacing)

    @property
    def smallest_spacing(self) -> mi.Float:
        """Least distance between neighbours [m], (1,)."""
        return at_most(at_most(self.spacing.x, self.spacing.y), self.spacing.z)

    def number(self, x: mi.UInt32, y: mi.UInt32, z: mi.UInt32) -> mi.UInt32:
        """Probe number of grid coordinates; no range check."""
        nx, ny, _ = self.counts
        return x + nx * (y + ny * z)

    def moved_by(self, offset: np.ndarray) -> ProbeGrid:
        """The grid with its probes elsewhere. offset: (P, 3) from their places [m]."""
        return self._with(offset, self.packets()[:, 3])

    def giving_light(self, which: np.ndarray) -> ProbeGrid:
        """The grid of which only some probes give light. which: (P,) bool."""
        return self._with(self.packets()[:, :3], which)

    def _with(self, offset: np.ndarray, gives_light: np.ndarray) -> ProbeGrid:
        if not offset.any() and gives_light.all():
            return replace(self, offset=None)
        return replace(self, offset=own(np.concatenate([offset, gives_light[:, None]], 1)))

    def packets(self) -> np.ndarray:
        """`offset` as an array, whether it is there or not. (P, 4)."""
        if self.offset is None:
            return np.tile(np.array([0, 0, 0, 1], np.float32), (self.size, 1))
        return np.array(self.offset).reshape(-1, 4)

    def offsets(self) -> np.ndarray:
        """From places to where probes stand [m]. (P, 3)."""
        return self.packets()[:, :3]

    def place(self, probe: mi.UInt32) -> mi.Point3f:
        """Where the grid has probes [m]. probe: (N,) numbers below P."""
        cell = mi.Vector3f([mi.Float(n) for n in self.coordinates(probe)])
        return dr.fma(cell, self.spacing, self.origin)

    def position(self, probe: mi.UInt32) -> mi.Point3f:
        """Where probes stand [m]. probe: (N,) numbers below P."""
        place = self.place(probe)
        return place if self.offset is None else place + self.moved(probe)

    def moved(self, probe: mi.UInt32, active: mi.Bool | bool = True) -> mi.Vector3f:
        """From their places to where probes stand [m]; `offset` is there. probe: (N,) numbers below P."""
        return mi.Vector3f(dr.gather(mi.Vector4f, self.offset, probe, active).xyz)

    def around(self, first: mi.UInt32, active: mi.Bool) -> list[mi.Vector4f] | None:
        """`offset` of the eight probes of cells, 8 x (N,), if it is there. first: (N,) the cells' first probes."""
        if self.offset is None:
            return None
        numbers = [first + self.number(k & 1, k >> 1 & 1, k >> 2 & 1) for k in range(8)]
        return [dr.gather(mi.Vector4f, self.offset, number, active) for number in numbers]

    def coordinates(self, probe: mi.UInt32) -> tuple[mi.UInt32, mi.UInt32, mi.UInt32]:
        """Grid coordinates x, y, z of probes. probe: (N,) numbers below P."""
        nx, ny, _ = self.counts
        row = probe // nx
        plane = row // ny
        return probe - row * nx, row - plane * ny, plane


def fit(box: Box, s: Settings, walls: list[Walls] | None = None) -> ProbeGrid:
    """Lay a grid over a box, after the settings.

    Args:
        box: The scene's box of interest [m]; `s.box` overrides it.
        s: Counts win over spacing, spacing over the budget.
        walls: The walls across each axis (`walls.find`), for a margin of none.

    Raises:
        SettingsError: The box is empty or not finite, or counts are below 2.
    """
    low, high = s.box or box
    extent = [b - a for a, b in zip(low, high, strict=True)]
    if not all(map(math.isfinite, (*low, *high))) or min(extent) < 0 or max(extent) <= 0:
        raise SettingsError(
            f"grid.box must be finite and have its low corner below the high one: {low} {high}"
        )
    flat = [a for a in _flat(extent, s) if walls is None or not _is_room(walls[a], low[a], high[a])]
    counts = _counts(extent, s, flat)
    if min(counts) < 2:
        raise SettingsError(f"grid.counts must be 2 or more along each axis: {counts}")
    axes = [
        _planes(low[a], high[a], counts[a], max(extent) * FLAT, s, walls[a] if walls else None)
        for a in range(3)
    ]
    step = min(axes[a][1] for a in range(3) if a not in flat)
    for a in flat:  # as many planes on either side, and none in what is flat
        axes[a] = (low[a] + high[a] - step * (counts[a] - 1)) / 2, step
    first, spacing = zip(*axes, strict=True)
    return ProbeGrid(counts, dr.opaque(mi.Point3f, list(first)), dr.opaque(mi.Vector3f, list(spacing)))


FLAT = 1e-3
"""With counts given, a box flatter than this share of its longest side is lit as if it were that thick."""
SQUASHED = 4
"""Cells that would be this many times as long as high are made as high as long, but in rooms, which end at their walls."""


def _flat(extent: list[float], s: Settings) -> list[int]:
    """Axes along which a box is far thinner than the spacing that its budget allows."""
    if s.counts is not None or s.spacing is not None:
        return []
    # A handful of probes has no spacing to speak of: a corridor is not flat for that.
    step = min(_step(extent, s, []), max(extent) / SQUASHED)
    return [a for a in range(3) if SQUASHED * extent[a] < step]


def _is_room(walls: Walls, low: float, high: float) -> bool:
    """Whether there are walls at both ends of an axis that face each other."""
    inwards = walls.facing * ((low + high) / 2 - walls.place) > 0
    return bool((inwards & (walls.facing > 0)).any() and (inwards & (walls.facing < 0)).any())


def _planes(low: float, high: float, count: int, smallest: float, s: Settings, walls: Walls | None):
    """First plane and spacing along one axis [m]."""
    low, high = (
        (low, high) if high - low >= smallest else ((low + high - smallest) / 2, (low + high + smallest) / 2)
    )
    if s.spacing is not None:
        return (low + high - s.spacing * (count - 1)) / 2, s.spacing
    below = above = -0.1 if s.margin is None else s.margin
    if s.margin is None and walls is not None:
        below, above = best_margins(walls, low, high, count)
    spacing = (high - low) / max(count - 1 - below - above, 0.5)
    return low - below * spacing, spacing


def _counts(extent: list[float], s: Settings, flat: list[int]) -> tuple[int, int, int]:
    """Probes along each axis: as set, for the spacing set, or as many as the budget allows."""
    if s.counts is not None:
        return s.counts
    if s.spacing is not None:
        return _counts_for(extent, s.spacing, s.margin, flat)
    return _fill(list(_counts_for(extent, _step(extent, s, flat), s.margin, flat)), extent, s.budget, flat)


def _step(extent: list[float], s: Settings, flat: list[int]) -> float:
    """The smallest cubic spacing within the budget, by bisection."""
    low, high = max(extent) * 1e-4, max(extent) * 2
    for _ in range(60):
        middle = math.sqrt(low * high)
        if math.prod(_counts_for(extent, middle, s.margin, flat)) > s.budget:
            low = middle
        else:
            high = middle
    return high


def _fill(counts: list[int], extent: list[float], budget: int, flat: list[int]) -> tuple[int, int, int]:
    """Spend what rounding left of the budget: more planes across the axes with the widest cells."""
    by_width = lambda a: extent[a] / (counts[a] - 1)  # noqa: E731
    for axis in sorted(set(range(3)) - set(flat), key=by_width, reverse=True):
        if math.prod(counts) // counts[axis] * (counts[axis] + 1) <= budget:
            counts[axis] += 1
    return counts[0], counts[1], counts[2]


def _counts_for(
    extent: list[float], step: float, margin: float | None, flat: list[int]
) -> tuple[int, int, int]:
    beyond = 2 * (margin or 0.0)
    counts = [max(2, math.ceil(e / step + beyond - 1e-6) + 1) for e in extent]
    for a in flat:  # an even number, of which the outermost are the margin away, or more
        counts[a] = 2 * max(1, math.ceil((beyond + 1) / 2 - 1e-6))
    return counts[0], counts[1], counts[2]
