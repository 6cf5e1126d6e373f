"""What a reference's own noise adds to figures, told by two halves A and B of independent samples.

The reference is their mean: Var((A + B) / 2) = (Var A + Var B) / 4 = Var(A - B) / 4. Both halves have
the same mean, so the square of their difference is an estimate of Var(A - B), and a quarter of it one of
the reference's own variance.
"""

from __future__ import annotations

import numpy as np

from ddgi.judge.metrics import luminance_error, rel_mse


def luminance_noise(halves: np.ndarray) -> float:
    """Standard error of the mean luminance, over that mean: |mean Y_A - mean Y_B| / (2 mean Y).

    Args:
        halves: (2, H, W, 3).

    Returns:
        An estimate from one difference: right on average, now and then several times too small.
    """
    # Of the mean picture, A misses by half of what it misses of B.
    return abs(luminance_error(halves[0], halves.mean(0)))


def rel_mse_noise(halves: np.ndarray) -> float:
    """What the noise adds to a picture's `rel_mse`: that between the halves, over 4. halves: (2, H, W, 3)."""
    apart = halves[0].astype(np.float64) - halves[1]
    return rel_mse(apart, halves.mean(0)) / 4
