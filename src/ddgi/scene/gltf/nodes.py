"""The node hierarchy: which nodes a scene shows, and where each stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf.schema import Document, Node

NONE = -1


@dataclass(frozen=True)
class Placed:
    """A node of the shown scene."""

    index: int
    node: Node
    world: np.ndarray  # (4, 4) from the node's space to the scene's
    visible: bool = True  # KHR_node_visibility: a hidden node hides what is below it

    @property
    def name(self) -> str:
        """What the file calls it, or its number."""
        return self.node.name or f"node-{self.index}"


def placed_nodes(document: Document, origin: np.ndarray) -> list[Placed]:
    """The nodes of the default scene, parents before children; without any scene, of all root nodes.

    Args:
        document: The file.
        origin: (3,) the place in the file's coordinates that theirs count from.

    Raises:
        SceneError: Nodes form a circle, have two parents, or a transform is not usable.
    """
    parents = parents_of(document)
    placed: list[Placed] = []
    outside = np.eye(4)
    outside[:3, 3] = -origin
    waiting = [(index, outside, True) for index in reversed(_roots(document, parents))]
    while waiting:  # no recursion: chains may be thousands long
        index, parent_world, visible = waiting.pop()
        node = document.nodes[index]
        world = parent_world @ local_matrix(node, f"nodes[{index}]")
        if not np.isfinite(world).all():
            raise SceneError(f"nodes[{index}]: its place in the scene is not finite")
        visible = visible and node.extensions.visibility.visible
        placed.append(Placed(index, node, world, visible))
        waiting.extend((child, world, visible) for child in reversed(node.children))
    return placed


def parents_of(document: Document) -> list[int]:
    """Parent of each node, or NONE.

    Raises:
        SceneError: A node has two parents, or is its own ancestor.
    """
    parents = [NONE] * len(document.nodes)
    for index, node in enumerate(document.nodes):
        for child in node.children:
            if parents[child] != NONE:
                raise SceneError(f"nodes[{child}] is a child of both nodes[{parents[child]}] and [{index}]")
            parents[child] = index
    reached = [index for index, parent in enumerate(parents) if parent == NONE]
    for index in reached:  # grows meanwhile
        reached.extend(document.nodes[index].children)
    if len(reached) < len(parents):
        lost = min(set(range(len(parents))) - set(reached))
        raise SceneError(f"nodes[{lost}] is its own ancestor")
    return parents


def local_matrix(node: Node, label: str) -> np.ndarray:
    """(4, 4) from a node's space to its parent's.

    Raises:
        SceneError: Its matrix is a projection, or its rotation no quaternion.
    """
    if node.matrix is not None:
        matrix = np.array(node.matrix, np.float64).reshape(4, 4).T  # stored column by column
        if not np.allclose(matrix[3], [0, 0, 0, 1], atol=1e-6):
            raise SceneError(f"{label}: its matrix is no placement: its last row must be 0, 0, 0, 1")
        return matrix
    translation, scale = np.array(node.translation, np.float64), np.array(node.scale, np.float64)
    if not np.linalg.norm(node.rotation) > 0:
        raise SceneError(f"{label}: its rotation is zero, which is no quaternion")
    return compose(translation[None], np.array([node.rotation], np.float64), scale[None])[0]


def compose(translation: np.ndarray, rotation: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """(N, 4, 4) matrices that scale, then rotate, then move.

    Args:
        translation: (N, 3).
        rotation: (N, 4) quaternions x, y, z, w; their length does not count.
        scale: (N, 3).
    """
    x, y, z, w = (rotation / np.linalg.norm(rotation, axis=1, keepdims=True)).T
    matrix = np.zeros((len(rotation), 4, 4))
    matrix[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], -1)
    matrix[:, 1, :3] = np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], -1)
    matrix[:, 2, :3] = np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], -1)
    matrix[:, :3, :3] *= scale[:, None, :]
    matrix[:, :3, 3], matrix[:, 3, 3] = translation, 1
    return matrix


def _roots(document: Document, parents: list[int]) -> list[int]:
    if not document.scenes:
        return [index for index, parent in enumerate(parents) if parent == NONE]
    number = document.scene or 0
    roots = document.scenes[number].nodes
    for index in roots:
        if parents[index] != NONE:
            raise SceneError(f"scenes[{number}] names nodes[{index}], which is a child of another node")
    if len(set(roots)) < len(roots):
        raise SceneError(f"scenes[{number}] names a node twice")
    return list(roots)
