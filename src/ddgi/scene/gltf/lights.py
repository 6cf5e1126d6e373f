"""KHR_lights_punctual to Mitsuba's point, spot and directional emitters.

Candela are taken as W/sr and lux as W/m^2, channel by channel: no photometric factor, on both sides
of every comparison. A light looks along its node's -z; its node's scale does not count. A spot falls
off between its angles as Mitsuba's does.
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf.nodes import Placed
from ddgi.scene.gltf.schema import Light
from ddgi.scene.notes import Notes

WIDEST = np.pi / 2


def emitter(light: Light, placed: Placed, notes: Notes) -> dict[str, Any]:
    """The light that stands at a node.

    Raises:
        SceneError: It has no direction, or its cone is not one.
    """
    power = {"type": "rgb", "value": [float(light.intensity * c) for c in light.color]}
    position = [float(x) for x in placed.world[:3, 3]]
    if light.range is not None:
        notes.add("the range of a light is left out: its light falls off with the square of the distance")
    if light.type == "point":
        return {"type": "point", "position": position, "intensity": power}
    direction = facing(placed, f'light "{light.name or placed.name}"')
    if light.type == "directional":
        return {"type": "directional", "direction": direction.tolist(), "irradiance": power}
    inner, outer = light.spot.inner_cone_angle, light.spot.outer_cone_angle
    if not inner < outer <= WIDEST + 1e-6:
        raise SceneError(
            f'light "{light.name or placed.name}": its cone must have inner < outer <= pi / 2, '
            f"not {inner:g} and {outer:g}"
        )
    return {
        "type": "spot",
        "to_world": mi.ScalarTransform4f(_towards(direction, placed.world[:3, 3]).tolist()),
        "intensity": power,
        "cutoff_angle": float(np.degrees(min(outer, WIDEST))),
        "beam_width": float(np.degrees(inner)),
    }


def facing(placed: Placed, label: str) -> np.ndarray:
    """(3,) unit vector along a node's -z, where lights and cameras look.

    Raises:
        SceneError: The node is flattened along it.
    """
    direction = -placed.world[:3, 2]
    length = np.linalg.norm(direction)
    if not length > 0:
        raise SceneError(f"{label}: its node is scaled to nothing, so it looks nowhere")
    return direction / length


def _towards(direction: np.ndarray, position: np.ndarray) -> np.ndarray:
    """(4, 4) that turns +z into a direction."""
    aside = np.zeros(3)
    aside[int(np.abs(direction).argmin())] = 1.0
    across = np.cross(aside, direction)
    across /= np.linalg.norm(across)
    matrix = np.eye(4)
    matrix[:3] = np.stack([across, np.cross(direction, across), direction, position], 1)
    return matrix
