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
from ddgi.scene.motion import Motion, move_plugins, moved_cameras, moved_lights
from ddgi.scene.named_lights import NamedLight, find_light
from ddgi.scene.notes import AT_REST
from ddgi.scene.play import find_clip
from ddgi.scene.pose import Pose
from ddgi.scene.rig import Rig
from ddgi.trace.materials import Materials
from ddgi.trace.mesh import MeshTracer
from ddgi.trace.movers import Movers


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
    )  # the geometry that stays, area lights and environment; its BSDFs are ignored, other lights not in it
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
    motion: Motion | None = None  # what of it can move; shared by copies
    pose: Pose = field(default_factory=Pose)  # where that stands
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
        """The box around all geometry, at rest where it moves, from `origin`."""
        bounds = self.mi_scene.bbox()
        low, high = np.ravel(bounds.min), np.ravel(bounds.max)
        if self.motion is not None and self.motion.stage is not None:  # nothing may be left that stays
            box = self.motion.stage.box(Pose())
            low, high = np.fmin(low, box[0]), np.fmax(high, box[1])
        (a, b, c), (d, e, f) = low.tolist(), high.tolist()
        return (a, b, c), (d, e, f)

    @property
    def moving_boxes(self) -> list[Box]:
        """The box around each shape that can move, where it is now, in the coordinates of the file [m]."""
        if self.motion is None or self.motion.stage is None:
            return []
        return [moved(box, self.origin) for box in self.motion.stage.boxes(self.pose).values()]

    @property
    def mi_shapes(self) -> list[mi.Shape]:
        """Mitsuba's shapes: those that stay, and those that can move as they were loaded."""
        moving = (
            self.motion.stage.at_rest if self.motion is not None and self.motion.stage is not None else ()
        )
        return [*self.mi_scene.shapes(), *moving]

    @property
    def source(self) -> Any:
        """Mitsuba's parsed scene as it stands now, to build with `mi.parser.instantiate`; None if there is none.

        A copy, as building empties it: what it referred to is replaced by what was built.
        """
        if self.parsed is None:
            return None
        state = mi.parser.ParserState(self.parsed)
        if self.motion is not None:
            move_plugins(state, self.motion, self.pose)
        return state

    @property
    def tracer(self) -> MeshTracer:
        """What traces rays through this scene.

        Made anew for every frame. Kept with the scene, recordings read wrong or freed memory once other
        scenes had come and gone (Dr.Jit 1.5; `tests/test_turntable.py` shows it).
        """
        stage = self.motion.stage if self.motion is not None else None
        return self._tracer(None if stage is None else stage.show(self.pose))

    @property
    def still_tracer(self) -> MeshTracer:
        """What traces rays through that part of it which cannot move: probes are placed by that.

        Where nothing stays, through everything as it stands.
        """
        if not self.mi_scene.shapes():
            return self.tracer
        return self._tracer(None)

    def _tracer(self, movers: Movers | None) -> MeshTracer:
        extent = float(np.abs(self._traced_bounds).max())
        return MeshTracer(
            self.mi_scene,
            self.materials,
            dr.opaque(mi.Point3d, list(self.origin)),
            dr.opaque(mi.Float, extent),
            self.serial,
            movers,
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

    def at(self, time: float, clip: str | int | None = None) -> Scene:
        """The same scene at a moment of an animation of its file; nothing is recorded anew for it.

        Args:
            time: In seconds. Before the first key and after the last things stand as they do there.
            clip: Name or number of the animation; by default the first.

        Raises:
            SceneError: Nothing in the scene is animated, or there is no such animation.
        """
        player = self.motion.player if self.motion is not None else None
        if player is None or self.rig is None:
            raise SceneError(f"{self.name}: nothing in it is animated")
        if not np.isfinite(time):
            raise SceneError(f"a time must be a finite number of seconds, not {time!r}")
        there = self.posed(player.pose(find_clip(self.rig.clips, clip), time))
        return replace(there, notes=tuple(note for note in there.notes if AT_REST not in note))

    def moved(self, name: str, matrix: np.ndarray) -> Scene:
        """The same scene with one thing elsewhere; nothing is recorded anew for it.

        Args:
            name: Of a shape that was loaded as `movable`, or of a light or camera.
            matrix: (4, 4) what takes it there from where it was loaded, in the coordinates of the file.

        Raises:
            SceneError: There is no such thing that can be moved, or the matrix is no placement.
        """
        matrix = np.asarray(matrix, np.float64)
        if matrix.shape != (4, 4) or not np.allclose(matrix[3], [0, 0, 0, 1], atol=1e-6):
            raise SceneError(f"{name}: a placement is a 4 x 4 matrix whose last row is 0, 0, 0, 1")
        self._check_movable(name, ("shape", "light", "camera"))
        here = matrix.copy()  # about `origin`
        with np.errstate(invalid="ignore"):  # what comes of it is checked
            here[:3, 3] += matrix[:3, :3] @ self.origin - self.origin
        return self.posed(replace(self.pose, matrices={**self.pose.matrices, name: here}))

    def bent(self, name: str, positions: np.ndarray, normals: np.ndarray | None = None) -> Scene:
        """The same scene with one mesh in another form; nothing is recorded anew for it.

        Args:
            name: Of a mesh that was loaded as `movable`.
            positions: (V, 3) of its vertices, as many as it has, in the coordinates of the file [m].
            normals: (V, 3) for smooth meshes; by default they follow from the faces around each vertex.

        Raises:
            SceneError: There is no such mesh, or it has another number of vertices.
        """
        self._check_movable(name, ("shape",))
        assert self.motion is not None
        assert self.motion.stage is not None
        bent = self.motion.stage.bent(name, np.asarray(positions, np.float64) - self.origin, normals)
        return self.posed(replace(self.pose, bent={**self.pose.bent, name: bent}))

    def posed(self, pose: Pose) -> Scene:
        """The same scene in a pose. What has gone astray in it stays where it was, and a note says so."""
        assert self.motion is not None
        pose, astray = pose.finite(self.pose)
        notes = tuple(f"{name}: gone astray (not finite, or too far): left where it was" for name in astray)
        return replace(
            self,
            pose=pose,
            lights=moved_lights(self.lights, self.motion.lights, self.named_lights, pose),
            cameras=moved_cameras(self.cameras, self.motion.cameras, pose, self.origin),
            notes=self.notes + tuple(note for note in notes if note not in self.notes),
        )

    def _check_movable(self, name: str, kinds: tuple[str, ...]) -> None:
        stage = self.motion.stage if self.motion is not None else None
        known = self.motion.nodes if self.motion is not None else {}  # the path tracer's scene has them too
        things = {
            "shape": stage.names if stage is not None else (),
            "light": tuple(light.name for light in self.named_lights if light.name in known),
            "camera": tuple(camera.name for camera in self.cameras),
        }
        can = list(dict.fromkeys(thing for kind in kinds for thing in things[kind]))
        if name in can:
            return
        if name in self.shapes:
            raise SceneError(
                f"{name} was not loaded as something that moves: load the scene with movable=[{name!r}]"
            )
        raise SceneError(f"nothing called {name!r} can be moved: there are {', '.join(can) or 'none'}")
