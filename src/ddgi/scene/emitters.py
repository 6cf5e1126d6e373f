"""Mitsuba emitters to lights: delta lights as table rows, area lights and environment as themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.errors import SceneError
from ddgi.lighting.environment_map import EnvironmentMap, environment_map
from ddgi.lighting.lights import DIRECTIONAL, POINT, SPOT, DeltaLights, Lights
from ddgi.luminance import LUMINANCE
from ddgi.own_memory import own
from ddgi.scene import sky
from ddgi.scene.notes import Notes
from ddgi.scene.plugin_parts import parts
from ddgi.scene.plugin_tree import PluginTree
from ddgi.scene.textures import TextureReader, Value
from ddgi.scene.validate import check_finite, check_light


@dataclass(frozen=True)
class DeltaLight:
    """One point, spot or directional light. Units as in `DeltaLights`."""

    name: str
    kind: int
    intensity: np.ndarray
    position: np.ndarray
    direction: np.ndarray
    cone: tuple[float, float] = (np.pi, 1.0)
    node: int | None = None  # of the plugin that it was read from


ENVIRONMENTS = ("ConstantBackgroundEmitter", "EnvironmentMapEmitter", "SunskyEmitter", "TimedSunskyEmitter")
KINDS = {"PointLight": "point", "SpotLight": "spot", "DirectionalEmitter": "directional"}
ORIGIN, DOWN = np.zeros(3), np.array([0.0, -1.0, 0.0])
RINGING_SHARE = 0.01
"""Of an environment picture's values: more negative ones than this are no undershoot but a mistake."""
BRIGHT_PART, BRIGHT_SHARE = 1e-3, 0.3
"""A thousandth of all directions, which 128 rays meet once in eight updates, and the share of the light from there
that is too much to be left to them."""
NARROWEST_RIM = 1e-4
"""Of a spot whose beam is as wide as its cone [rad]: sharp, yet its slope is finite."""


class EmitterReader:
    """Collects a scene's emitters that are not surfaces."""

    def __init__(self, tree: PluginTree, textures: TextureReader, notes: Notes) -> None:
        self._tree = tree
        self._textures = textures
        self._notes = notes
        self.delta: list[DeltaLight] = []
        self.environment: mi.Emitter | None = None
        self.environment_name = ""

    def add(self, emitter: mi.Emitter) -> None:
        """Take one emitter in.

        Raises:
            SceneError: Its light is negative, NaN or infinite; or it is a second environment.
        """
        kind = emitter.class_name()
        readers = {
            "PointLight": self._point,
            "SpotLight": self._spot,
            "DirectionalEmitter": self._directional,
        }
        if kind in readers:
            self.delta.append(replace(readers[kind](emitter), node=self._tree.node_of(emitter)))
        elif kind in ENVIRONMENTS:
            self._set_environment(emitter)
        else:
            self._notes.add(f"{self._tree.label_of(emitter)}: not a light this package has, left out")

    def emission(self, shape: mi.Shape) -> Value:
        """What an area light's surface emits [W/(m^2 sr)].

        Raises:
            SceneError: It is negative, NaN or infinite.
        """
        radiance = parts(shape.emitter())["radiance"]
        return self._textures.read(radiance, shape, owner=f"{self._tree.label_of(shape)}: radiance")

    def _color(self, emitter: mi.Emitter, name: str) -> np.ndarray:
        color = self._textures.read(parts(emitter)[name], owner=f"{self._tree.label_of(emitter)}: {name}")
        return np.asarray(color)

    def _point(self, emitter: mi.Emitter) -> DeltaLight:
        position = np.array(mi.traverse(emitter)["position"]).ravel()
        return DeltaLight(_name(emitter), POINT, self._color(emitter, "intensity"), position, DOWN)

    def _spot(self, emitter: mi.Emitter) -> DeltaLight:
        if parts(emitter)["texture"].is_spatially_varying():
            self._notes.add(f"{self._tree.label_of(emitter)}: its texture is left out")
        matrix = _to_world(emitter)
        parameters = mi.traverse(emitter)
        cutoff, beam = (np.radians(float(parameters[k][0])) for k in ("cutoff_angle", "beam_width"))
        cone = (cutoff, 1 / max(cutoff - beam, NARROWEST_RIM))
        intensity, direction = self._color(emitter, "intensity"), _unit(matrix[:3, 2])
        return DeltaLight(_name(emitter), SPOT, intensity, matrix[:3, 3], direction, cone)

    def _directional(self, emitter: mi.Emitter) -> DeltaLight:
        direction = _unit(_to_world(emitter)[:3, 2])
        return DeltaLight(_name(emitter), DIRECTIONAL, self._color(emitter, "irradiance"), ORIGIN, direction)

    def _set_environment(self, emitter: mi.Emitter) -> None:
        if self.environment is not None:
            raise SceneError(f"{self._tree.label_of(emitter)}: the scene has another environment already")
        label, kind, name = self._tree.label_of(emitter), emitter.class_name(), _name(emitter)
        if kind == "ConstantBackgroundEmitter":
            self._color(emitter, "radiance")
        elif kind == "EnvironmentMapEmitter":
            check_light(np.array(mi.traverse(emitter)["scale"]), f"{label}: scale")
            self._remove_ringing(emitter, label)
            if _bright_share(mi.traverse(emitter)["data"].numpy()) > BRIGHT_SHARE:
                self._notes.add(
                    f"{label}: small lamps shine in it, which few of the probes' rays meet; direct.environment=sampled finds them"
                )
        elif kind == "SunskyEmitter":
            direction, irradiance = sky.sun(emitter)
            check_light(irradiance, f"{label}: the sun")
            if irradiance.any():
                self.delta.append(DeltaLight(f"{name}-sun", DIRECTIONAL, irradiance, ORIGIN, direction))
            emitter = sky.bake_sky(emitter)
            check_light(mi.traverse(emitter)["data"].numpy(), f"{label}: the sky")
        else:
            self._notes.add(f"{label}: baked as it is, sun included")
            emitter = sky.bake(emitter)
        self.environment, self.environment_name = emitter, name

    def _remove_ringing(self, emitter: mi.Emitter, label: str) -> None:
        """Check a picture's texels; make the few negative ones black, here and in the parsed scene.

        Pictures resampled with a sharp filter undershoot beside the sun: 0.01 to 0.5 % of the
        values of ordinary ones are below zero.
        """
        parameters = mi.traverse(emitter)
        texels = parameters["data"].numpy()
        share = float((texels < 0).mean())
        check_finite(texels, f"{label}: a texel")
        if share == 0:
            return
        if share > RINGING_SHARE:
            check_light(texels, f"{label}: a texel")
        self._notes.add(f"{label}: its negative texels ({100 * share:.2g} %) count as black")
        parameters["data"] = mi.TensorXf(np.maximum(texels, 0))
        parameters.update()
        properties = self._tree.properties_of(emitter)
        if properties is not None:  # the reference renders what we render
            picture = properties["bitmap"] if "bitmap" in properties else mi.Bitmap(properties["filename"])
            linear = picture.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
            properties["bitmap"] = mi.Bitmap(np.maximum(np.array(linear), 0))
            if "filename" in properties:
                del properties["filename"]


