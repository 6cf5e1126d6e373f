"""Bounds on numbers, by comparison and selection.

In place of `dr.maximum`, `dr.minimum` and `dr.clip`: those hand a NaN on, and it would spread through
the field from a single texel. Here a NaN becomes the bound, so that weights cannot be NaN.
"""

from __future__ import annotations

from typing import Any

import drjit as dr


def at_least(x: Any, low: Any) -> Any:
    """The larger of two; `low` where x is NaN."""
    return dr.select(x > low, x, low)


def at_most(x: Any, high: Any) -> Any:
    """The smaller of two; `high` where x is NaN."""
    return dr.select(x < high, x, high)


def clamp(x: Any, low: Any, high: Any) -> Any:
    """X brought into [low, high]; `low` where x is NaN."""
    return at_most(at_least(x, low), high)


def largest(v: Any) -> Any:
    """The largest of the three components of a vector or colour."""
    return at_least(at_least(v[0], v[1]), v[2])
