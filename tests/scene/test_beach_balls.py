"""A hundred balls in a yard: they stay in it, lose energy, and are the same on every run."""

import numpy as np

from ddgi.scene.library.beach_balls import RADIUS, YARD, _start
from ddgi.scene.library.tumbling import GRAVITY, Yard, tumble
from ddgi.scene.load import load_scene

OPEN = Yard((-1e3, -1e3), (1e3, 1e3))


def tumbled(seconds=2.0, balls=40, seed=7):
    return tumble(YARD, _start(balls, seed), RADIUS, seconds, 60, seed)


def test_the_same_on_every_run_and_another_with_another_seed():
    one, two, other = tumbled(0.5), tumbled(0.5), tumbled(0.5, seed=8)
    for a, b, c in zip(one, two, other, strict=True):
        np.testing.assert_array_equal(a, b)
        assert np.abs(a - c).max() > 0.1


def test_balls_stay_in_the_yard_and_apart():
    places, turns = tumbled()
    slack = 0.03
    assert places[..., 1].min() > RADIUS - slack
    for axis, (low, high) in zip((0, 2), zip(YARD.low, YARD.high, strict=True), strict=True):
        assert places[..., axis].min() > low + RADIUS - slack
        assert places[..., axis].max() < high - RADIUS + slack
    for x, z, size in YARD.posts:
        assert np.hypot(places[..., 0] - x, places[..., 2] - z).min() > size + RADIUS - slack
    last = places[-1]
    between = np.linalg.norm(last[:, None] - last[None], axis=-1) + 9 * np.eye(len(last))
    assert between.min() > 2 * RADIUS - 0.15
    np.testing.assert_allclose(np.linalg.norm(turns, axis=-1), 1, atol=1e-9)


def test_a_ball_falls_as_things_fall():
    """Before the floor: h = v t - g t^2 / 2, within what the air takes."""
    places, _ = tumble(OPEN, np.array([[0.0, 100.0, 0.0]]), RADIUS, 1.0, 60, 1)
    speed = (places[1, 0, 1] - places[0, 0, 1]) * 60
    fallen = places[-1, 0, 1] - 100
    assert abs(fallen - (speed - 0.5 * GRAVITY)) < 0.5


def test_balls_come_to_rest():
    places, _ = tumble(OPEN, np.array([[0.0, 3.0, 0.0]]), RADIUS, 20.0, 60, 1)
    assert np.ptp(places[-60:, 0, 1]) < 0.02
    assert abs(places[-1, 0, 1] - RADIUS) < 0.02


def test_the_scene_plays_what_was_simulated():
    scene = load_scene("beach-balls", size=(16, 9))
    places, _ = tumble(YARD, _start(100, 7), RADIUS, 0.5, 60, 7)
    boxes = scene.at(0.5).motion.stage.boxes(scene.at(0.5).pose)
    assert len(boxes) == 200
    for number in (0, 42, 99):
        box = np.array(boxes[f"ball-{number}"])
        assert np.abs(box.mean(0) - places[30, number]).max() < 0.05
        assert (np.ptp(box, axis=0) > 1.6 * RADIUS).all()
