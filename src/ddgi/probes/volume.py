"""One probe volume: a grid and the octahedral maps of each of its probes: two, or with radiance three."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal

import drjit as dr
import mitsuba as mi
import numpy as np
from annotated_types import Gt, Interval
from typing_extensions import Doc

from ddgi.errors import SettingsError
from ddgi.own_memory import own_numbers
from ddgi.probes import formats
from ddgi.probes.awake import SLEEPING, Awake, States
from ddgi.probes.change import Change
from ddgi.probes.grid import ProbeGrid
from ddgi.probes.haste import Haste
from ddgi.probes.texel_fit import TexelFit, texel_fit
from ddgi.settings_group import settings_group

IrradianceFormat = Literal["float32", "float16", "rgbe8", "r11g11b10"]
DistanceFormat = Literal["float32", "float16", "unorm8"]


@settings_group("volume")
class Settings:
    """What a probe stores."""

    irradiance_size: Annotated[
        int, Interval(ge=2, le=64), Doc("interior texels per side of the irradiance map (SCALE 3)")
    ] = 12
    distance_size: Annotated[
        int, Interval(ge=2, le=64), Doc("interior texels per side of the distance map (SCALE 3)")
    ] = 16
    radiance_size: Annotated[
        Literal[0, 4, 8, 16, 32],
        Doc("interior texels per side of the radiance map, which contact needs; 0: there is none"),
    ] = 8
    irradiance_format: Annotated[
        IrradianceFormat, Doc("texel format of the irradiance map, and of the radiance map")
    ] = "float32"
    distance_format: Annotated[DistanceFormat, Doc("texel format of the distance map")] = "float32"
    longest_distance: Annotated[
        float,
        Gt(0),
        Doc(
            "distances that matter end here, in cell diagonals: one, and half of another that a moved probe may add (MFF 3.3.2)"
        ),
    ] = 1.5


@dataclass
class ProbeVolume:
    """State of one grid of P probes. Maps are flat: probe by probe, row by row, border included."""

    grid: ProbeGrid
    awake: Awake  # the probes that the next update is for
    irradiance: Any  # P (ni + 2)^2 texels of `irradiance_format`: the value that the query interpolates
    distance: Any  # P (nd + 2)^2 texels of `distance_format`: mean, mean square, in `reach` units
    radiance: Any  # P (nr + 2)^2 texels of `irradiance_format`; None if there is no such map
    age: mi.UInt32  # (P,) updates since the maps of a probe were empty
    texel_fit: TexelFit  # of irradiance maps
    made_for: str | None = None  # the settings that the maps were allocated for, written out; None: not known
    sight: mi.UInt32 | None = (
        None  # (cells,) which probes of a cell see one another (`sight.py`); None: not known
    )
    states: States | None = None  # what the probes are doing; None: all are updated
    haste: Haste = field(default_factory=Haste.none)  # after scene events
    change: Change = field(default_factory=Change.unknown)  # what is known of how light scatters
    exponent: float | None = None  # the irradiance map holds S to this power (`query.lookup_exponent`)

    @property
    def awake_count(self) -> int:
        """Number of probes that are neither asleep nor off."""
        return self.grid.size if self.states is None else int((np.array(self.states.code) > SLEEPING).sum())

    def renewed(self, which: np.ndarray, warm_up: int) -> ProbeVolume:
        """The volume of which some probes keep nothing of what they have at their next update (SCALE 6.3).

        which: (P,) bool. warm_up: Updates before means begin (`blend.warm_up`): that is where they start.
        """
        age = np.array(self.age).astype(int)
        start = min(age.max(), max(warm_up - 1, 0))
        change = self.change.renewed(which, start)
        return replace(self, age=own_numbers(np.where(which, start, age)), change=change)

    def reach(self, s: Settings) -> mi.Float:
        """The longest distance kept [m], (1,): the unit of the distance map."""
        return self.grid.diagonal * s.longest_distance


def bytes_per_probe(s: Settings) -> int:
    """Persistent bytes of one probe: its maps with their borders (MFF eq. 4.1)."""
    colours = (s.irradiance_size + 2) ** 2 + ((s.radiance_size + 2) ** 2 if s.radiance_size else 0)
    return (
        colours * formats.IRRADIANCE[s.irradiance_format].bytes
        + (s.distance_size + 2) ** 2 * formats.DISTANCE[s.distance_format].bytes
    )


def allocate(layout: ProbeGrid, s: Settings, rays_per_probe: int, budget_mb: float) -> ProbeVolume:
    """An empty volume over a grid.

    Raises:
        SettingsError: Maps and the rays of one update need more memory than the budget.
    """
    # A ray carries radiance, distance moments, its origin and hit while it is shaded: about 100 bytes.
    need = layout.size * (bytes_per_probe(s) * 2 + rays_per_probe * 100) / 1e6
    if need > budget_mb:
        raise SettingsError(
            f"a volume of {'x'.join(map(str, layout.counts))} probes needs about {need:{',.0f' if need < 1e9 else '.2g'}} MB, the budget is "
            f"{budget_mb:,.0f} MB: use fewer probes (grid.counts, grid.spacing) or raise grid.memory_limit"
        )
    if (
        layout.size * (max(s.distance_size, s.radiance_size) + 2) ** 2 >= 2**30
        or layout.size * rays_per_probe >= 2**31
    ):
        raise SettingsError(
            f"a volume of {layout.size:,} probes has more texels or rays than 32-bit numbers reach"
        )
    maps = lambda fmt, size: formats.allocate(fmt, layout.size * (size + 2) ** 2)  # noqa: E731
    colour = formats.IRRADIANCE[s.irradiance_format]
    return ProbeVolume(
        layout,
        Awake(layout.size),
        maps(colour, s.irradiance_size),
        maps(formats.DISTANCE[s.distance_format], s.distance_size),
        maps(colour, s.radiance_size) if s.radiance_size else None,
        dr.opaque(mi.UInt32, 0, layout.size),
        texel_fit(s.irradiance_size),
        made_for=repr(s),
        change=Change.none(layout.size),
    )
