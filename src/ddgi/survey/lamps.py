"""The lights of a scene: where they are, and whether they shine."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.box import Point
from ddgi.lighting.lights import Lights, environment_light
from ddgi.scene.named_lights import NamedLight
from ddgi.scene.scene import Scene
from ddgi.survey.volume import Volume

DIRECTIONS = 1024
"""In which to look for some light of an environment."""


@dataclass(frozen=True)
class Lamp:
    """One light."""

    name: str
    kind: str  # "point", "spot", "directional", "area" or "environment"
    shines: bool
    position: Point | None  # [m], of area lights the middle; None for those at infinity
    outside: bool  # wholly, more than a cell outside the volume


def lamps(scene: Scene, volume: Volume) -> tuple[Lamp, ...]:
    """All lights, in the order of `scene.named_lights`."""
    return tuple(_lamp(scene, volume, light) for light in scene.named_lights)


def _lamp(scene: Scene, volume: Volume, light: NamedLight) -> Lamp:
    output, middle, radius = _numbers(scene, light)
    position, outside = None, False
    if middle is not None:
        x, y, z = middle.tolist()
        position, outside = (x, y, z), bool(volume.outside(middle, radius))
    return Lamp(light.name, light.kind, bool(output > 0), position, outside)


def _numbers(scene: Scene, light: NamedLight) -> tuple[float, np.ndarray | None, float]:
    """Its brightest number, its middle if it has a place, and the radius around that."""
    row, tables = light.row, scene.lights
    if light.kind == "environment":
        return _brightest(tables), None, 0.0
    if light.kind == "area":
        glow = np.array(scene.materials.emission).reshape(-1, 4)[light.material]
        sphere = np.array(tables.area_bounds, np.float64).reshape(-1, 4)[row]
        return glow[:3].max() * glow[3], sphere[:3], sphere[3]
    output = np.array(tables.delta.intensity).reshape(-1, 4)[row, :3].max()
    if light.kind == "directional":
        return output, None, 0.0
    return output, np.array(tables.delta.position, np.float64).reshape(-1, 4)[row, :3], 0.0


def _brightest(lights: Lights) -> float:
    """Of an environment, where it picks directions to light from: a small sun is found as well."""
    number = dr.arange(mi.UInt32, DIRECTIONS)
    square = mi.Point2f(mi.radical_inverse_2(number, 0), (mi.Float(number) + 0.5) / DIRECTIONS)
    here = dr.zeros(mi.Point3f, DIRECTIONS)
    return float(np.array(environment_light(lights, here, square, mi.Bool(True)).power).max())
