"""Solids with soft edges: boxes with rounded edges, cushions, and tubes along curved paths. Metres, +y up.

Watertight and wound counter-clockwise seen from outside, as in `geometry`.
"""

from __future__ import annotations

import numpy as np

from ddgi.scene.library import sculpting
from ddgi.scene.library.geometry import Array, Point, Triangles, grid, merge, smooth, welded


def rounded_box(low: Point, high: Point, radius: float, steps: int = 2) -> Triangles:
    """An axis-aligned box between two corners, with edges and corners rounded.

    Args:
        low: Lower corner [m].
        high: Upper corner [m].
        radius: Of the edges [m]; at most half the shortest side.
        steps: Quads across half an edge.
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    half = (high - low) / 2
    radius = min(radius, float(half.min()))
    # Towards an edge the points stand at equal angles as seen from the edge's axis: tangents.
    rim = np.tan(np.linspace(0.0, np.pi / 4, steps + 1))
    axes = [np.concatenate([-(h - radius) - radius * rim[::-1], h - radius + radius * rim]) for h in half]
    faces = []
    for points in _cube_faces(axes):
        core = points.clip(radius - half, half - radius)
        away = points - core
        away /= np.maximum(np.linalg.norm(away, axis=-1, keepdims=True), 1e-20)
        side = grid((low + high) / 2 + core + radius * away)
        faces.append(side._replace(normals=away.reshape(-1, 3)))
    return merge(faces)


def cushion(half: Point, power: float = 4.0, cells: int = 12) -> Triangles:
    """A stuffed cushion about the origin.

    Args:
        half: Half its extent along x, y and z [m].
        power: 2 makes an ellipsoid, the larger the nearer to a box.
        cells: Quads along each edge of the cube it starts from.
    """
    axis = np.tan(np.linspace(-np.pi / 4, np.pi / 4, cells + 1))
    faces = []
    for points in _cube_faces([axis] * 3):
        length = (np.abs(points) ** power).sum(-1, keepdims=True) ** (1 / power)
        faces.append(grid(points / length * np.asarray(half, float)))
    return smooth(welded(merge(faces)))


def tube(path: Array, radius: Array | float, sides: int = 8) -> Triangles:
    """A round bar along a path.

    Args:
        path: (N, 3) its axis [m].
        radius: (N,) at each point, or one for all [m].
        sides: Quads around it.
    """
    path = np.asarray(path, float)
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.empty_like(path)
    # Carried along with the least turning, so that the quads do not twist.
    before = np.eye(3)[np.abs(along[0]).argmin()]
    for i, direction in enumerate(along):
        before = before - (before @ direction) * direction
        before /= np.linalg.norm(before)
        across[i] = before
    radii = np.broadcast_to(np.asarray(radius, float), len(path))
    return sculpting.tube(path, radii, across, sides=sides)


def _cube_faces(axes: list[Array]) -> list[Array]:
    """The six sides of a box as grids of points that face outwards, each (R, C, 3).

    Args:
        axes: Three rising lists of coordinates; the first and last of each are the box's sides.
    """
    faces = []
    for axis in range(3):
        rows, columns = axes[(axis + 1) % 3], axes[(axis + 2) % 3]
        for end in (0, -1):
            points = np.empty((len(rows), len(columns), 3))
            points[..., axis] = axes[axis][end]
            points[..., (axis + 1) % 3] = rows[:, None]
            points[..., (axis + 2) % 3] = columns
            faces.append(points[::-1] if end == 0 else points)
    return faces
