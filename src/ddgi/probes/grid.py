"""The probe grid: numbers, coordinates and positions of probes.

A grid has counts (nx, ny, nz); probe (x, y, z) has the number x + nx (y + ny z) and stands at
origin + (x, y, z) * spacing. Counts are compile-time, origin and spacing are data, so volumes of
one shape share their kernels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import drjit as dr
import mitsuba as mi
from annotated_types import Ge, Gt, Interval
from typing_extensions import Doc

from ddgi.box import Box
from ddgi.errors import SettingsError
from ddgi.extrema import at_most
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

    def position(self, probe: mi.UInt32) -> mi.Point3f:
        """Where probes stand [m]. probe: (N,) numbers below P."""
        cell = mi.Vector3f([mi.Float(n) for n in self.coordinates(probe)])
        return dr.fma(cell, self.spacing, self.origin)

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
    counts = _counts(extent, s)
    if min(counts) < 2:
        raise SettingsError(f"grid.counts must be 2 or more along each axis: {counts}")
    axes = [
        _planes(low[a], high[a], counts[a], max(extent) * FLAT, s, walls[a] if walls else None)
        for a in range(3)
    ]
    first, spacing = zip(*axes, strict=True)
    return ProbeGrid(counts, dr.opaque(mi.Point3f, list(first)), dr.opaque(mi.Vector3f, list(spacing)))


FLAT = 1e-3
"""A box flatter than this share of its longest side is lit as if it were that thick."""


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


def _counts(extent: list[float], s: Settings) -> tuple[int, int, int]:
    """Probes along each axis: as set, for the spacing set, or as many as the budget allows."""
    if s.counts is not None:
        return s.counts
    if s.spacing is not None:
        return _counts_for(extent, s.spacing, s.margin)
    low, high = max(extent) * 1e-4, max(extent) * 2
    for _ in range(60):  # bisect for the smallest cubic spacing within the budget
        middle = math.sqrt(low * high)
        if math.prod(_counts_for(extent, middle, s.margin)) > s.budget:
            low = middle
        else:
            high = middle
    return _fill(list(_counts_for(extent, high, s.margin)), extent, s.budget)


def _fill(counts: list[int], extent: list[float], budget: int) -> tuple[int, int, int]:
    """Spend what rounding left of the budget: more planes across the axes with the widest cells."""
    by_width = lambda a: extent[a] / (counts[a] - 1)  # noqa: E731
    for axis in sorted(range(3), key=by_width, reverse=True):
        if math.prod(counts) // counts[axis] * (counts[axis] + 1) <= budget:
            counts[axis] += 1
    return counts[0], counts[1], counts[2]


def _counts_for(extent: list[float], step: float, margin: float | None) -> tuple[int, int, int]:
    beyond = 2 * (margin or 0.0)
    x, y, z = (max(2, math.ceil(e / step + beyond - 1e-6) + 1) for e in extent)
    return x, y, z
