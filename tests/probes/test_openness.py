"""How much room there is around places, against what can be worked out on paper."""

import math

import mitsuba as mi
import numpy as np
import pytest

from ddgi.probes import openness
from probing import dark_light, diffuse, load

HALF_ROOM = 2 * (1 - math.log(2))
"""Of a plane as far away as `nearby`: the integral of 2 c h / (h + h c) over c from 0 to 1."""


def over_a_plane():
    """A sheet of 200 m at y = 0."""
    turn = mi.ScalarTransform4f().rotate([1, 0, 0], -90).scale(100)
    return load(
        {
            "type": "scene",
            "light": dark_light() | {"position": [0.0, 5.0, 0.0]},
            "floor": {"type": "rectangle", "to_world": turn, "bsdf": diffuse(0.5, two_sided=True)},
        }
    ).tracer


def facing(open_places, normal):
    return np.array(open_places.along(mi.UInt32([0]), mi.Vector3f(np.array([normal], float).T)))[0]


def test_openness_over_a_plane():
    found = openness.of_places(over_a_plane(), mi.Point3f([3.0], [0.5], [2.0]), 0.5)
    assert facing(found, (0, 1, 0)) == pytest.approx(1, abs=1e-3)
    assert facing(found, (0, -1, 0)) == pytest.approx(HALF_ROOM, abs=0.02)
    sideways = facing(found, (1, 0, 0))
    assert facing(found, (0, -1, 0)) < sideways < 1
    # Between the axes it is between them.
    slant = facing(found, (math.sqrt(0.5), math.sqrt(0.5), 0))
    assert slant == pytest.approx((1 + sideways) / 2, abs=1e-3)
    assert np.array(found.nearest)[0] == pytest.approx(0.5, rel=0.05)


def test_nearby_is_the_distance_that_takes_half_of_the_room():
    near, far = (
        facing(openness.of_places(over_a_plane(), mi.Point3f([0.0], [0.5], [0.0]), n), (0, -1, 0))
        for n in (0.01, 10.0)
    )
    assert near > 0.97
    assert far < 0.1


def test_surfaces_have_the_room_they_face():
    start, up, down = mi.Point3f([0.0], [0.5], [0.0]), mi.Vector3f(0, 1, 0), mi.Vector3f(0, -1, 0)
    of = [np.array(openness.of_surfaces(over_a_plane(), start, normal, 0.5))[0] for normal in (up, down)]
    assert of[0] == pytest.approx(1, abs=1e-3)
    assert of[1] == pytest.approx(HALF_ROOM, abs=0.02)
