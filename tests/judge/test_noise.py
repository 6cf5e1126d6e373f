"""A reference's noise, of synthetic halves whose variance is known."""

import numpy as np
import pytest

from ddgi.judge.metrics import difference
from ddgi.judge.noise import luminance_noise, rel_mse_noise
from ddgi.luminance import LUMINANCE

LEVEL, SPREAD, SIDE = 0.5, 0.02, 96
"""Grey, and the standard deviation of each value of each half around it."""


def halves(seed=0):
    noise = np.random.default_rng(seed).normal(0, SPREAD, (2, SIDE, SIDE, 3))
    return (LEVEL + noise).astype(np.float32)


def test_rel_mse_is_the_variance_of_the_mean_over_the_square_of_the_level():
    # 27,648 values: a relative standard error of sqrt(2 / 27648), 1 %.
    expected = SPREAD**2 / 2 / (LEVEL**2 * 1.01)
    assert rel_mse_noise(halves()) == pytest.approx(expected, rel=0.05)


def test_rel_mse_is_what_the_noise_adds():
    """The true picture, held against the noisy reference."""
    both = halves()
    truth = np.full((SIDE, SIDE, 3), LEVEL, np.float32)
    assert rel_mse_noise(both) == pytest.approx(difference(truth, both.mean(0)).rel_mse, rel=0.05)


def test_luminance_is_the_standard_error_of_the_mean():
    expected = SPREAD**2 / 2 / SIDE**2 * (LUMINANCE.astype(np.float64) ** 2).sum() / LEVEL**2
    for seed in range(5):  # 9,216 pixels: it has a relative standard error of sqrt(1 / 18432), 0.7 %
        assert luminance_noise(halves(seed)) == pytest.approx(np.sqrt(expected), rel=0.05)


def test_luminance_noise_is_what_means_scatter_by():
    means = [(halves(seed).mean(0) @ LUMINANCE).mean() / LEVEL for seed in range(100)]
    assert np.std(means) == pytest.approx(luminance_noise(halves()), rel=0.3)


def test_no_noise_and_no_light_add_nothing():
    for level in (0.0, 0.5):
        same = np.full((2, 4, 4, 3), level, np.float32)
        assert luminance_noise(same) == rel_mse_noise(same) == 0
