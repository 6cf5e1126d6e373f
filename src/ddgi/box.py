"""Boxes along the axes."""

from __future__ import annotations

Point = tuple[float, float, float]
Box = tuple[Point, Point]
"""Low and high corner [m]."""


def moved(box: Box, by: Point) -> Box:
    """The box elsewhere."""
    (a, b, c), (d, e, f), (x, y, z) = *box, by
    return (a + x, b + y, c + z), (d + x, e + y, f + z)
