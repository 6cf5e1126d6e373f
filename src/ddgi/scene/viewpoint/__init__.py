"""A camera for a scene that has none: in a room if there is one, else around the object."""

from __future__ import annotations

from dataclasses import dataclass

import mitsuba as mi
import numpy as np

from ddgi.lighting.lights import Lights
from ddgi.scene.camera import Camera, look_at
from ddgi.scene.viewpoint import around, inside
from ddgi.scene.viewpoint.outline import near_shapes, outlines, without_backdrop
from ddgi.scene.viewpoint.rooms import SEEDS, far_off
from ddgi.trace.mesh import MeshTracer

SIZE = (640, 360)


@dataclass(frozen=True)
class Viewpoint:
    """A camera that was chosen."""

    camera: Camera
    inside: bool  # it stands in a room
    look: tuple[float, ...]  # from, to [m]: what --look takes


def find(mi_scene: mi.Scene, tracer: MeshTracer, lights: Lights, up: np.ndarray) -> Viewpoint:
    """Choose a camera. The same scene gets the same one, and a larger copy one that is larger likewise.

    Args:
        mi_scene: The geometry.
        tracer: What traces it.
        lights: Its lights: no camera in the dark where there is light elsewhere.
        up: (3,) unit.
    """
    shapes = outlines(mi_scene)
    reach = far_off(near_shapes(shapes, SEEDS))
    view = inside.best_view(tracer, lights, shapes, up, reach)
    in_room = view is not None
    if view is None:
        view = around.best_view(tracer, lights, without_backdrop(shapes, up), up)
    # Few digits, to be typed: nobody sees a thousandth of the way to what is looked at.
    step = 10.0 ** np.floor(np.log10(np.linalg.norm(view.target - view.place)) - 3)
    look = tuple(float(round(float(x / step)) * step) for x in (*view.place, *view.target))
    camera = look_at(look[:3], look[3:], up, fov=view.fov, size=SIZE, name="found")
    return Viewpoint(camera, in_room, look)
