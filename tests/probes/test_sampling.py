"""Random numbers: reproducible, uniform, independent between streams, evenly spread where promised."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi import sampling
from ddgi.sampling import Clock, clock, low_discrepancy_2d, uniform_2d
from probing import many_ticks

N = 1 << 16
STREAMS = range(9)


def draw(seed=0, tick=0, stream=0, count=N):
    return np.array(uniform_2d(clock(seed, tick), stream, dr.arange(mi.UInt32, count)), np.float64)


def sequence(first, count, seed=0, index=0, stream=0):
    """(count, 2) successive samples of one index."""
    samples = dr.arange(mi.UInt32, count) + first
    return np.array(low_discrepancy_2d(clock(seed, 5), stream, mi.UInt32(index), samples), np.float64).T


def test_same_arguments_same_numbers():
    assert np.array_equal(draw(3, 4, 5), draw(3, 4, 5))


@pytest.mark.parametrize("other", [{"seed": 1}, {"tick": 1}, {"stream": 1}])
def test_each_argument_counts(other):
    a, b = draw(), draw(**other)
    assert (a == b).mean() < 1e-3
    # Uncorrelated: the correlation of N independent pairs has a standard error of 1/sqrt(N).
    assert abs(np.corrcoef(a[0], b[0])[0, 1]) < 4.5 / np.sqrt(N)


def test_uniform_in_the_square():
    u = draw(9, 2, 3)
    assert u.min() >= 0
    assert u.max() < 1
    counts = np.histogram2d(u[0], u[1], bins=16, range=((0, 1), (0, 1)))[0]
    chi2 = ((counts - N / 256) ** 2 / (N / 256)).sum()
    assert abs(chi2 - 255) < 4.5 * np.sqrt(2 * 255)  # chi-square of 255 degrees of freedom


def test_streams_are_independent():
    u = np.stack([draw(stream=s)[0] for s in STREAMS])
    correlation = np.corrcoef(u) - np.eye(len(u))
    assert np.abs(correlation).max() < 4.5 / np.sqrt(N)


def test_streams_have_distinct_numbers():
    names = [n for n in vars(sampling) if n.isupper() and not n.startswith("_")]
    codes = [getattr(sampling, n) for n in names]
    assert len(set(codes)) == len(codes)
    assert max(codes) < sampling._STREAMS


def test_ticks_are_independent():
    u = np.array(uniform_2d(many_ticks(N), 3, mi.UInt32(17)), np.float64)[0]
    assert abs(np.corrcoef(u[1:], u[:-1])[0, 1]) < 4.5 / np.sqrt(N)
    assert abs(u.mean() - 0.5) < 4.5 * np.sqrt(1 / 12 / N)


def discrepancy(x):
    """L2 star discrepancy (Warnock's formula): how unevenly points fill the boxes at the origin."""
    n, d = x.shape
    pairs = (1 - np.maximum(x[:, None], x[None])).prod(-1).sum() / n**2
    return np.sqrt(3.0**-d - 2.0 ** (1 - d) / n * (1 - x**2).prod(1).sum() + pairs)


@pytest.mark.parametrize("first", [0, 1_000_003, 3_999_999_000])
def test_low_discrepancy_fills_evenly(first):
    """The discrepancy of 256 points of R2 is several times below that of random ones, at any tick."""
    ours = discrepancy(sequence(first, 256))
    random = np.median([discrepancy(np.random.default_rng(i).uniform(size=(256, 2))) for i in range(20)])
    assert ours < 0.4 * random


@pytest.mark.parametrize("first", [0, 1 << 20, 3_000_000_000 // 256 * 256])
def test_low_discrepancy_leaves_no_cell_out(first):
    """A (0, 2)-sequence: of 256 aligned samples one falls into each cell of 16 x 16, of 16 one of 4 x 4."""
    x = sequence(first, 256, index=3)
    for count, n in ((256, 16), (16, 4)):
        cells = np.floor(x[:count] * n).astype(int)
        assert len(set(map(tuple, cells))) == count


def test_low_discrepancy_stays_in_the_square():
    x = sequence(0, 1 << 16)
    assert x.min() >= 0
    assert x.max() < 1


def test_low_discrepancy_shifts_differ_by_index_stream_and_seed():
    here = sequence(0, 1)
    for other in ({"index": 1}, {"stream": 1}, {"seed": 1}):
        assert np.abs(sequence(0, 1, **other) - here).max() > 1e-3


def test_low_discrepancy_does_not_depend_on_the_clock_tick():
    """Else every frame would start another sequence, and the mean over frames would be plain random."""
    at = [
        np.array(
            low_discrepancy_2d(Clock(mi.UInt32(0), mi.UInt32(t)), 3, dr.arange(mi.UInt32, 8), mi.UInt32(4))
        )
        for t in (0, 9)
    ]
    assert np.array_equal(*at)


def test_low_discrepancy_means_converge_faster():
    """The mean of x y over 256 samples: error below a third of the random one's, 0.22 / sqrt(256)."""
    lane = dr.arange(mi.UInt32, 512 * 256)
    x, y = np.array(low_discrepancy_2d(clock(0, 0), 2, lane // 256, lane % 256), np.float64)
    error = np.sqrt(np.mean(((x * y).reshape(512, 256).mean(1) - 0.25) ** 2))
    assert error < 0.22 / 16 / 3


def kronecker(first, count, index=0, stream=0):
    samples = dr.arange(mi.UInt32, count) + first
    return np.array(sampling.kronecker_2d(clock(0, 5), stream, mi.UInt32(index), samples), np.float64).T


@pytest.mark.parametrize("first", [0, 777, 4_000_000_000])
def test_kronecker_points_fill_evenly(first):
    """Of 1,024 points in a row each of 64 cells has its 16, but for two or three."""
    points = kronecker(first, 1024)
    assert points.min() >= 0 and points.max() < 1
    counts, *_ = np.histogram2d(*points.T, bins=8, range=[[0, 1], [0, 1]])
    assert np.abs(counts - 16).max() <= 4


@pytest.mark.parametrize("index", range(4))
def test_kronecker_and_low_discrepancy_points_are_independent(index):
    """Halves of the one fall evenly on halves of the other, as those of two scrambled Sobol sequences do not."""
    ours, theirs = kronecker(0, 1024, index), sequence(0, 1024, index=index, stream=3)
    other = sequence(0, 1024, index=2 * index + 1, stream=3)
    together = lambda a, b: ((a < 0.5) == (b < 0.5)).mean()  # noqa: E731
    for i in range(2):
        for j in range(2):
            assert together(ours[:, i], theirs[:, j]) == pytest.approx(0.5, abs=0.03)
    assert together(theirs[:, 0], other[:, 0]) in (0.0, 1.0)