def make_lights(
    delta: Sequence[DeltaLight], area: Sequence[mi.Emitter], environment: mi.Emitter | None
) -> Lights:
    """The tables that light is gathered from."""

    def columns(rows: list, width: int) -> mi.Float:
        table = np.zeros((max(len(rows), 1), width), np.float32)  # frozen kernels take no empty arrays
        for line, row in zip(table, rows, strict=False):
            line[: len(row)] = row
        return own(table)

    pointers = None
    if area:
        numbers = [dr.reinterpret_array(mi.UInt32, mi.EmitterPtr(emitter))[0] for emitter in area]
        pointers = dr.reinterpret_array(mi.EmitterPtr, mi.UInt32(numbers))
    return Lights(
        delta=DeltaLights(
            count=len(delta),
            kind=mi.UInt32([light.kind for light in delta] or [POINT]),
            position=columns([light.position for light in delta], 4),
            direction=columns([light.direction for light in delta], 4),
            intensity=columns([light.intensity for light in delta], 4),
            cone=columns([light.cone for light in delta], 2),
        ),
        area=pointers,
        area_count=len(area),
        area_bounds=columns([_bounding_sphere(emitter) for emitter in area], 4),
        area_power=columns([[_power(emitter)] for emitter in area], 1),
        area_share=columns([[1.0] for _ in area], 1),
        environment=environment,
        environment_map=_map(environment),
        environment_share=own(np.ones(1)),
    )


def _map(environment: mi.Emitter | None) -> EnvironmentMap | None:
    """What an `envmap` shows."""
    if environment is None or environment.class_name() != "EnvironmentMapEmitter":
        return None
    parameters = mi.traverse(environment)
    # A column of the other end stands on either side; there may be a fourth channel.
    texels = parameters["data"].numpy()[:, 1:-1, :3] * float(np.ravel(parameters["scale"])[0])
    return environment_map(environment, texels)


def _bright_share(texels: np.ndarray) -> float:
    """Share of the light of a picture of all directions that comes from the brightest `BRIGHT_PART` of them."""
    light = np.maximum(texels[..., :3] @ LUMINANCE, 0)
    size = np.sin((np.arange(light.shape[0]) + 0.5) / light.shape[0] * np.pi)[:, None] + 0 * light
    order = np.argsort(-light, axis=None)
    covered = np.cumsum(size.ravel()[order]) / size.sum()
    power = np.cumsum((light * size).ravel()[order])
    return float(power[np.searchsorted(covered, BRIGHT_PART)] / max(power[-1], 1e-30))


def _bounding_sphere(emitter: mi.Emitter) -> np.ndarray:
    """Centre and radius of a sphere around an area light [m]. (4,)."""
    box = emitter.get_shape().bbox()
    low, high = np.array(box.min).ravel(), np.array(box.max).ravel()
    return np.append((low + high) / 2, np.linalg.norm(high - low) / 2)


def _power(emitter: mi.Emitter) -> float:
    """Mean emitted luminance times area [W/sr]; never zero, so that the light can be picked."""
    mean = float(np.mean(np.array(parts(emitter)["radiance"].mean())))
    return max(mean * float(np.ravel(emitter.get_shape().surface_area())[0]), 1e-12)


def _name(emitter: mi.Emitter) -> str:
    """The emitter's id, else what it is."""
    return emitter.id() or KINDS.get(emitter.class_name(), "environment")


def _to_world(emitter: mi.Emitter) -> np.ndarray:
    return np.array(mi.traverse(emitter)["to_world"].matrix, np.float64).reshape(4, 4)


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)
