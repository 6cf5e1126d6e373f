"""Meshes bent as they rest: morph targets by their weights, skins by where their joints stand.

glTF 2.0 specification, sections 3.7.2.2 (morph targets) and 3.7.3 (skins).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf.primitives import Piece
from ddgi.scene.matrices import blended


def morphed(piece: Piece, weights: list[float], label: str) -> Piece:
    """A piece with its morph targets added.

    Args:
        piece: At the weights 0.
        weights: One per target; those missing are 0.
        label: Whose weights they are, for messages.

    Raises:
        SceneError: There are more weights than targets.
    """
    if len(weights) > len(piece.targets):
        raise SceneError(f"{label}: {len(weights)} weights for {len(piece.targets)} morph targets")
    positions = piece.positions
    normals = piece.normals
    for weight, target in zip(weights, piece.targets, strict=False):
        if weight and "POSITION" in target:
            positions = positions + np.float32(weight) * target["POSITION"]
        if weight and "NORMAL" in target and normals is not None:
            normals = normals + np.float32(weight) * target["NORMAL"]
    return replace(piece, positions=positions, normals=normals)


def skin_matrices(piece: Piece, joints: np.ndarray, label: str) -> np.ndarray:
    """(V, 4, 4) from the space of a skinned mesh to the scene's, one per vertex.

    Args:
        piece: With joints and weights.
        joints: (J, 4, 4) each joint's place in the scene times its inverse bind matrix.
        label: Whose skin it is, for messages.

    Raises:
        SceneError: A vertex hangs on a joint that does not exist, or on none.
    """
    if piece.joints is None or piece.weights is None or piece.joints.shape != piece.weights.shape:
        raise SceneError(f"{label} has a skin, but its mesh does not have as many JOINTS as WEIGHTS")
    weights = piece.weights.astype(np.float64)
    total = weights.sum(1, keepdims=True)
    if (weights < 0).any() or not (total > 0).all():
        raise SceneError(f"{label}: the joint weights of a vertex are negative, or all zero")
    if (largest := int(piece.joints[weights > 0].max())) >= len(joints):
        raise SceneError(f"{label}: a vertex hangs on joint {largest}, but there are {len(joints)}")
    return blended(np.minimum(piece.joints, len(joints) - 1), weights, joints)
