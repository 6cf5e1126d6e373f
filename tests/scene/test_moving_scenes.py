"""The built-in scenes that move by themselves: what is where, and when."""

import numpy as np
import pytest

from ddgi.scene.library import BUILT_IN
from ddgi.scene.library.ceiling_caves_in import FALLS_AT, GRAVITY, LASTS
from ddgi.scene.library.ceiling_hole import HIGH, HOLE
from ddgi.scene.library.color_boxes import TRAVEL
from ddgi.scene.library.flashlight import HELD
from ddgi.scene.library.flashlight import LASTS as LOOKS
from ddgi.scene.load import load_scene

MOVING = {"beach-balls": 200, "ceiling-caves-in": 1, "color-boxes": 0, "flashlight": 0}
"""How many shapes of each scene can move; lights do in the others."""


@pytest.mark.parametrize("name", MOVING)
def test_scenes_that_move_say_so(name):
    scene = load_scene(name, size=(16, 9))
    stage = scene.motion.stage
    assert (0 if stage is None else len(stage.names)) == MOVING[name]
    assert len(scene.rig.clips) == 1
    assert scene.rig.clips[0].duration >= 4
    assert scene.at(scene.rig.clips[0].duration) is not None


def test_those_that_do_not_have_no_animation():
    assert {name for name, scene in BUILT_IN.items() if scene.build().rig is not None} == set(MOVING)


def slab(scene, time):
    return np.array(scene.at(time).motion.stage.boxes(scene.at(time).pose)["slab"])


def test_the_slab_shuts_the_opening_falls_and_lies_on_the_floor():
    scene = load_scene("ceiling-caves-in", size=(16, 9))
    (x0, z0), (x1, z1) = HOLE
    for time in (0.0, FALLS_AT):
        np.testing.assert_allclose(slab(scene, time)[0], [x0, HIGH[1], z0], atol=0.01)
        np.testing.assert_allclose(slab(scene, time)[1, ::2], [x1, z1], atol=0.01)
    falling = 0.5
    middle = slab(scene, FALLS_AT + falling).mean(0)[1]
    assert middle == pytest.approx(HIGH[1] + 0.1 - 0.5 * GRAVITY * falling**2, abs=0.02)
    assert slab(scene, LASTS)[0, 1] == pytest.approx(0, abs=1e-4)


def test_the_flashlight_comes_back_and_looks_both_ways():
    scene = load_scene("flashlight", size=(16, 9))
    light = lambda t: np.array(scene.at(t).lights.delta.direction)[:3]  # noqa: E731
    place = lambda t: np.array(scene.at(t).lights.delta.position)[:3]  # noqa: E731
    np.testing.assert_allclose(place(0), HELD, atol=1e-5)
    np.testing.assert_allclose(place(LOOKS), HELD, atol=1e-5)
    np.testing.assert_allclose(light(LOOKS), light(0), atol=1e-5)
    assert np.linalg.norm(light(LOOKS / 4)) == pytest.approx(1, abs=1e-5)
    turn = [np.degrees(np.arctan2(*(light(t)[[0, 2]]))) for t in (0, LOOKS / 4, 3 * LOOKS / 4)]
    apart = (np.array(turn[1:]) - turn[0] + 180) % 360 - 180
    assert sorted(np.round(apart)) == [-55, 55]


def test_the_spotlight_goes_from_one_object_to_the_other():
    scene = load_scene("color-boxes", size=(16, 9))
    at = lambda t: np.array(scene.at(t).lights.delta.position)[:3]  # noqa: E731
    np.testing.assert_allclose(at(2) - at(0), [TRAVEL, 0, 0], atol=1e-5)
    np.testing.assert_allclose(at(4), at(0), atol=1e-5)
