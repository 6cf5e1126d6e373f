"""Boxes along the axes."""

from __future__ import annotations

Point = tuple[float, float, float]
Box = tuple[Point, Point]
"""Low and high corner [m]."""
