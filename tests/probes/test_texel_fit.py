"""Fitted texels read, between them, what they should; exact ones read less at every peak."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.probes.directions import fibonacci
from ddgi.probes.octahedral import direction_to_square, interior, texel_at, texel_directions
from ddgi.probes.texel_fit import texel_fit

SIZES = [3, 4, 6, 8, 16]
AXES = [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, -1, 0)]


def fitted(size, values):
    """Texels (T, C), fitted."""
    table = mi.TensorXf(np.ascontiguousarray(values, np.float32))
    return np.array(texel_fit(size).apply(table))


def look_up(values, size, directions):
    """Bilinear reads of a map without its border, (N, C)."""
    first, (x, y) = texel_at(direction_to_square(directions), size)
    corner = lambda step: values[np.array(interior(first + step, size))]  # noqa: E731
    x, y = np.array(x)[:, None], np.array(y)[:, None]
    upper = corner(0) * (1 - x) + corner(1) * x
    lower = corner(size + 2) * (1 - x) + corner(size + 3) * x
    return upper * (1 - y) + lower * y


def lobes(directions, towards):
    """Clamped cosines, (N, C)."""
    return np.maximum(np.array(directions).T @ np.asarray(towards, np.float64).T, 0)


@pytest.mark.parametrize("size", [2, *SIZES, 32])
def test_keeps_what_is_the_same_everywhere(size):
    assert np.allclose(fitted(size, np.ones((size * size, 2))), 1, atol=2e-6)


def test_leaves_maps_alone_that_are_too_small():
    values = np.random.default_rng(1).random((4, 3))
    assert np.allclose(fitted(2, values), values)


@pytest.mark.parametrize("size", SIZES)
def test_cosine_lobes_read_nearer_to_the_truth(size):
    everywhere, light = fibonacci(4000), np.array(fibonacci(100)).T
    exact, truth = lobes(texel_directions(size), light), lobes(everywhere, light)
    error = lambda values: np.sqrt(np.mean((look_up(values, size, everywhere) - truth) ** 2))  # noqa: E731
    assert error(fitted(size, exact)) < 0.85 * error(exact)


def test_the_peaks_along_the_axes():
    """Light from a hemisphere, E / pi = 1 at its pole: what interpolation flattens most."""
    light = np.array(fibonacci(4000)).T
    poles = mi.Vector3f(*np.array(AXES, np.float32).T)
    above = lobes(mi.Vector3f(*np.array(AXES, np.float32).T), light) > 0
    share = 4 / len(light)
    exact = share * lobes(texel_directions(8), light) @ above.T
    own = lambda values: np.diag(look_up(values, 8, poles))  # noqa: E731
    assert own(exact)[:2] == pytest.approx(0.988, abs=0.004)
    assert own(fitted(8, exact)) == pytest.approx(1, abs=0.005)


def test_what_is_finer_than_the_harmonics_stays():
    """A map that no harmonic up to the second order finds anything in."""
    fit = texel_fit(8)
    harmonics = np.array(fit.harmonics, np.float64)
    noise = np.random.default_rng(2).standard_normal((64, 3))
    rest = noise - np.linalg.pinv(harmonics) @ harmonics @ noise
    assert np.allclose(fitted(8, rest), rest, atol=1e-5)
