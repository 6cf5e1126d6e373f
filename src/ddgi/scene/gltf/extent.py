"""Where the geometry of a file lies, roughly, before any of it is moved: morph targets do not count."""

from __future__ import annotations

import numpy as np

from ddgi.scene.gltf.accessors import Accessors
from ddgi.scene.gltf.instancing import placements
from ddgi.scene.gltf.nodes import Placed
from ddgi.scene.gltf.primitives import TRIANGLES, PrimitiveReader
from ddgi.scene.gltf.schema import Document
from ddgi.scene.rig import Skin


def extent(
    document: Document,
    nodes: list[Placed],
    accessors: Accessors,
    primitives: PrimitiveReader,
    skins: tuple[Skin, ...],
) -> tuple[np.ndarray, np.ndarray]:
    """(3,) low and (3,) high corner of a box around all triangles; infinite without any.

    Raises:
        SceneError: A mesh or its placement cannot be used.
    """
    worlds = {placed.index: placed.world for placed in nodes}
    meshes: dict[int, np.ndarray] = {}
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for placed in nodes:
        mesh = placed.node.mesh
        if mesh is None or not placed.visible:
            continue
        if mesh not in meshes:
            meshes[mesh] = _corners(document, mesh, primitives)
        if len(meshes[mesh]):
            matrices = _matrices(placed, worlds, accessors, skins)
            linear, offset = matrices[:, :3, :3], matrices[:, None, :3, 3]
            places = np.einsum("nij,cj->nci", linear, meshes[mesh]) + offset
            low, high = np.minimum(low, places.min((0, 1))), np.maximum(high, places.max((0, 1)))
    return low, high


def _corners(document: Document, mesh: int, primitives: PrimitiveReader) -> np.ndarray:
    """(8 P, 3) corners of the boxes around a mesh's P primitives, in the mesh's space."""
    out = [np.zeros((0, 3))]
    for index, primitive in enumerate(document.meshes[mesh].primitives):
        if primitive.mode >= TRIANGLES:
            positions = primitives.piece(mesh, index, primitive).positions
            if len(positions):
                sides = np.stack([positions.min(0), positions.max(0)]).astype(np.float64)
                out.append(np.stack(np.meshgrid(*sides.T), -1).reshape(-1, 3))
    return np.concatenate(out)


def _matrices(
    placed: Placed, worlds: dict[int, np.ndarray], accessors: Accessors, skins: tuple[Skin, ...]
) -> np.ndarray:
    """(N, 4, 4) the ways a mesh is placed: by its node, by each instance, or by each joint of its skin."""
    node = placed.node
    if node.extensions.instancing is not None:
        return placed.world @ placements(node.extensions.instancing, accessors, f"nodes[{placed.index}]")
    if node.skin is not None:
        skin = skins[node.skin]
        found = [n for n, joint in enumerate(skin.joints) if joint in worlds]
        if found:  # else it is an error, which the reader of shapes tells of
            return np.stack([worlds[skin.joints[n]] @ skin.inverse_bind[n] for n in found])
    return placed.world[None]
