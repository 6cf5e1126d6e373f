"""Placements as 4 x 4 matrices, and what they do to points and normals."""

from __future__ import annotations

import numpy as np


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


def times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(V, 3) matrix times vector, for one matrix (3, 3) or one per vector (V, 3, 3)."""
    if matrices.ndim == 2:
        return vectors @ matrices.T
    return np.einsum("vij,vj->vi", matrices, vectors)


def cofactors(linear: np.ndarray) -> np.ndarray:
    """Inverse transpose times determinant; exists for flattened things too. linear: (..., 3, 3)."""
    a, b, c = linear[..., :, 0], linear[..., :, 1], linear[..., :, 2]
    return np.stack([cross(b, c), cross(c, a), cross(a, b)], -1)


def moved_surface(
    positions: np.ndarray, normals: np.ndarray | None, matrices: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None]:
    """Points and normals where placements put them; normals stay outward, of any length.

    Args:
        positions: (V, 3).
        normals: (V, 3), if there are any.
        matrices: (4, 4), or (V, 4, 4) with one for each point.
    """
    linear = matrices[..., :3, :3]
    positions = times(linear, positions.astype(np.float64)) + matrices[..., :3, 3]
    if normals is None:
        return positions, None
    # Cofactors are the inverse times the determinant.
    sign = -1.0 if mirrors(matrices) else 1.0
    return positions, times(cofactors(linear) * sign, normals.astype(np.float64))


def mirrors(matrices: np.ndarray) -> bool:
    """Whether a placement (4, 4), or the mean of several, makes a right hand a left one."""
    return bool(np.linalg.det(np.mean(matrices[..., :3, :3].reshape(-1, 3, 3), 0)) < 0)


def blended(numbers: np.ndarray, weights: np.ndarray, matrices: np.ndarray) -> np.ndarray:
    """(V, 4, 4) weighted means of the matrices that each point hangs on.

    Args:
        numbers: (V, K) rows of `matrices`.
        weights: (V, K), of any sum above 0.
        matrices: (J, 4, 4).
    """
    shares = weights / weights.sum(1, keepdims=True)
    out = np.zeros((len(numbers), 4, 4))
    for column in range(numbers.shape[1]):
        out += shares[:, column, None, None] * matrices[numbers[:, column]]
    return out


def unit(vectors: np.ndarray) -> np.ndarray:
    """(V, 3) vectors of length one; where there is no direction, upwards."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    usable = (length > 0) & np.isfinite(length)
    return np.where(usable, vectors / np.where(usable, length, 1), [0.0, 1.0, 0.0])


def normals_around(positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(V, 3) unit normals of a smooth surface: at each vertex the mean of the faces around, weighted by area."""
    corners = positions[faces]
    area = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    around = np.zeros(positions.shape)
    for corner in range(3):
        np.add.at(around, faces[:, corner], area)
    return unit(around)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """`np.cross`, which takes longer than all else here for a mesh of a few triangles, number for number."""
    x, y, z = (a[..., k] for k in range(3))
    u, v, w = (b[..., k] for k in range(3))
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], -1)
