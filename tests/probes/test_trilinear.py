"""Trilinear weights, of probes that were moved too."""

import itertools

import mitsuba as mi
import numpy as np
import pytest

from ddgi.probes import trilinear

RNG = np.random.default_rng(3)


def weights(place, moved):
    """(N, 8) corrected weights. place: (N, 3); moved: (8, 3), alike for all, or (8, N, 3)."""
    moved = np.broadcast_to(np.reshape(moved, (8, -1, 3)), (8, len(place), 3))
    found = trilinear.corrected(mi.Vector3f(np.array(place).T), [mi.Vector3f(m.T) for m in moved])
    return np.array([np.broadcast_to(np.ravel(w), len(place)) for w in found]).T


def corners():
    return np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], float)


def test_they_stay_between_0_and_1_and_add_up_to_1():
    """What MFF 3.3.1 asks, wherever in their halves eight probes stand."""
    place, moved = RNG.uniform(0, 1, (4000, 3)), RNG.uniform(-0.499, 0.499, (8, 4000, 3))
    w = weights(place, moved)
    assert w.min() >= 0 and w.max() <= 1
    assert np.allclose(w.sum(1), 1, atol=1e-6)


def test_of_probes_in_their_places_they_are_the_common_ones():
    place = RNG.uniform(0, 1, (500, 3))
    common = np.prod(
        [np.where(corners()[:, a], place[:, a, None], 1 - place[:, a, None]) for a in range(3)], 0
    )
    assert np.allclose(weights(place, np.zeros((8, 3))), common, atol=1e-6)
    regular = np.array(trilinear.regular(mi.Vector3f(place.T))).T
    assert np.allclose(regular, common, atol=1e-6)


@pytest.mark.parametrize("k", range(8))
def test_where_a_probe_stands_it_counts_alone(k):
    """Wherever in the cell it was moved to."""
    moved = np.zeros((8, 3))
    moved[k] = (0.5 - corners()[k]) * [0.6, 0.4, 0.8]  # inwards
    at = corners()[k] + moved[k]
    assert weights(at[None], moved)[0, k] == pytest.approx(1, abs=1e-5)


def test_between_two_moved_probes_the_light_of_a_ramp_is_read_right():
    """Along an edge: probes at 0.2 and 0.9 of it, whose values are their coordinates."""
    moved = np.zeros((8, 3))
    moved[::2, 0], moved[1::2, 0] = 0.2, -0.1
    x = np.linspace(0, 1, 50)
    w = weights(np.stack([x, 0 * x + 0.3, 0 * x + 0.6], 1), moved)
    assert np.allclose(w @ (corners()[:, 0] + moved[:, 0]), np.clip(x, 0.2, 0.9), atol=1e-5)


@pytest.mark.parametrize("axis", range(3))
def test_they_do_not_jump_between_cells(axis):
    """On the face between two cells, whose twelve probes stand anywhere in their halves."""
    counts = np.array([2, 2, 2])
    counts[axis] = 3
    moved = {n: RNG.uniform(-0.45, 0.45, 3) for n in itertools.product(*(range(c) for c in counts))}
    at = RNG.uniform(0, 1, (200, 3))
    found = []
    for cell in (0, 1):
        base = np.zeros(3, int)
        base[axis] = cell
        at[:, axis] = 1 - cell
        numbers = [tuple(int(c) for c in base + corner) for corner in corners().astype(int)]
        w = weights(at, np.array([moved[n] for n in numbers]))
        found.append({n: w[:, k] for k, n in enumerate(numbers)})
    for n in moved:
        assert np.allclose(found[0].get(n, 0), found[1].get(n, 0), atol=1e-5), n
