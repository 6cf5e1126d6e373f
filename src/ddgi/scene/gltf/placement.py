"""Triangles put where they stand in the scene: the front stays in front, and what has no area goes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf.primitives import Piece
from ddgi.scene.matrices import cross, mirrors, moved_surface


@dataclass(frozen=True)
class Soup:
    """V vertices and F triangles ready to trace."""

    positions: np.ndarray  # (V, 3) float32 [m]
    faces: np.ndarray  # (F, 3) uint32
    normals: np.ndarray | None  # (V, 3) float32, unit
    kept: np.ndarray  # (V,) which vertices of the piece these are
    without_area: int  # triangles left out


def place(piece: Piece, matrices: np.ndarray, label: str, *, keep_flat: bool = False) -> Soup:
    """Move a piece.

    Args:
        piece: What to move.
        matrices: (4, 4), or (V, 4, 4) with one for each vertex.
        label: What it is, for messages.
        keep_flat: Triangles without area stay, as they may have one when they move.

    Raises:
        SceneError: A vertex is too far away for single precision.
    """
    positions, normals = moved_surface(piece.positions, piece.normals, matrices)
    with np.errstate(over="ignore"):
        single = positions.astype(np.float32)
    if not np.isfinite(single).all():
        raise SceneError(f"{label}: a vertex lies too far away")
    faces = piece.faces[:, ::-1] if mirrors(matrices) else piece.faces
    area = _crossed(single.astype(np.float64), faces)
    whole = (area != 0).any(1) | keep_flat
    faces, area = faces[whole], area[whole]
    if normals is not None:
        normals = _unit(normals, faces, area)
    return _compact(single, faces, normals, int((~whole).sum()))


def joined(soups: list[Soup]) -> Soup:
    """Several placings of one piece as one."""
    starts = np.cumsum([0, *(len(soup.positions) for soup in soups[:-1])])
    faces = [soup.faces + np.uint32(start) for soup, start in zip(soups, starts, strict=True)]
    normals = [soup.normals for soup in soups if soup.normals is not None]
    return Soup(
        positions=np.concatenate([soup.positions for soup in soups]),
        faces=np.concatenate(faces),
        normals=np.concatenate(normals) if normals else None,
        kept=np.concatenate([soup.kept for soup in soups]),
        without_area=sum(soup.without_area for soup in soups),
    )


def _compact(positions: np.ndarray, faces: np.ndarray, normals: np.ndarray | None, dropped: int) -> Soup:
    """Without the vertices that no triangle uses: primitives may share one large table."""
    kept = np.arange(len(positions))
    used = np.zeros(len(positions), bool)
    used[faces.reshape(-1)] = True
    if not used.all():
        kept = np.flatnonzero(used)
        number = np.zeros(len(positions), np.uint32)
        number[kept] = np.arange(len(kept), dtype=np.uint32)
        faces = number[faces]
    normals = None if normals is None else normals[kept].astype(np.float32)
    return Soup(positions[kept], np.ascontiguousarray(faces, np.uint32), normals, kept, dropped)


def _crossed(positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F, 3) normal of each triangle, twice its area long."""
    a, b, c = (positions[faces[:, k]] for k in range(3))
    return cross(b - a, c - a)


def _unit(normals: np.ndarray, faces: np.ndarray, area: np.ndarray) -> np.ndarray:
    """Normals of length one; where there is none, the mean of the triangles around the vertex."""
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    if not (length > 0).all():
        around = np.zeros_like(normals)
        for corner in range(3):
            np.add.at(around, faces[:, corner], area)
        normals = np.where(length > 0, normals, around)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.where(length > 0, normals, [0.0, 1.0, 0.0])
    return normals / np.where(length > 0, length, 1)
