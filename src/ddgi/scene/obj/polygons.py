"""Polygons to triangles: convex ones as fans, others by cutting off ears.

Source: Eberly, "Triangulation by Ear Clipping" (2002); the plane's normal is Newell's.
Only corners between the left and the right end of an ear are tested against it, for speed.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from heapq import heappop, heappush
from typing import Any, TypeAlias

import numpy as np

_Pair: TypeAlias = list[float]
"""x and y of a corner."""
NONE = [float("nan")] * 2
"""A corner that is in no triangle."""
FEW = 32
"""Corners that are tested faster one by one than as an array."""


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
    ring = _Ring(points)
    out = [ring.cut(ring.next_ear()) for _ in range(len(points) - 3)]
    return [*out, ring.rest()]


class _Ring:
    """The corners of a polygon that are left, and what tells which of them are ears.

    An ear holds no other corner. Of a polygon that does not cross itself only corners that do not bulge
    can be in the way, and cutting makes ears of none but the two neighbours.
    """

    def __init__(self, points: np.ndarray) -> None:
        count = len(points)
        self._at = points.tolist()
        self._before = [count - 1, *range(count - 1)]
        self._after = [*range(1, count), 0]
        hollow = [k for k in range(count) if _turn(*self._triangle(k)) <= 0]
        hollow.sort(key=lambda k: self._at[k][0])
        self._place = {corner: place for place, corner in enumerate(hollow)}
        self._hollow_x = [self._at[corner][0] for corner in hollow]  # sorted
        self._hollow = [self._at[corner] for corner in hollow]  # NONE instead of those that bulge by now
        self._hollow_xy = np.array(self._hollow).reshape(-1, 2).T.copy()  # (2, H) the same
        self._first = 0  # a corner that is left
        self._left = count
        self._searched = np.inf  # how many were left when all were last looked at
        self._is_ear = [False] * count
        self._ears: list[int] = []  # a heap: the first comes first

    def next_ear(self) -> int:
        """The first ear; any corner of a polygon that has none, because it crosses itself."""
        while True:
            while self._ears:
                if self._is_ear[ear := heappop(self._ears)]:
                    return ear
            # Not after every cut: polygons that cross themselves would take n^2 tests.
            if self._left > 0.9 * self._searched:
                return self._first
            self._searched = self._left
            for corner in self._corners():
                self._look_at(corner)

    def cut(self, corner: int) -> list[int]:
        """Take a corner away; the triangle that goes with it."""
        before, after = self._before[corner], self._after[corner]
        self._after[before], self._before[after] = after, before
        self._is_ear[corner] = False
        self._is_in_no_way(corner)
        if corner == self._first:
            self._first = after
        self._left -= 1
        self._look_at(before)
        self._look_at(after)
        return [before, corner, after]

    def rest(self) -> list[int]:
        """The corners that are left, in order."""
        return list(self._corners())

    def _corners(self) -> Iterator[int]:
        corner = self._first
        for _ in range(self._left):
            yield corner
            corner = self._after[corner]

    def _triangle(self, corner: int) -> tuple[_Pair, _Pair, _Pair]:
        return self._at[self._before[corner]], self._at[corner], self._at[self._after[corner]]

    def _look_at(self, corner: int) -> None:
        a, b, c = self._triangle(corner)
        bulges = _turn(a, b, c) > 0
        if bulges:
            self._is_in_no_way(corner)
        was = self._is_ear[corner]
        self._is_ear[corner] = bulges and not self._in_the_way(a, b, c)
        if self._is_ear[corner] and not was:
            heappush(self._ears, corner)

    def _is_in_no_way(self, corner: int) -> None:
        if (place := self._place.get(corner)) is not None:
            self._hollow[place] = NONE
            self._hollow_xy[:, place] = NONE

    def _in_the_way(self, a: _Pair, b: _Pair, c: _Pair) -> bool:
        """Whether a corner lies in the triangle. At a and c there may be one: where a hole is joined on."""
        low = bisect_left(self._hollow_x, min(a[0], b[0], c[0]))
        high = bisect_right(self._hollow_x, max(a[0], b[0], c[0]), low)
        if high - low <= FEW:
            return any(_holds(a, b, c, p) and p not in (a, c) for p in self._hollow[low:high])
        inside = np.flatnonzero(_holds(a, b, c, self._hollow_xy[:, low:high]))
        return any(self._hollow[low + k] not in (a, c) for k in inside)


def _holds(a: _Pair, b: _Pair, c: _Pair, p: Any) -> Any:
    """Whether points, x and y, lie in a triangle or on its edges."""
    return (_turn(a, b, p) >= 0) & (_turn(b, c, p) >= 0) & (_turn(c, a, p) >= 0)


def _turn(a: _Pair, b: _Pair, p: Any) -> Any:
    """Twice the area of a, b, p; positive to the left."""
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
