"""Figures: curves, tubes along them, and clay that balls and rods are added to and carved from.

Clay is a signed distance on a grid; its surface is found by naive surface nets (Gibson, "Constrained
Elastic Surface Nets", MICCAI 1998, without the relaxation). Metres, +y up; solids as in `geometry`.
"""

from __future__ import annotations

import numpy as np

from ddgi.scene.library.geometry import Array, Point, Triangles, smooth, swept

FAR = 1e3  # distance where no clay has been near [m]


def curve(points: Array, steps: int) -> Array:
    """A smooth curve through (N, K) points, `steps` per span: Catmull-Rom. ((N - 1) steps + 1, K)."""
    p = np.asarray(points, float)
    p = np.concatenate([2 * p[:1] - p[1:2], p, 2 * p[-1:] - p[-2:-1]])
    before, start, end, after = (p[i : len(p) - 3 + i, None] for i in range(4))
    t = (np.arange(steps) / steps)[None, :, None]
    linear, square = end - before, 2 * before - 5 * start + 4 * end - after
    cubic = 3 * start - before - 3 * end + after
    spans = start + 0.5 * t * (linear + t * (square + t * cubic))
    return np.concatenate([spans.reshape(-1, p.shape[1]), p[-2:-1]])


def frames(path: Array, hints: Point) -> tuple[Array, Array]:
    """Unit vectors across a path: the hints made perpendicular to it, and their partners.

    Args:
        path: (N, 3) points [m].
        hints: (N, 3) or (3,) directions, nowhere along the path.

    Returns:
        Two (N, 3) arrays a, b with a x b along the path.
    """
    along = _unit(np.gradient(path, axis=0))
    a = np.broadcast_to(np.asarray(hints, float), path.shape)
    a = _unit(a - (a * along).sum(1, keepdims=True) * along)
    return a, np.cross(along, a)


def tube(path: Array, radii: Array, hints: Point, *, sides: int = 12, flatness: float = 1.0) -> Triangles:
    """A solid tube along a path; radius 0 ends it in a point.

    Args:
        path: (N, 3) points of its axis [m].
        radii: (N,) or (sides, N) [m]; the first side is where the hints point.
        hints: (N, 3) or (3,) directions, nowhere along the path.
        sides: Points around it.
        flatness: Its width across the hints, as a share of that along them.
    """
    a, b = frames(np.asarray(path, float), hints)
    angle = (2 * np.pi * np.arange(sides) / sides)[:, None, None]
    radii = np.broadcast_to(np.asarray(radii, float), (sides, len(path)))[..., None]
    return smooth(swept(path + radii * (np.cos(angle) * a + flatness * np.sin(angle) * b)))


class Clay:
    """A lump of clay in a box of air, worked on by adding and carving."""

    def __init__(self, low: Point, high: Point, cell: float) -> None:
        """Start with air between two corners, on a grid of `cell` metres."""
        self._low, self._cell = np.asarray(low, float), cell
        count = np.ceil((np.asarray(high, float) - self._low) / cell).astype(int) + 1
        self._distance = np.full(tuple(count), FAR)

    def rod(
        self, start: Point, end: Point, radii: tuple[float, float], *, soft: float = 0.0, carve: bool = False
    ) -> None:
        """Add or carve a rod with round ends.

        Args:
            start: Centre of one end [m].
            end: Centre of the other [m].
            radii: Of both ends [m].
            soft: Width over which it melts into what is there [m].
            carve: Take away instead.
        """
        a, b = np.asarray(start, float), np.asarray(end, float)
        block, points = self._near(np.minimum(a, b), np.maximum(a, b), max(radii) + soft)
        axis = b - a
        t = ((points - a) @ axis / max(float(axis @ axis), 1e-12)).clip(0.0, 1.0)
        distance = np.linalg.norm(points - a - t[..., None] * axis, axis=-1)
        self._melt(block, distance - (radii[0] + t * (radii[1] - radii[0])), soft, carve)

    def ball(self, centre: Point, radii: Point | float, *, soft: float = 0.0, carve: bool = False) -> None:
        """Add or carve an ellipsoid along the axes of (3,) radii [m], or a sphere; `soft` as for `rod`."""
        c, r = np.asarray(centre, float), np.broadcast_to(np.asarray(radii, float), 3)
        block, points = self._near(c - r, c + r, soft)
        scaled = np.linalg.norm((points - c) / r, axis=-1)
        slope = np.linalg.norm((points - c) / r**2, axis=-1)
        self._melt(block, scaled * (scaled - 1) / np.maximum(slope, 1e-9), soft, carve)

    def solid(self) -> Triangles:
        """The clay's surface.

        Raises:
            ValueError: Clay touches the edge of the box.
        """
        inside = self._distance < 0
        rim = [np.take(inside, [0, 1, -2, -1], axis=axis).any() for axis in range(3)]
        if any(rim):
            raise ValueError("the clay touches the edge of its box: start with a larger one")
        _make_simple(self._distance)
        # No surface exactly through a grid point: the cells around it would share one vertex's place.
        clear = np.copysign(np.maximum(abs(self._distance), 0.02 * self._cell), self._distance)
        return _surface_net(clear, self._low, self._cell)

    def _near(self, low: Array, high: Array, margin: float) -> tuple[tuple[slice, ...], Array]:
        """Grid slices that hold a box and a margin around it, and the points there [m]."""
        reach = margin + 2 * self._cell
        first = np.floor((low - reach - self._low) / self._cell).astype(int)
        last = np.ceil((high + reach - self._low) / self._cell).astype(int) + 1
        ends = [
            (max(f, 0), max(min(e, n), 0)) for f, e, n in zip(first, last, self._distance.shape, strict=True)
        ]
        ticks = [self._low[k] + self._cell * np.arange(*ends[k]) for k in range(3)]
        return tuple(slice(*e) for e in ends), np.stack(np.meshgrid(*ticks, indexing="ij"), -1)

    def _melt(self, block: tuple[slice, ...], distance: Array, soft: float, carve: bool) -> None:
        """Smooth minimum with what is there (polynomial, after Quilez), or maximum with the negative."""
        sign = -1.0 if carve else 1.0
        old = sign * self._distance[block]
        overlap = np.maximum(soft - abs(old - distance), 0.0)
        blend = overlap**2 / (4 * soft) if soft > 0 else 0.0
        self._distance[block] = sign * (np.minimum(old, distance) - blend)


