"""The octahedral map: a bijection between sphere and square, seamless at the square's edges."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.probes.octahedral import (
    bordered,
    direction_to_square,
    interior,
    square_to_direction,
    texel_directions,
)
from probing import points, sphere_points

# float32 has 24 bits; a few roundings of numbers up to 1, each off by 6e-8.
ROUNDING = 1e-6

AXES = np.concatenate([np.eye(3), -np.eye(3)])
FOLDS = np.array(
    [(x, y, 0) for x in (-0.6, 0.6) for y in (-0.8, 0.8)]  # the outline of the upper half
    + [(x, 0, z) for x in (-0.6, 0.6) for z in (-0.8, 0.8)]
    + [(0, y, z) for y in (-0.6, 0.6) for z in (-0.8, 0.8)]
)
NEAR_POLES = np.array(
    [(1e-4, -2e-5, 1), (1e-4, -2e-5, -1), (-1e-6, 3e-7, -1), (1, 1e-6, -1e-6), (1e-6, -1, 1e-6)]
)


def angle(a, b):
    """Between unit vectors, in double precision: exact for small angles."""
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(a * b, axis=-1))


def to_numpy(v):
    return np.array(v, np.float64).T


def test_directions_survive_the_round_trip():
    v = np.concatenate([sphere_points(20000), AXES, FOLDS, NEAR_POLES])
    v = (v / np.linalg.norm(v, axis=1, keepdims=True)).astype(np.float32).astype(np.float64)
    back = to_numpy(square_to_direction(direction_to_square(mi.Vector3f(points(v)))))
    assert angle(v / np.linalg.norm(v, axis=1, keepdims=True), back).max() <= ROUNDING
    assert np.abs(np.linalg.norm(back, axis=1) - 1).max() <= ROUNDING


def test_squares_survive_the_round_trip():
    inside = np.random.default_rng(2).uniform(-1, 1, (20000, 2)).astype(np.float32)
    back = to_numpy(direction_to_square(square_to_direction(mi.Vector2f(*map(mi.Float, inside.T)))))
    assert np.abs(back - inside).max() <= ROUNDING


def test_length_does_not_matter():
    v = mi.Vector3f(points(sphere_points(1000)))
    assert (
        np.abs(to_numpy(direction_to_square(v)) - to_numpy(direction_to_square(v * 1e-4))).max() <= ROUNDING
    )
    assert np.abs(to_numpy(direction_to_square(v)) - to_numpy(direction_to_square(v * 1e6))).max() <= ROUNDING


def test_no_direction_stays_a_number():
    assert np.isfinite(to_numpy(direction_to_square(mi.Vector3f(0, 0, 0)))).all()


@pytest.mark.parametrize(
    ("square", "direction"),
    [
        ((0, 0), (0, 0, 1)),  # middle: +z
        ((1, 0), (1, 0, 0)),  # middles of the edges: the equator's axes
        ((-1, 0), (-1, 0, 0)),
        ((0, 1), (0, 1, 0)),
        ((0, -1), (0, -1, 0)),
        ((1, 1), (0, 0, -1)),  # all four corners: -z
        ((-1, 1), (0, 0, -1)),
        ((1, -1), (0, 0, -1)),
        ((-1, -1), (0, 0, -1)),
        ((0.5, 0.5), (np.sqrt(0.5), np.sqrt(0.5), 0)),  # middle of a fold
    ],
)
def test_places_known_on_paper(square, direction):
    assert angle(to_numpy(square_to_direction(mi.Vector2f(*square)))[0], np.array(direction)) <= ROUNDING


def test_edges_meet_their_own_mirror_image():
    t = np.linspace(-1, 1, 201)
    one = np.ones_like(t)
    for edge in (one, -one):
        for a, b in (((edge, t), (edge, -t)), ((t, edge), (-t, edge))):
            a, b = (to_numpy(square_to_direction(mi.Vector2f(*map(mi.Float, side)))) for side in (a, b))
            assert angle(a, b).max() <= ROUNDING


@pytest.mark.parametrize("size", range(2, 17))
def test_interior_undoes_bordered(size):
    texel = np.arange(size * size)
    place = np.array(bordered(mi.UInt32(texel), size))
    assert np.array_equal(np.array(interior(mi.UInt32(place), size)), texel)
    assert np.array_equal(place, (texel // size + 1) * (size + 2) + texel % size + 1)
    every = np.array(interior(mi.UInt32(np.arange((size + 2) ** 2)), size))
    assert every.min() >= 0
    assert every.max() < size * size


@pytest.mark.parametrize("size", range(2, 17))
def test_interpolation_is_seamless(size):
    """Whatever the texels hold, both sides of an edge interpolate to the same value where they meet."""
    texels = np.random.default_rng(size).uniform(0, 1, size * size)
    wide = texels[np.array(interior(mi.UInt32(np.arange((size + 2) ** 2)), size))].reshape(size + 2, size + 2)
    t = np.linspace(-1, 1, 97)
    one = np.ones_like(t)
    for edge in (one, -one):
        assert np.allclose(bilinear(wide, edge, t), bilinear(wide, edge, -t), atol=1e-12)
        assert np.allclose(bilinear(wide, t, edge), bilinear(wide, -t, edge), atol=1e-12)
    corners = [bilinear(wide, np.array([x]), np.array([y]))[0] for x in (-1, 1) for y in (-1, 1)]
    assert np.ptp(corners) <= 1e-12


@pytest.mark.parametrize("size", [2, 5, 8, 13])
def test_a_smooth_function_stays_smooth_across_the_edges(size):
    """Neighbours across an edge hold neighbouring directions: no jump beyond what a texel spans."""
    centres = to_numpy(texel_directions(size))
    wide = centres[np.array(interior(mi.UInt32(np.arange((size + 2) ** 2)), size))].reshape(
        size + 2, size + 2, 3
    )
    inside = max(np.abs(np.diff(wide[1:-1, 1:-1], axis=axis)).max() for axis in (0, 1))
    across = max(
        np.abs(wide[0] - wide[1])[1:-1].max(), np.abs(wide[-1] - wide[-2])[1:-1].max(),
        np.abs(wide[:, 0] - wide[:, 1])[1:-1].max(), np.abs(wide[:, -1] - wide[:, -2])[1:-1].max(),
    )  # fmt: skip
    # Two texels per side lie a quarter turn apart.
    assert across <= 1.01 * (np.sqrt(2) if size == 2 else inside)


@pytest.mark.parametrize("size", [2, 3, 8])
def test_texel_directions_are_the_centres(size):
    i = (np.arange(size) + 0.5) * 2 / size - 1
    x, y = np.meshgrid(i, i)  # rows along y
    expected = to_numpy(square_to_direction(mi.Vector2f(mi.Float(x.ravel()), mi.Float(y.ravel()))))
    assert angle(to_numpy(texel_directions(size)), expected).max() <= ROUNDING


def bilinear(wide, x, y):
    """Texels of a bordered map at places of the square, by NumPy."""
    n = wide.shape[0] - 2
    px, py = (x + 1) / 2 * n + 0.5, (y + 1) / 2 * n + 0.5
    c, r = np.floor(px).astype(int), np.floor(py).astype(int)
    fx, fy = px - c, py - r
    c1, r1 = np.minimum(c + 1, n + 1), np.minimum(r + 1, n + 1)
    return (
        wide[r, c] * (1 - fx) * (1 - fy) + wide[r, c1] * fx * (1 - fy)
        + wide[r1, c] * (1 - fx) * fy + wide[r1, c1] * fx * fy
    )  # fmt: skip
