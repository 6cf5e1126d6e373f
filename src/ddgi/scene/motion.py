"""What of a scene can move, how it rests, and what a pose makes of its lights and cameras."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.box import Point
from ddgi.lighting.lights import Lights
from ddgi.own_memory import own
from ddgi.scene.camera import Camera, carried
from ddgi.scene.matrices import moved_surface, unit
from ddgi.scene.named_lights import NamedLight
from ddgi.scene.play import Player
from ddgi.scene.pose import Pose
from ddgi.scene.stage import Stage


@dataclass(frozen=True)
class Motion:
    """What can move, and how it rests."""

    stage: Stage | None  # shapes; None: only lights and cameras can
    lights: Lights
    cameras: Mapping[str, Camera]
    nodes: Mapping[str, int | str] = field(
        default_factory=dict
    )  # of the parsed scene, by name of shape or light: a plugin's number, or the key of what came as an object
    player: Player | None = None  # of the file's animations


def moved_lights(now: Lights, rest: Lights, named: Sequence[NamedLight], pose: Pose) -> Lights:
    """Lights with their places and directions as a pose has them; what else was changed about them stays.

    Args:
        now: As they are.
        rest: As they were loaded.
        named: Their names, and where their numbers are.
        pose: Where things stand.
    """
    position = np.array(rest.delta.position, np.float64).reshape(-1, 4)
    direction = np.array(rest.delta.direction, np.float64).reshape(-1, 4)
    bounds = np.array(rest.area_bounds, np.float64).reshape(-1, 4)
    for light in named:
        if light.kind == "environment":
            continue
        if light.kind == "area" and light.name in pose.bent:
            points = pose.bent[light.name].positions
            low, high = points.min(0), points.max(0)
            bounds[light.row] = [*(low + high) / 2, np.linalg.norm(high - low) / 2]
        if (matrix := pose.matrices.get(light.name)) is None:
            continue
        linear = matrix[:3, :3]
        if light.kind == "area":
            bounds[light.row, :3] = linear @ bounds[light.row, :3] + matrix[:3, 3]
            bounds[light.row, 3] *= np.linalg.norm(linear, 2)
            continue
        position[light.row, :3] = linear @ position[light.row, :3] + matrix[:3, 3]
        way = linear @ direction[light.row, :3]
        direction[light.row, :3] = way / max(float(np.linalg.norm(way)), 1e-30)
    delta = replace(now.delta, position=own(position), direction=own(direction))
    return replace(now, delta=delta, area_bounds=own(bounds))


def moved_cameras(
    now: Sequence[Camera], rest: Mapping[str, Camera], pose: Pose, origin: Point
) -> tuple[Camera, ...]:
    """Cameras where a pose has them, with pictures of the size they have now."""
    return tuple(
        carried(rest[camera.name], pose.matrices[camera.name], origin, camera.size)
        if camera.name in pose.matrices and camera.name in rest
        else camera
        for camera in now
    )


def move_plugins(state: Any, motion: Motion, pose: Pose) -> None:
    """Change a parsed scene, as the path tracer builds it, into what a pose shows.

    Args:
        state: `mi.parser.ParserState`, a copy.
        motion: What can move.
        pose: Where things stand.

    Raises:
        SceneError: A shape that moved came as an object, and is no mesh.
    """
    for name in (*pose.matrices, *pose.bent):
        node = motion.nodes.get(name)
        if isinstance(node, str):
            assert motion.stage is not None
            state.nodes[0].props[node] = motion.stage.copied(name, pose)
        elif node is not None and name in pose.bent:
            _bend(state.nodes[node].props, pose.bent[name].positions, pose.bent[name].normals)
        elif node is not None:
            _carry(state.nodes[node].props, pose.matrices[name])


def _bend(properties: Any, positions: np.ndarray, normals: np.ndarray | None) -> None:
    properties["positions"] = mi.Float(np.ascontiguousarray(positions, np.float32).ravel())
    if normals is not None and "normals" in properties:
        properties["normals"] = mi.Float(np.ascontiguousarray(unit(normals), np.float32).ravel())


def _carry(properties: Any, matrix: np.ndarray) -> None:
    if "positions" in properties:  # a mesh of arrays
        normals = _rows(properties["normals"]) if "normals" in properties else None
        _bend(properties, *moved_surface(_rows(properties["positions"]), normals, matrix))
        return
    for key, way in (("position", matrix[:3, 3]), ("direction", np.zeros(3))):
        if key in properties:
            own = np.array([float(properties[key][axis]) for axis in range(3)])
            properties[key] = (matrix[:3, :3] @ own + way).tolist()
            return
    rest = np.array(properties["to_world"].matrix, np.float64) if "to_world" in properties else np.eye(4)
    properties["to_world"] = mi.ScalarTransform4d(matrix @ rest.reshape(4, 4))


def _rows(values: Any) -> np.ndarray:
    return np.array(values, np.float64).reshape(-1, 3)
