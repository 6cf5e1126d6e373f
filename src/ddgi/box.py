"""Boxes along the axes."""

from __future__ import annotations

from collections.abc import Sequence

Point = tuple[float, float, float]
Box = tuple[Point, Point]
"""Low and high corner [m]."""


def moved(box: Box, by: Point) -> Box:
    """The box elsewhere."""
    (a, b, c), (d, e, f), (x, y, z) = *box, by
    return (a + x, b + y, c + z), (d + x, e + y, f + z)


def around(boxes: Sequence[Box]) -> Box:
    """The smallest box that holds some boxes, one or more."""
    lows, highs = zip(*boxes, strict=True)
    (a, b, c), (d, e, f) = map(min, zip(*lows, strict=True)), map(max, zip(*highs, strict=True))
    return (a, b, c), (d, e, f)
