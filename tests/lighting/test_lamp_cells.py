"""Squares of the lamps: every way that light leaves one, once, and evenly."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.lighting import lamp_cells
from ddgi.lighting.lamp_cells import Disc
from ddgi.lighting.lights import delta_light
from probing import floats, load, points, rgb

CUTOFF = 35.0
LAMPS = ("point", "spot", "sun")
SUN = (0.3, -0.9, 0.2)
RADIUS = 1.5
COUNT = 4000


def lamp(kind):
    toward = mi.ScalarTransform4f().look_at([0.5, -1.0, 2.0], [1.0, 1.0, 0.0], [0, 1, 0])
    described = {
        "point": {"type": "point", "position": [0.5, -1.0, 2.0], "intensity": rgb(3.0)},
        "spot": {
            "type": "spot",
            "to_world": toward,
            "intensity": rgb(3.0),
            "cutoff_angle": CUTOFF,
            "beam_width": 20.0,
        },
        "sun": {"type": "directional", "direction": list(SUN), "irradiance": rgb(3.0)},
    }
    scene = load({"type": "scene", "floor": {"type": "rectangle"}, "lamp": described[kind]})
    return delta_light(scene.lights.delta, mi.UInt32(0))


def disc():
    return Disc(mi.Point3f(0.2, 0.4, -0.1), mi.Float(RADIUS))


def squares():
    u = np.random.default_rng(3).uniform(0.001, 0.999, (COUNT, 2))
    return u, mi.Point2f(floats(u[:, 0]), floats(u[:, 1]))


@pytest.mark.parametrize("kind", LAMPS)
def test_the_way_back_leads_to_the_same_place(kind):
    u, square = squares()
    origin, direction = lamp_cells.leave(lamp(kind), square, disc(), mi.Float(4.0))
    length = floats(np.random.default_rng(4).uniform(0.5, 9.0, COUNT))
    found, inside = lamp_cells.square_at(lamp(kind), dr.fma(direction, length, origin), disc())
    # Near the edge of the disc half of a sphere's light, or the far side of a cone, is one place's neighbour.
    assert np.abs(np.array(found, np.float64).T - u).max() < 5e-4
    assert np.array(inside).all()


@pytest.mark.parametrize(
    ("kind", "size"),
    [
        ("point", 4 * np.pi),
        ("spot", 2 * np.pi * (1 - np.cos(np.radians(CUTOFF)))),
        ("sun", np.pi * RADIUS**2),
    ],
)
def test_sizes_and_power(kind, size):
    assert lamp_cells.size(lamp(kind), disc())[0] == pytest.approx(size, rel=1e-5)
    assert lamp_cells.power(lamp(kind), disc())[0] == pytest.approx(3 * size, rel=1e-5)


def test_directions_are_spread_evenly_over_cones():
    """Equal areas are equal solid angles: the mean cosine to a cone's axis is (1 + cos of its edge) / 2."""
    _, square = squares()
    for kind, axis, mean in (
        ("point", (0, -1, 0), 0.0),
        ("spot", (0.5, 2.0, -2.0), (1 + np.cos(np.radians(CUTOFF))) / 2),
    ):
        _, direction = lamp_cells.leave(lamp(kind), square, disc(), mi.Float(4.0))
        along = np.array(direction, np.float64).T @ (np.array(axis) / np.linalg.norm(axis))
        assert along.mean() == pytest.approx(mean, abs=0.03)


def test_distant_light_comes_from_outside_and_fills_the_disc():
    u, square = squares()
    origin, direction = lamp_cells.leave(lamp("sun"), square, disc(), mi.Float(4.0))
    start = np.array(origin, np.float64).T - (0.2, 0.4, -0.1)
    axis = np.array(SUN) / np.linalg.norm(SUN)
    assert (start @ axis < -np.sqrt(3) * 4.0).all()
    aside = np.linalg.norm(start - np.outer(start @ axis, axis), axis=1)
    assert np.allclose(aside, RADIUS * np.abs(2 * u - 1).max(1), atol=1e-3)  # squares around become circles
    assert np.allclose(np.array(direction).T, axis, atol=1e-6)


def test_what_is_outside_of_a_cone_or_disc_is_told():
    _, inside = lamp_cells.square_at(lamp("spot"), points([[0.5, -1.0, 9.0], [1.0, 1.0, 0.0]]), disc())
    assert np.array(inside).tolist() == [False, True]
    _, inside = lamp_cells.square_at(lamp("sun"), points([[3.0, 0.4, -0.1], [0.2, 9.0, 0.0]]), disc())
    assert not np.array(inside)[0]


def test_cells_tile_the_square():
    side = 4
    cells = dr.arange(mi.UInt32, side * side)
    for place in (0.0, 0.37, 0.9999):
        at = lamp_cells.within(cells, mi.Point2f(place, place), side)
        assert (np.array(lamp_cells.cell(at, side)) == np.arange(side * side)).all()
