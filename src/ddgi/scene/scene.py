"""A scene: what there is, as arrays that a tracer and a gatherer can use."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import count
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.box import Box, Point, moved
from ddgi.errors import SceneError
from ddgi.lighting.lights import Lights
from ddgi.scene.camera import Camera
from ddgi.scene.dimming import dim
from ddgi.scene.named_lights import NamedLight, find_light
from ddgi.scene.rig import Rig
from ddgi.trace.materials import Materials
from ddgi.trace.mesh import MeshTracer


@dataclass
class Scene:
    """Geometry, materials, lights and cameras, ready to trace.

    Built by `load_scene` from a file, a Mitsuba dictionary or the name of a built-in scene.

    Cameras, `box` and `bounds` are in the coordinates of the file, as boxes in the settings are. What is
    traced (`mi_scene`, `lights`, `source`, and the field) counts from `origin`, which is another place
    than the file's own only where a scene lies far from that (`ddgi.scene.recentre`).
    """

    name: str
    mi_scene: (
        mi.Scene
    )  # the static geometry, area lights and environment; its BSDFs are ignored, other lights not in it
    materials: Materials
    lights: Lights
    cameras: tuple[Camera, ...]  # at least one, but while it is being loaded
    up: tuple[float, float, float]  # unit vector
    box: Box | None  # (low, high) of what probes should cover, if its maker says [m]
    triangles: int
    shapes: dict[str, int] = field(default_factory=dict)  # shape name -> row of the material table
    named_lights: tuple[NamedLight, ...] = ()  # all that shine: delta lights, area lights, environment
    notes: tuple[str, ...] = ()  # what the import changed or left out, one line each
    rig: Rig | None = None  # what of a glTF file can move; None for others
    parsed: Any = None  # Mitsuba's parsed scene, all materials and lights in it; never built itself: `source`
    origin: Point = (0.0, 0.0, 0.0)  # what is traced counts from here: a place in the file's coordinates [m]

    serial: int = field(default_factory=count(1).__next__)  # of what was loaded; kept by copies that share it

    def __repr__(self) -> str:
        cameras = ", ".join(c.name for c in self.cameras)
        return f"Scene({self.name!r}, {self.triangles:,} triangles, cameras: {cameras})"

    @property
    def bounds(self) -> Box:
        """(low, high) corner of the box around all geometry and the box of interest [m]."""
        low, high = np.array(moved(self._traced_bounds, self.origin))
        if self.box is not None:
            low, high = np.minimum(low, self.box[0]), np.maximum(high, self.box[1])
        return tuple(low.tolist()), tuple(high.tolist())

    @cached_property
    def _traced_bounds(self) -> Box:
        """The box around all geometry, from `origin`."""
        bounds = self.mi_scene.bbox()
        (a, b, c), (d, e, f) = np.ravel(bounds.min).tolist(), np.ravel(bounds.max).tolist()
        return (a, b, c), (d, e, f)

    @property
    def source(self) -> Any:
        """Mitsuba's parsed scene, to build with `mi.parser.instantiate`; None if there is none.

        A copy, as building empties it: what it referred to is replaced by what was built.
        """
        return None if self.parsed is None else mi.parser.ParserState(self.parsed)

    @property
    def tracer(self) -> MeshTracer:
        """What traces rays through this scene.

        Made anew for every frame. Kept with the scene, recordings read wrong or freed memory once other
        scenes had come and gone (Dr.Jit 1.5; `tests/test_turntable.py` shows it).
        """
        extent = float(np.abs(self._traced_bounds).max())
        return MeshTracer(
            self.mi_scene,
            self.materials,
            dr.opaque(mi.Point3d, list(self.origin)),
            dr.opaque(mi.Float, extent),
            self.serial,
        )

    @property
    def camera(self) -> Camera:
        """The first camera."""
        return self.cameras[0]

    def select_camera(self, camera: str | int) -> Scene:
        """The same scene with another camera first.

        Args:
            camera: Its name, or its number in `cameras`.

        Raises:
            SceneError: There is no such camera; the message lists those there are.
        """
        names = [c.name for c in self.cameras]
        if isinstance(camera, str) and camera in names:
            index = names.index(camera)
        elif str(camera).isdecimal() and int(camera) < len(names):
            index = int(camera)
        else:
            raise SceneError(f"no camera {camera!r} in {self.name}, which has: {', '.join(names)}")
        rest = self.cameras[:index] + self.cameras[index + 1 :]
        return replace(self, cameras=(self.cameras[index], *rest))

    def dimmed(self, light: str | int | None, share: float) -> Scene:
        """The same scene with a light turned down or off; nothing is recorded anew for it.

        Args:
            light: Its name, or its number in `named_lights`; None for all of them.
            share: What to multiply its output with, 0 or more; 0 switches it off for good.

        Raises:
            SceneError: There is no such light, or `share` is negative or not a number.
        """
        chosen = self.named_lights if light is None else (find_light(self.named_lights, light),)
        lights, materials = dim(self.lights, self.materials, chosen, share)
        return replace(self, lights=lights, materials=materials)
