"""Scenes that lie far from the origin are moved to it, while their coordinates are doubles.

Rays are traced in single precision, which is spread over distances from the origin: a room at 12,000
units would have surfaces as rough as a millimetre, and rays would have to leave them by a metre. What
is moved is all that stands somewhere, by one offset: `Scene.origin`. Nobody outside has to know, as
cameras, lights and boxes that come from the user stay in the coordinates of the file.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import mitsuba as mi
import numpy as np
import numpy.typing as npt

from ddgi.scene.notes import Notes
from ddgi.scene.plugin_tree import PluginTree

FAR = 1.0
"""A scene is far away if the middle of its geometry is, against its longest side, on some axis.

`cornell` with three lights, moved so far and not moved back, differs by a mean FLIP of 0.0004 at 1, 0.0009
at 2, 0.002 at 4, 0.007 at 8, 0.05 at 16. A scene that touches the origin is at 0.5 or less.
"""
FINENESS = 16
"""Origins are multiples of about this part of a scene's size: sums with them are exact."""
LAMPS = ("point", "spot", "projector")
"""Emitters that stand somewhere by themselves."""


def origin_for(low: npt.ArrayLike, high: npt.ArrayLike) -> np.ndarray:
    """(3,) where to count from in a scene with geometry between two corners: zero, unless it is far away."""
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    if not np.isfinite([low, high]).all():
        return np.zeros(3)
    middle = low / 2 + high / 2
    away = float(np.abs(middle).max())
    # What was measured in single precision may have shrunk to a point.
    half = max(float((high / 2 - low / 2).max()), away * float(np.finfo(np.float32).eps))
    if not 2 * half * FAR < away:
        return np.zeros(3)
    step = 2.0 ** np.floor(np.log2(2 * half)) / FINENESS
    # Mitsuba has transforms in single precision: there too it must be this very offset.
    return (np.round(middle / step) * step).astype(np.float32).astype(np.float64)


def note_origin(origin: np.ndarray, notes: Notes) -> None:
    """Say that the scene was moved, if it was."""
    if origin.any():
        place = ", ".join(f"{x:.9g}" for x in origin)
        notes.add(f"far from the origin: computed around ({place}); coordinates stay those of the file")


def movable(tree: PluginTree) -> bool:
    """Whether everything in the scene is described: what came as an object cannot be moved."""
    for _, child in tree.children(0):
        if isinstance(child, int):
            if tree.plugin(child).startswith("ellipsoids"):  # splats: Mitsuba places none that are arrays
                return False
        elif isinstance(child, mi.Shape) or (isinstance(child, mi.Emitter) and not _everywhere(child)):
            return False
    return True


def move(tree: PluginTree, nodes: Iterable[int], origin: np.ndarray) -> None:
    """Make the places of plugins count from `origin`. What was built of them before stays as it is.

    Args:
        tree: Whose nodes are changed.
        nodes: Plugins directly in the scene; those that stand nowhere, such as materials, stay.
        origin: (3,) in the coordinates that they count from now.
    """
    if origin.any():
        for index in set(_standing(tree, nodes)):
            _move(tree.properties(index), origin)


def _standing(tree: PluginTree, nodes: Iterable[int]) -> Iterator[int]:
    """Those of some nodes that have a place. Shape groups have none: their instances do."""
    for index in nodes:
        kind, plugin = tree.kind(index), tree.plugin(index)
        if plugin == "merge":
            yield from _standing(tree, (child for _, child in tree.children(index) if isinstance(child, int)))
        elif plugin in LAMPS or (
            kind in (mi.ObjectType.Sensor, mi.ObjectType.Shape) and plugin != "shapegroup"
        ):
            yield index


def _move(properties: Any, origin: np.ndarray) -> None:
    if "position" in properties:  # instead of a transform
        properties["position"] = (_vector(properties["position"]) - origin).tolist()
        return
    own = [key for key in ("center", "p0", "p1") if key in properties]  # of spheres and cylinders
    start = _vector(properties[own[0]]) if own else np.zeros(3)
    matrix = np.eye(4)
    if "to_world" in properties:
        matrix = np.array(properties["to_world"].matrix, np.float64).reshape(4, 4)
    matrix[:3, 3] += matrix[:3, :3] @ start - origin
    properties["to_world"] = mi.ScalarTransform4d(matrix)
    for key in own:
        properties[key] = (_vector(properties[key]) - start).tolist()


def _everywhere(emitter: mi.Emitter) -> bool:
    return emitter.is_environment() or emitter.class_name() == "DirectionalEmitter"


def _vector(value: Any) -> np.ndarray:
    return np.array([float(value[axis]) for axis in range(3)])
