"""Probe directions: evenly spread, and turned afresh each frame."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.probes.directions import fibonacci, frame_directions, random_rotation
from ddgi.sampling import clock
from probing import many_ticks

TICKS = 20_000


def rotations(count, seed=0):
    """(count, 3, 3), one per tick."""
    return np.moveaxis(np.array(random_rotation(many_ticks(count, seed)), np.float64), -1, 0)


@pytest.mark.parametrize("count", [8, 31, 128, 4096])
def test_fibonacci_set_against_its_formula(count):
    """CTU eq. 4.1 to 4.3 in double precision: z_i = 1 - (2 i + 1)/n, phi_i = 2 pi frac(i / golden ratio)."""
    i = np.arange(count)
    golden = (1 + np.sqrt(5)) / 2
    phi, z = 2 * np.pi * ((i / golden) % 1), 1 - (2 * i + 1) / count
    r = np.sqrt(1 - z * z)
    expected = np.stack([np.cos(phi) * r, np.sin(phi) * r, z], 1)
    # The golden ratio is kept as a 32-bit fraction: its error grows with i, 2 pi i 2^-33, beside rounding.
    assert (
        np.abs(np.array(fibonacci(count), np.float64).T - expected).max()
        <= 2e-6 + 2 * np.pi * count * 2.0**-32
    )


@pytest.mark.parametrize("count", [8, 64, 128, 1000])
def test_fibonacci_set_is_balanced(count):
    v = np.array(fibonacci(count), np.float64).T
    assert np.abs(np.linalg.norm(v, axis=1) - 1).max() <= 1e-6
    # A quadrature of n points with one point per equal area: the error falls as 1/n.
    assert np.linalg.norm(v.mean(0)) <= 2 / count
    assert np.abs(v.T @ v / count - np.eye(3) / 3).max() <= 2 / count


def test_fibonacci_points_keep_apart():
    v = np.array(fibonacci(256), np.float64).T
    cosine = v @ v.T - 2 * np.eye(256)
    nearest = np.arccos(np.clip(cosine.max(1), -1, 1))
    # Ideal packing is about sqrt(8 pi / (sqrt(3) n)) = 0.238 apart; random points often less than 0.02.
    assert nearest.min() >= 0.5 * np.sqrt(8 * np.pi / (np.sqrt(3) * 256))


def test_rotations_are_rotations():
    m = rotations(2000)
    assert np.abs(m @ m.transpose(0, 2, 1) - np.eye(3)).max() <= 2e-6
    assert np.abs(np.linalg.det(m) - 1).max() <= 2e-6


def test_rotations_are_uniform():
    """Moments of the uniform distribution: mean 0, E[R_ij^2] = 1/3, E[trace] = 0, E[trace^2] = 1."""
    m = rotations(TICKS)
    spread = 4.5 / np.sqrt(TICKS)  # 4.5 standard errors: 20 numbers are compared
    assert np.abs(m.mean(0)).max() <= spread * np.sqrt(1 / 3)
    # Var(R_ij^2) = 1/5 - 1/9 (a squared coordinate of a uniform direction).
    assert np.abs((m**2).mean(0) - 1 / 3).max() <= spread * np.sqrt(1 / 5 - 1 / 9)
    trace = np.trace(m, axis1=1, axis2=2)
    assert abs(trace.mean()) <= spread
    assert abs((trace**2).mean() - 1) <= spread * np.sqrt(np.var(trace**2))


def test_each_tick_turns_anew():
    m = rotations(3000).reshape(3000, 9)
    change = np.abs(np.diff(m, axis=0)).max(1)
    assert change.min() > 1e-3


def test_successive_ticks_fill_the_gaps():
    """Means over 32 ticks scatter less than three quarters as much as those of independent rotations, sqrt(1 / (3 * 32))."""
    means = rotations(3008).reshape(94, 32, 9).mean(1)
    assert np.sqrt((means**2).mean()) < 0.75 * np.sqrt(1 / (3 * 32))


def test_seed_and_tick_decide():
    a, b = (np.array(frame_directions(64, clock(7, 11))) for _ in range(2))
    assert np.array_equal(a, b)
    for seed, tick in ((8, 11), (7, 12)):
        assert np.abs(np.array(frame_directions(64, clock(seed, tick))) - a).max() > 0.1


def test_turning_keeps_the_shape():
    v, w = np.array(fibonacci(64), np.float64).T, np.array(frame_directions(64, clock(0, 3)), np.float64).T
    assert np.abs(v @ v.T - w @ w.T).max() <= 2e-6


def test_late_ticks_are_as_good():
    m = np.array(random_rotation(clock(0, 3_000_000_000)), np.float64)[..., 0]
    assert np.abs(m @ m.T - np.eye(3)).max() <= 2e-6
    assert isinstance(random_rotation(clock(0, 1)), mi.Matrix3f)
