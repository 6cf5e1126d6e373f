"""The lights of a scene by name, and where the numbers of each are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from ddgi.errors import SceneError
from ddgi.lighting.lights import DIRECTIONAL, POINT, SPOT
from ddgi.scene.shapes import shape_number
from ddgi.scene.unique_names import UniqueNames

if TYPE_CHECKING:
    from ddgi.scene.emitters import EmitterReader
    from ddgi.scene.shapes import Geometry

Kind = Literal["point", "spot", "directional", "area", "environment"]
DELTA: dict[int, Kind] = {POINT: "point", SPOT: "spot", DIRECTIONAL: "directional"}


@dataclass(frozen=True)
class NamedLight:
    """What a light is called, and where its numbers are."""

    name: str
    kind: Kind
    row: int = 0  # of `DeltaLights`, or of the area lights; there is one environment
    material: int = 0  # of an area light: row of the material table


def name_lights(emitters: EmitterReader, geometry: Geometry) -> tuple[NamedLight, ...]:
    """All lights, in the order of their tables; an area light is called as its shape."""
    shape_names = {row: name for name, row in geometry.names.items()}
    lights = [NamedLight(light.name, DELTA[light.kind], row) for row, light in enumerate(emitters.delta)]
    for row, emitter in enumerate(geometry.area_lights):
        material = shape_number(emitter.get_shape())
        lights.append(NamedLight(shape_names.get(material, "area"), "area", row, material))
    if emitters.environment is not None:
        lights.append(NamedLight(emitters.environment_name, "environment"))
    return _unique(lights)


def find_light(lights: Sequence[NamedLight], wanted: str | int) -> NamedLight:
    """A light by its name, or by its number in the list.

    Raises:
        SceneError: There is no such light; the message lists those there are.
    """
    names = [light.name for light in lights]
    if wanted in names:
        return lights[names.index(str(wanted))]
    if str(wanted).isdecimal() and int(wanted) < len(lights):
        return lights[int(wanted)]
    there_are = ", ".join(f"{light.name} ({light.kind})" for light in lights) or "none"
    raise SceneError(f"no light {wanted!r}: there are {there_are}")


def _unique(lights: Sequence[NamedLight]) -> tuple[NamedLight, ...]:
    """The same lights, those of one name numbered."""
    names = UniqueNames()
    return tuple(replace(light, name=names.unique(light.name)) for light in lights)
