"""What a reference's own noise adds to figures, told by two halves A and B of independent samples.

The reference is their mean: Var((A + B) / 2) = (Var A + Var B) / 4 = Var(A - B) / 4. Both halves have
the same mean, so the square of their difference is an estimate of Var(A - B), and a quarter of it one of
the reference's own variance.
"""

from __future__ import annotations

import numpy as np

from ddgi.judge.metrics import rel_mse
from ddgi.luminance import LUMINANCE


def luminance_noise(halves: np.ndarray) -> float:
    """Standard error of the mean luminance of N pixels, over that mean: sqrt(sum (Y_A - Y_B)^2) / (2 N mean Y).

    Pixels are taken as independent: the difference of the means alone would be one number, and now and then
    several times too small. halves: (2, H, W, 3); 0 where they are black.
    """
    apart, mean = (halves[0].astype(np.float64) - halves[1]) @ LUMINANCE, (halves.mean(0) @ LUMINANCE).mean()
    return float(np.sqrt((apart**2).sum()) / (2 * apart.size * mean)) if mean > 0 else 0.0


def rel_mse_noise(halves: np.ndarray) -> float:
    """What the noise adds to a picture's `rel_mse`: that between the halves, over 4. halves: (2, H, W, 3)."""
    apart = halves[0].astype(np.float64) - halves[1]
    return rel_mse(apart, halves.mean(0)) / 4
