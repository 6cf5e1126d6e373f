"""Polygons to triangles: convex ones as fans, others by cutting off ears.

Source: Eberly, "Triangulation by Ear Clipping" (2002); the plane's normal is Newell's.
"""

from __future__ import annotations

import numpy as np


def triangulated(positions: np.ndarray) -> np.ndarray:
    """Triangles of polygons that have equally many corners.

    Args:
        positions: (P, n, 3) corners in order.

    Returns:
        (P, n - 2, 3) numbers of corners, wound as the polygons are.
    """
    count, corners = positions.shape[:2]
    fan = np.array([[0, k, k + 1] for k in range(1, corners - 1)])
    out = np.broadcast_to(fan, (count, *fan.shape)).copy()
    if corners == 3:
        return out
    after = np.roll(positions, -1, 1)
    normal = np.cross(positions - positions[:, :1], after - positions[:, :1]).sum(1)
    turns = np.cross(positions - np.roll(positions, 1, 1), after - positions)
    hollow = (np.einsum("pnc,pc->pn", turns, normal) < 0).any(1)
    for index in np.flatnonzero(hollow):
        out[index] = _clipped(_flat(positions[index], normal[index]))
    return out


def _flat(corners: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """(n, 2) the corners without the axis nearest the normal, counter-clockwise."""
    axis = int(np.abs(normal).argmax())
    kept = [(axis + 1) % 3, (axis + 2) % 3]
    return corners[:, kept if normal[axis] > 0 else kept[::-1]]


def _clipped(points: np.ndarray) -> list[list[int]]:
    left = list(range(len(points)))
    out = []
    while len(left) > 3:
        ear = next((k for k in range(len(left)) if _is_ear(points, left, k)), 0)  # 0: it crosses itself
        out.append([left[ear - 1], left[ear], left[(ear + 1) % len(left)]])
        del left[ear]
    return [*out, left]


def _is_ear(points: np.ndarray, left: list[int], k: int) -> bool:
    a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
    if _turn(points[a], points[b], points[c]) <= 0:
        return False
    others = points[[i for i in left if i not in (a, b, c)]]
    sides = [_turn(points[i], points[j], others.T) for i, j in ((a, b), (b, c), (c, a))]
    return not (np.array(sides) >= 0).all(0).any()


def _turn(a: np.ndarray, b: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Twice the area of a, b, p; positive to the left."""
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
