"""A guess at what a length of one means, which most files do not say."""

from __future__ import annotations

import math

METRES = {"metres": 1.0, "centimetres": 0.01, "millimetres": 0.001}
SMALLEST, USUAL, LARGEST = 0.5, 6.0, 60.0
"""Longest side of what people light: from a model on a table over a room to a hall [m]."""


def plausible_units(size: float) -> tuple[str, ...]:
    """Units in which a volume of some size is one that people light, the likeliest first; maybe none.

    Args:
        size: The longest side, in units of the scene.
    """
    fitting = [unit for unit, metre in METRES.items() if SMALLEST <= size * metre <= LARGEST]
    return tuple(sorted(fitting, key=lambda unit: abs(math.log(size * METRES[unit] / USUAL))))
