"""The node hierarchy: which nodes a scene shows, and where each stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf.schema import Document, Node
from ddgi.scene.matrices import compose

NONE = -1


@dataclass(frozen=True)
class Hierarchy:
    """The N nodes of a file, each in its parent's space. Those with a matrix have parts that do not count."""

    parents: list[int]  # of each node, or NONE
    local: np.ndarray  # (N, 4, 4) from each node's space to its parent's
    translation: np.ndarray  # (N, 3)
    rotation: np.ndarray  # (N, 4) quaternions x, y, z, w
    scale: np.ndarray  # (N, 3)


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


def placed_nodes(document: Document, hierarchy: Hierarchy, origin: np.ndarray) -> list[Placed]:
    """The nodes of the default scene, parents before children; without any scene, of all root nodes.

    Args:
        document: The file.
        hierarchy: Its nodes.
        origin: (3,) the place in the file's coordinates that theirs count from.

    Raises:
        SceneError: A scene names nodes that are none of its roots, or a node's place is not finite.
    """
    placed: list[Placed] = []
    outside = np.eye(4)
    outside[:3, 3] = -origin
    waiting = [(index, outside, True) for index in reversed(_roots(document, hierarchy.parents))]
    while waiting:  # no recursion: chains may be thousands long
        index, parent_world, visible = waiting.pop()
        node = document.nodes[index]
        world = parent_world @ hierarchy.local[index]
        visible = visible and node.extensions.visibility.visible
        placed.append(Placed(index, node, world, visible))
        waiting.extend((child, world, visible) for child in reversed(node.children))
    _check_finite(placed)
    return placed


def _check_finite(placed: list[Placed]) -> None:
    worlds = np.array([p.world for p in placed]).reshape(-1, 16)
    for row in np.flatnonzero(~np.isfinite(worlds).all(1))[:1]:
        raise SceneError(f"nodes[{placed[row].index}]: its place in the scene is not finite")


def read_hierarchy(document: Document) -> Hierarchy:
    """All nodes of a file, shown or not.

    Raises:
        SceneError: Nodes form a circle, have two parents, or a transform is not usable.
    """
    parents, nodes = parents_of(document), document.nodes
    # All at once: one at a time, 100,000 nodes take half a minute.
    translation = np.array([node.translation for node in nodes], np.float64).reshape(-1, 3)
    rotation = np.array([node.rotation for node in nodes], np.float64).reshape(-1, 4)
    scale = np.array([node.scale for node in nodes], np.float64).reshape(-1, 3)
    of_parts = np.array([node.matrix is None for node in nodes], bool)
    zero = of_parts & ~(np.linalg.norm(rotation, axis=1) > 0)
    if zero.any():
        raise SceneError(f"nodes[{zero.argmax()}]: its rotation is zero, which is no quaternion")
    local = np.zeros((len(nodes), 4, 4))
    local[of_parts] = compose(translation[of_parts], rotation[of_parts], scale[of_parts])
    local[~of_parts] = _matrices(document)
    return Hierarchy(parents, local, translation, rotation, scale)


def _matrices(document: Document) -> np.ndarray:
    """(M, 4, 4) of the nodes that have a matrix instead of parts."""
    numbers = [index for index, node in enumerate(document.nodes) if node.matrix is not None]
    stored = np.array([document.nodes[index].matrix for index in numbers], np.float64)
    matrices = stored.reshape(-1, 4, 4).transpose(0, 2, 1)  # stored column by column
    bad = ~np.isclose(matrices[:, 3], [0, 0, 0, 1], atol=1e-6).all(1)
    if bad.any():
        label = f"nodes[{numbers[bad.argmax()]}]"
        raise SceneError(f"{label}: its matrix is no placement: its last row must be 0, 0, 0, 1")
    return matrices


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
