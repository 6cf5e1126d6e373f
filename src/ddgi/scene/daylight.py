"""Lights that the caller adds to a scene: a sun, a sky, an environment picture, lamps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.errors import SceneError

DEFAULT_SUN = (35.0, 50.0)
"""(azimuth, elevation) of the sun in scenes that have no light [degrees]."""
LAMPS = ("point", "spot", "directional")


@dataclass(frozen=True)
class AddedLights:
    """What to add. See `load_scene` for meaning and units."""

    sun: tuple[float, float, float] | None = None
    sky: str | Sequence[float] | None = None
    env: str | Path | None = None
    lights: Sequence[dict[str, Any]] = ()

    def __bool__(self) -> bool:
        return self.sun is not None or self.has_environment or bool(self.lights)

    @property
    def has_environment(self) -> bool:
        """Whether an environment is among them, which takes the place of the scene's own."""
        return self.sky is not None or self.env is not None

    def description(self, up: np.ndarray) -> dict[str, Any]:
        """As plugins of a Mitsuba scene dictionary.

        Args:
            up: (3,) the scene's up, unit length.

        Raises:
            SceneError: A value makes no sense; says which.
        """
        if self.sky is not None and self.env is not None:
            raise SceneError("a scene has one environment: give sky or env, not both")
        added: dict[str, Any] = {}
        if self.sun is not None:
            added["added-sun"] = _sun(self.sun, up)
        if self.sky is not None:
            added["added-sky"] = _sky(self.sky, self.sun, up)
        if self.env is not None:
            added["added-environment"] = _environment(Path(self.env), up)
        for number, lamp in enumerate(self.lights):
            if not isinstance(lamp, dict) or lamp.get("type") not in LAMPS:
                raise SceneError(f"lights[{number}]: must be a dictionary of type {', '.join(LAMPS)}")
            added[f"added-light-{number}"] = lamp
        return added


def default_daylight() -> AddedLights:
    """Sky and sun for a scene without any light."""
    return AddedLights(sky="sunsky")


def horizontal_axes(up: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(north, east): azimuth runs from north to east.

    North is the axis after the one nearest up (x, y, z, x), made horizontal: +z where +y is up, and
    then east is +x.
    """
    north = np.zeros(3)
    north[(int(np.abs(up).argmax()) + 1) % 3] = 1.0
    north -= up * (north @ up)
    north /= np.linalg.norm(north)
    return north, np.cross(up, north)


def towards(azimuth: float, elevation: float, up: np.ndarray) -> np.ndarray:
    """(3,) unit vector towards a point of the sky given in degrees."""
    north, east = horizontal_axes(up)
    a, e = np.radians(azimuth), np.radians(elevation)
    return np.cos(e) * (np.cos(a) * north + np.sin(a) * east) + np.sin(e) * up


def _sun(sun: tuple[float, float, float], up: np.ndarray) -> dict[str, Any]:
    if len(sun) != 3 or not np.isfinite(sun).all() or sun[2] < 0:
        raise SceneError(f"sun must be azimuth, elevation and an intensity of 0 or more, not {sun}")
    direction = -towards(sun[0], sun[1], up)
    return {
        "type": "directional",
        "direction": [float(x) for x in direction],
        "irradiance": {"type": "rgb", "value": [float(sun[2])] * 3},
    }


def _sky(
    sky: str | Sequence[float], sun: tuple[float, float, float] | None, up: np.ndarray
) -> dict[str, Any]:
    if not isinstance(sky, str):
        color = np.asarray(sky, np.float64)
        if color.shape != (3,) or not np.isfinite(color).all() or (color < 0).any():
            raise SceneError(f"sky must be 'sunsky' or three numbers of 0 or more, not {sky}")
        return {"type": "constant", "radiance": {"type": "rgb", "value": color.tolist()}}
    if sky != "sunsky":
        raise SceneError(f"sky must be 'sunsky' or three numbers, not {sky!r}")
    direction = towards(*(DEFAULT_SUN if sun is None else sun[:2]), up)
    north, east = horizontal_axes(up)
    return {
        "type": "sunsky",
        "sun_direction": [float(x) for x in direction],
        "sun_scale": 1.0 if sun is None else 0.0,
        "to_world": _frame(north, east, up),  # the model's own up is z
    }


def _environment(path: Path, up: np.ndarray) -> dict[str, Any]:
    if path.is_dir():
        raise SceneError(f"environment picture: {path} is a folder")
    if not path.is_file():
        raise SceneError(f"environment picture not found: {path}")
    if path.suffix.lower() not in (".hdr", ".exr"):
        raise SceneError(f"an environment picture must be .hdr or .exr, not {path.name}")
    north, east = horizontal_axes(up)
    try:
        mi.Bitmap(str(path))
    except Exception as error:
        raise SceneError(
            f"environment picture {path}: damaged, or not an .hdr or .exr picture in spite of its name"
        ) from error
    return {"type": "envmap", "filename": str(path.resolve()), "to_world": _frame(east, up, north)}


def _frame(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> mi.ScalarTransform4f:
    """The rotation that carries the axes to x, y and z."""
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = x, y, z
    return mi.ScalarTransform4f(matrix)