_CORNERS = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), -1).reshape(8, 3)


def _connected(corners: set[int]) -> bool:
    """Whether corners of a cube hang together along its edges; none do."""
    reached, edge = {min(corners, default=0)}, {min(corners, default=0)}
    while edge:
        edge = {c ^ bit for c in edge for bit in (1, 2, 4)} & corners - reached
        reached |= edge
    return corners <= reached


_SIMPLE = np.array(
    [
        _connected({c for c in range(8) if pattern >> c & 1})
        and _connected({c for c in range(8) if not pattern >> c & 1})
        for pattern in range(256)
    ]
)
"""By which of a cell's corners are clay, whether its surface is one sheet, that one vertex can hold."""


def _make_simple(distance: Array) -> None:
    """Fill, in place, the finest gaps until one sheet of surface at most passes each cell."""
    while True:
        pattern = np.zeros(np.subtract(distance.shape, 1), np.uint8)
        for number, (i, j, k) in enumerate(_CORNERS):
            x, y, z = distance.shape
            pattern |= (distance[i : x - 1 + i, j : y - 1 + j, k : z - 1 + k] < 0).astype(np.uint8) << number
        corners = np.argwhere(~_SIMPLE[pattern])[:, None] + _CORNERS
        if not len(corners):
            return
        values = distance[tuple(corners.transpose(2, 0, 1))]
        nearest = np.where(values < 0, np.inf, values).argmin(1)
        filled = tuple(corners[np.arange(len(corners)), nearest].T)
        distance[filled] = -np.maximum(abs(distance[filled]), 1e-6)


def _surface_net(distance: Array, low: Array, cell: float) -> Triangles:
    """One vertex per grid cell that the surface passes, one quad per grid edge it crosses."""
    inside = distance < 0
    total = np.zeros((*np.subtract(distance.shape, 1), 3))
    number = np.zeros(total.shape[:3], np.int64)
    crossings = []
    for axis in range(3):
        first = np.take(inside, np.arange(distance.shape[axis] - 1), axis=axis)
        second = np.take(inside, np.arange(1, distance.shape[axis]), axis=axis)
        edge = np.argwhere(first != second)
        step = np.eye(3, dtype=int)[axis]
        d0, d1 = distance[tuple(edge.T)], distance[tuple((edge + step).T)]
        where = edge + (d0 / (d0 - d1))[:, None] * step
        b, c = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
        cells = np.stack([edge - b - c, edge - c, edge, edge - b], 1)  # counter-clockwise seen from +axis
        for k in range(4):
            np.add.at(total, tuple(cells[:, k].T), where)
            np.add.at(number, tuple(cells[:, k].T), 1)
        leaving = d0 < 0  # the surface faces +axis
        crossings.append(np.where(leaving[:, None, None], cells, cells[:, ::-1]))
    used = number > 0
    index = np.cumsum(used).reshape(used.shape) - 1
    quads = index[tuple(np.concatenate(crossings).transpose(2, 0, 1))]
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return smooth(Triangles(low + cell * total[used] / number[used][:, None], faces))


def _unit(vectors: Array) -> Array:
    """Each row made one long."""
    lengths: Array = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.maximum(lengths, 1e-20)
