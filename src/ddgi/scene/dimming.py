"""Lights turned down: the same tables with other numbers in them.

Geometry and emitters stay as they are and every array keeps its size, so nothing is recorded anew.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import mitsuba as mi
import numpy as np

from ddgi.errors import SceneError
from ddgi.lighting.lights import Lights
from ddgi.own_memory import own
from ddgi.scene.named_lights import NamedLight
from ddgi.trace.materials import Materials


def dim(
    lights: Lights, materials: Materials, chosen: Sequence[NamedLight], share: float
) -> tuple[Lights, Materials]:
    """The tables with the output of some lights multiplied.

    Args:
        lights: All lights of the scene.
        materials: The material table, which says what surfaces emit towards rays that meet them.
        chosen: Which lights.
        share: What to multiply their output with, 0 or more; 0 switches them off.

    Raises:
        SceneError: `share` is negative or not a number.
    """
    if not 0 <= share < np.inf:  # refuses what is not a number too
        raise SceneError(f"the share of its output that a light keeps must be 0 or more, not {share!r}")
    delta = [light.row for light in chosen if light.kind not in ("area", "environment")]
    area = [light.row for light in chosen if light.kind == "area"]
    rows = [light.material for light in chosen if light.kind == "area"]
    environment = [light.row for light in chosen if light.kind == "environment"]
    lights = replace(
        lights,
        delta=replace(lights.delta, intensity=_scaled(lights.delta.intensity, delta, 4, share)),
        area_power=_scaled(lights.area_power, area, 1, share),
        area_share=_scaled(lights.area_share, area, 1, share),
        environment_share=_scaled(lights.environment_share, environment, 1, share),
    )
    emission = np.array(materials.emission).reshape(-1, 4)
    emission[rows, 3] *= share
    return lights, replace(materials, emission=own(emission))


def _scaled(table: mi.Float, rows: Sequence[int], width: int, share: float) -> mi.Float:
    """The table with some of its rows multiplied."""
    values = np.array(table).reshape(-1, width)
    values[list(rows)] *= share
    return own(values)
