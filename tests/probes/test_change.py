"""Changes of light are noticed, noise is not; what noticed one follows as fast as bounces go."""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.frame import updated
from ddgi.probes.change import Change
from ddgi.probes.field import IrradianceField, irradiance_map
from probing import camera_in, diffuse, load, rgb, room, small

WARM_UP = 8
STILL = 40
"""Updates in which light stays as it is."""


def watched(new, deviations=4.0):
    """Numbers of the updates at which one probe noticed a change. new: (T, 6) luminance that they bring."""
    change, noticed = Change.none(1), []
    for number, light in enumerate(new):
        each = [mi.Float(float(value)) for value in light]
        change, age = change.after(mi.UInt32(0), each, WARM_UP, deviations)
        dr.eval(change, age)
        if number and int(age[0]) == 0:
            noticed.append(number)
    return noticed


def lit_room():
    """A closed room with a bulb in it."""
    bulb = {"type": "point", "position": [0.0, 0.5, 0.6], "intensity": rgb(1.0)}
    return replace(load(room(diffuse(0.5)) | {"bulb": bulb}), cameras=(camera_in(),))


def noisy(level, updates, share=0.03, seed=0):
    return np.asarray(level) * np.random.default_rng(seed).normal(1, share, (updates, 6))


@pytest.mark.parametrize("share", [0.0, 0.01, 0.1, 0.5])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_noise_is_no_change(share, seed):
    assert watched(noisy(1.0, 200, share, seed)) == []


@pytest.mark.parametrize("seed", [1, 2])
def test_rare_flashes_are_no_change(seed):
    """One update in twenty brings thirty times the light: a small lamp that few rays meet."""
    flashes = np.where(np.random.default_rng(seed).random((300, 1)) < 0.05, 30.0, 1.0) * noisy(
        1.0, 300, 0.1, seed
    )
    assert watched(flashes) == []


@pytest.mark.parametrize("level", [0.0, 0.3, 0.6, 1.6, 5.0])
def test_a_step_is_noticed_at_its_third_update(level):
    light = np.concatenate([noisy(1.0, STILL), noisy(level, 20, seed=1)])
    assert watched(light) == [STILL + 2]


def test_light_that_only_comes_from_elsewhere_is_noticed():
    left, right = np.array([2.0, 0.5, 1, 1, 1, 1]), np.array([0.5, 2.0, 1, 1, 1, 1])
    light = np.concatenate([noisy(left, STILL), noisy(right, 10, seed=1)])
    assert watched(light)[:1] == [STILL + 2]


def test_fewer_deviations_notice_smaller_changes():
    light = np.concatenate([noisy(1.0, STILL), noisy(1.15, 20, seed=1)])
    assert watched(light, 2.0)[:1] == [STILL + 2]
    assert watched(light, 8.0) == []


def test_small_changes_are_left_to_the_hysteresis():
    light = np.concatenate([noisy(1.0, STILL, 0.0), noisy(1.015, 20, 0.0)])
    assert watched(light) == []


@pytest.mark.slow
def test_a_field_follows_a_switch_about_as_fast_as_one_that_keeps_nothing():
    """Frames until the mean of a closed room's maps has covered 90 % of the way, both ways."""
    scene = lit_room()
    dark = scene.dimmed("bulb", 0.1)

    def level(field, s):
        return float(irradiance_map(field, s).mean())

    def frames(before, after, goal, **values):
        s = small(blend_warm_up=WARM_UP, rays_per_probe=256, **values)
        field = IrradianceField.fit(before, s)
        for tick in range(STILL):
            field = updated(before, field, tick, s)
        start = level(field, s)
        for tick in range(STILL, STILL + 100):
            field = updated(after, field, tick, s)
            if (level(field, s) - start) / (goal - start) >= 0.9:
                return tick - STILL + 1
        return 100

    goals = []
    for there in (scene, dark):
        s = small(blend_warm_up=WARM_UP)
        field = IrradianceField.fit(there, s)
        for tick in range(60):
            field = updated(there, field, tick, s)
        goals.append(level(field, s))
    for before, after, goal in ((scene, dark, goals[1]), (dark, scene, goals[0])):
        least = frames(before, after, goal, blend_hysteresis=0.0)
        assert frames(before, after, goal, blend_watch=True) <= least + 2
        assert frames(before, after, goal) > least + 5


def test_watching_changes_nothing_while_nothing_changes():
    scene = lit_room()
    maps = []
    for watch in (False, True):
        s = small(blend_watch=watch)
        field = IrradianceField.fit(scene, s)
        for tick in range(48):
            field = updated(scene, field, tick, s)
        maps.append(irradiance_map(field, s))
    assert np.abs(maps[0] - maps[1]).mean() < 0.005 * maps[0].mean()


def test_a_field_that_is_reset_knows_nothing():
    s = small(blend_watch=True)
    scene = replace(load(room(diffuse(0.5))), cameras=(camera_in(),))
    field = updated(scene, IrradianceField.fit(scene, s), 0, s)
    assert np.array(field.volumes[0].change.settled).max() == 1
    assert np.array(field.reset().volumes[0].change.settled).max() == 0
