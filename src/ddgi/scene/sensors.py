"""Mitsuba sensors to cameras, by asking the sensor itself for three of its rays.

So every way to state a field of view, an off-centre principal point, a crop window or a mirrored
transform comes out as Mitsuba has it.
"""

from __future__ import annotations

import mitsuba as mi
import numpy as np

from ddgi.scene.camera import Camera, make_camera
from ddgi.scene.notes import Notes
from ddgi.scene.plugin_tree import PluginTree
from ddgi.scene.validate import check_finite

CAMERAS = ("perspective", "thinlens", "orthographic")
"""Plugins that are cameras to us."""


def read_camera(
    sensor: mi.Sensor, name: str, tree: PluginTree, notes: Notes, origin: np.ndarray
) -> Camera | None:
    """The camera that a sensor is; None, with a note, for one that is not of `CAMERAS`.

    Args:
        sensor: Whose transform counts from `origin`.
        name: What to call the camera.
        tree: What the sensor was built from.
        notes: Takes what is not as in the file.
        origin: (3,) in the coordinates of the file.

    Raises:
        SceneError: Its transform is not finite.
    """
    kind = sensor.class_name()
    if kind not in ("PerspectiveCamera", "ThinLensCamera", "OrthographicCamera"):
        notes.add(f"{tree.label_of(sensor)}: not a camera this package has, left out")
        return None
    if kind == "ThinLensCamera":
        notes.add(f'camera "{name}": its lens is taken as a pinhole')
    matrix = np.array(sensor.world_transform().matrix, np.float64).reshape(4, 4)
    check_finite(matrix, f"{tree.label_of(sensor)}: to_world")
    position, axis = matrix[:3, 3], matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    properties = tree.properties_of(sensor)
    near = 0.0
    if properties is not None and "near_clip" in properties:
        near = float(properties["near_clip"])  # where the file asks for it; Mitsuba's own default is no wish
    middle, right, top = (_ray(sensor, *xy) for xy in ((0.5, 0.5), (1.0, 0.5), (0.5, 0.0)))
    width, height = (int(n) for n in sensor.film().crop_size())
    size = width, height
    if kind == "OrthographicCamera":
        # Rays start on the near plane: slide them back to the sensor's own.
        start, edge_x, edge_y = (o - axis * ((o - position) @ axis) for o, _ in (middle, right, top))
        return make_camera(
            name, origin + start, axis, edge_x - start, edge_y - start, size, near=near, orthographic=True
        )
    # At distance one along the optical axis, then scaled so that the middle ray is the unit vector.
    center, edge_x, edge_y = (d / (d @ axis) for _, d in (middle, right, top))
    forward, across, upward = (v / np.linalg.norm(center) for v in (center, edge_x - center, edge_y - center))
    return make_camera(name, origin + position, forward, across, upward, size, near=near)


def sensor_up(sensor: mi.Sensor) -> np.ndarray:
    """(3,) what is up in the sensor's picture, in world space."""
    matrix = np.array(sensor.world_transform().matrix, np.float64).reshape(4, 4)
    return matrix[:3, 1] / np.linalg.norm(matrix[:3, 1])


def _ray(sensor: mi.Sensor, x: float, y: float) -> tuple[np.ndarray, np.ndarray]:
    """Origin and direction of the ray through (x, y) of the picture and the middle of the lens."""
    ray, _ = sensor.sample_ray(mi.Float(0), mi.Float(0.5), mi.Point2f(x, y), mi.Point2f(0.5))
    return np.array(ray.o, np.float64).ravel(), np.array(ray.d, np.float64).ravel()
