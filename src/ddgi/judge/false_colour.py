"""Numbers as colours.

`INFERNO` runs from black through purple, red and orange to yellow: ten colours of matplotlib's map of
that name (van der Walt and Smith, 2015), whose lightness rises evenly, so that it reads in grey too.
`BLUE_RED` has white in the middle (Brewer's RdBu).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ddgi.judge import digits

INFERNO = ("000004", "1b0c41", "4a0c6b", "781c6d", "a52c60", "cf4446", "ed6925", "fb9b06", "f7d13d", "fcffa4")
"""sRGB, from none to most."""
BLUE_RED = ("2166ac", "f7f7f7", "b2182b")
"""sRGB, from too little to too much."""
HIGHEST = 99.5
"""Percentile that must be within the scale; what lies above has its last colour."""
BAR = 24
"""The scale is one so-manieth of the picture high, if its numbers fit in that."""
MARGIN = 1
"""Around numbers, in their own pixels."""


def scale_top(values: np.ndarray) -> float:
    """Where the scale ends: 1, 2 or 5 times a power of ten, so that similar maps share one."""
    high = float(np.percentile(values, HIGHEST))
    if not high > 0:
        high = float(values.max())
    if not high > 0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(high))
    return float(next(step * power for step in (1, 2, 5, 10) if step * power >= high * (1 - 1e-9)))


def coloured(shares: np.ndarray, codes: Sequence[str]) -> np.ndarray:
    """SRGB values in [0, 1] between colours evenly spaced. shares: (H, W) in [0, 1]; result: (H, W, 3)."""
    table = np.array([[int(code[i : i + 2], 16) / 255 for i in (0, 2, 4)] for code in codes])
    places = np.linspace(0, 1, len(table))
    known = np.nan_to_num(shares)
    return np.stack([np.interp(known, places, table[:, c]) for c in range(3)], 2)


def false_colour(values: np.ndarray, top: float) -> np.ndarray:
    """Colours of a map, with its scale and what that ends at along the bottom.

    Args:
        values: (H, W), 0 or more.
        top: The value that has the last colour.

    Returns:
        (H + bar, W, 3) linear Rec.709, to be saved with the linear curve and an exposure of 0.
    """
    height, width = values.shape
    srgb = np.concatenate([coloured(np.clip(values / top, 0, 1), INFERNO), _scale(height, width, top)])
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    return linear.astype(np.float32)


def _scale(height: int, width: int, top: float) -> np.ndarray:
    """Colours from none to most, with 0 and `top` on them where there is room. (bar, W, 3) sRGB."""
    line = digits.HEIGHT + 2 * MARGIN
    zoom = max(height // BAR // line, 1)
    bar = max(height // BAR, line * zoom)
    colours = np.array(coloured(np.broadcast_to(np.linspace(0, 1, width), (bar, width)), INFERNO))
    none, most = digits.bitmap(0, zoom), digits.bitmap(top, zoom)
    margin = MARGIN * zoom
    if none.shape[1] + most.shape[1] + 4 * margin <= width:
        above = (bar - none.shape[0]) // 2
        rows = colours[above : above + none.shape[0]]
        rows[:, margin : margin + none.shape[1]][none] = 1.0
        rows[:, width - margin - most.shape[1] : width - margin][most] = 0.0
    return colours
