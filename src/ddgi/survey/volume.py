"""The volume that a field would have: where its probes stand, and what they cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddgi.box import Box, Point
from ddgi.probes.field import IrradianceField
from ddgi.probes.volume import bytes_per_probe
from ddgi.scene.scene import Scene
from ddgi.settings import RenderSettings


@dataclass(frozen=True)
class Volume:
    """One grid of probes."""

    source: str  # of its box: "settings", "scene", "cameras", or "bounds" where those see nothing
    counts: tuple[int, int, int]
    spacing: Point  # [m]
    box: Box  # first and last probe, in the coordinates of the scene's file [m]
    probes: int
    moved: int  # of them, from their places to where surfaces see them
    awake: int  # of them, those that see something they could light, and are updated
    bytes_per_probe: int  # both maps (MFF eq. 4.1)
    bytes: int  # of all maps

    def outside(self, position: np.ndarray, reach: float = 0.0) -> np.ndarray:
        """Whether things lie outside the box, by more than a cell.

        Args:
            position: (..., 3) middles of them [m].
            reach: How far they reach from there [m].
        """
        low, high = np.array(self.box)
        beyond = np.array(self.spacing) + reach
        return ((position < low - beyond) | (position > high + beyond)).any(-1)


def fitted(scene: Scene, settings: RenderSettings, blind: bool) -> Volume:
    """The volume of `IrradianceField.fit`.

    Args:
        scene: What to light.
        settings: Of `grid`, `relocation`, `states` and `volume`.
        blind: Whether its cameras see nothing that light could come from.

    Raises:
        SettingsError: It is impossible, lies outside the scene or is too large.
    """
    vol = IrradianceField.fit(scene, settings).volumes[0]
    grid = vol.grid
    first, spacing = np.ravel(grid.origin) + np.array(scene.origin), np.ravel(grid.spacing).astype(float)
    last = first + spacing * (np.array(grid.counts) - 1)
    each = bytes_per_probe(settings.volume)
    return Volume(
        source=_source(scene, settings, blind),
        counts=grid.counts,
        spacing=_point(spacing),
        box=(_point(first), _point(last)),
        probes=grid.size,
        moved=int((grid.offsets() != 0).any(-1).sum()),
        awake=vol.awake_count,
        bytes_per_probe=each,
        bytes=each * grid.size,
    )


def _source(scene: Scene, settings: RenderSettings, blind: bool) -> str:
    """Whose box it is, in the order of `IrradianceField.fit`."""
    if settings.grid.box:
        return "settings"
    if scene.box:
        return "scene"
    return "bounds" if blind else "cameras"


def _point(values: np.ndarray) -> Point:
    x, y, z = values.tolist()
    return x, y, z
