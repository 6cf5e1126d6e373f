"""A map of numbers as a picture: black, purple, red, orange, yellow, with its scale along the bottom.

The colours are ten of matplotlib's `inferno` (van der Walt and Smith, 2015): lightness rises evenly, so
the picture reads in grey too.
"""

from __future__ import annotations

import numpy as np

INFERNO = ("000004", "1b0c41", "4a0c6b", "781c6d", "a52c60", "cf4446", "ed6925", "fb9b06", "f7d13d", "fcffa4")
"""sRGB, from none to most."""
HIGHEST = 99.5
"""Percentile that must be within the scale; what lies above has its last colour."""
BAR = 24
"""The scale is one so-manieth of the picture high."""


def scale_top(values: np.ndarray) -> float:
    """Where the scale ends: 1, 2 or 5 times a power of ten, so that similar maps share one."""
    high = float(np.percentile(values, HIGHEST))
    if not high > 0:
        high = float(values.max())
    if not high > 0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(high))
    return float(next(step * power for step in (1, 2, 5, 10) if step * power >= high * (1 - 1e-9)))


def false_colour(values: np.ndarray, top: float) -> np.ndarray:
    """Colours of a map.

    Args:
        values: (H, W), 0 or more.
        top: The value that has the last colour.

    Returns:
        (H + bar, W, 3) linear Rec.709, to be saved with the linear curve and an exposure of 0.
    """
    height, width = values.shape
    bar = np.broadcast_to(np.linspace(0, top, width), (max(height // BAR, 4), width))
    shares = np.clip(np.concatenate([values, bar]) / top, 0, 1)
    table = np.array([[int(code[i : i + 2], 16) / 255 for i in (0, 2, 4)] for code in INFERNO])
    srgb = np.stack([np.interp(shares, np.linspace(0, 1, len(table)), table[:, c]) for c in range(3)], 2)
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    return linear.astype(np.float32)
