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

from ddgi.extrema import at_most
from ddgi.errors import SettingsError

Triple = tuple[float, float, float]
Box = tuple[Triple, Triple]


@dataclass(frozen=True, slots=True, kw_only=True)
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
    budget: Annotated[int, Interval(ge=8, le=4_194_304), Doc("most probes to place when neither counts nor spacing are given")] = 2048
    margin: Annotated[
        float, Interval(ge=0, le=4),
        Doc("how far the grid reaches beyond the box on each side, in spacings; just under a half keeps "
            "planes of probes out of axis-aligned walls and the walls themselves inside the grid"),
    ] = 0.45
    memory_limit: Annotated[float, Ge(1), Doc("most memory the field may need [MB]")] = 4096.0


@dataclass
class ProbeGrid:
    """One regular grid of P = nx ny nz probes."""

    counts: tuple[int, int, int]
    origin: mi.Point3f    # (1,) position of probe 0 [m]
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
        nx, ny, _ = self.counts
        row = probe // nx
        plane = row // ny
        cell = mi.Vector3f(mi.Float(probe - row * nx), mi.Float(row - plane * ny), mi.Float(plane))
        return dr.fma(cell, self.spacing, self.origin)


def fit(box: Box, s: Settings) -> ProbeGrid:
    """Lay a grid over a box, after the settings.

    Args:
        box: The scene's box of interest [m]; `s.box` overrides it.
        s: Counts win over spacing, spacing over the budget. The grid is centred on the box and
            reaches `margin` spacings beyond it.

    Raises:
        SettingsError: The box is empty or not finite, or counts are below 2.
    """
    low, high = s.box or box
    extent = [h - l for l, h in zip(low, high, strict=True)]
    if not all(map(math.isfinite, (*low, *high))) or min(extent) < 0 or max(extent) <= 0:
        raise SettingsError(f"volume.box must be finite and have its low corner below the high one: {low} {high}")
    counts, spacing = _lay_out(extent, s)
    middle = [(l + h) / 2 for l, h in zip(low, high, strict=True)]
    origin = [m - d * (n - 1) / 2 for m, d, n in zip(middle, spacing, counts, strict=True)]
    return ProbeGrid(counts, dr.opaque(mi.Point3f, origin), dr.opaque(mi.Vector3f, spacing))


def _lay_out(extent: list[float], s: Settings) -> tuple[tuple[int, int, int], list[float]]:
    """Counts and spacing of a grid over a box of this extent."""
    if s.counts is not None:
        if min(s.counts) < 2:
            raise SettingsError(f"volume.counts must be 2 or more along each axis: {s.counts}")
        # (n - 1) spacings cover the extent and a margin on both sides.
        smallest = max(extent) * 1e-3
        spacing = [
            s.spacing or max(e, smallest) / max(n - 1 - 2 * s.margin, 0.5)
            for e, n in zip(extent, s.counts, strict=True)
        ]
        return s.counts, spacing
    step = s.spacing or _spacing_for(extent, s)
    counts = _counts_for(extent, step, s.margin)
    if s.spacing is not None:
        return counts, [step] * 3
    # The budget fixes the counts; shrink each axis a little so that its margin is exact. A flat
    # axis keeps the step: its two planes then stand one step apart.
    exact = [e / max(n - 1 - 2 * s.margin, 0.5) for e, n in zip(extent, counts, strict=True)]
    return counts, [d if d > step / 2 else step for d in exact]


def _counts_for(extent: list[float], step: float, margin: float) -> tuple[int, int, int]:
    needed = (max(2, math.ceil(e / step + 2 * margin - 1e-6) + 1) for e in extent)
    return tuple(needed)  # type: ignore[return-value]


def _spacing_for(extent: list[float], s: Settings) -> float:
    """Smallest cubic spacing whose grid stays within the budget (bisection)."""
    low, high = max(extent) * 1e-4, max(extent) * 2
    for _ in range(60):
        middle = math.sqrt(low * high)
        if math.prod(_counts_for(extent, middle, s.margin)) > s.budget:
            low = middle
        else:
            high = middle
    return high
