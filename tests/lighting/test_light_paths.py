"""Paths from the lamps: they carry the lamps' power, and go where it is of use."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.lighting import light_paths
from ddgi.lighting.lamp_cells import Disc
from ddgi.lighting.light_paths import Aim, _picked
from ddgi.lighting.lights import delta_light
from ddgi.sampling import clock
from probing import diffuse, floats, load, rgb, room, surface_at

ALBEDO = 0.6
MANY = 4096


def lamp(x=0.3, intensity=2.0):
    return {"type": "point", "position": [x, 0.2, -0.4], "intensity": rgb(intensity)}


def around(radius=1.8):
    return Disc(mi.Point3f(0.0), mi.Float(radius))


def sent(scene, count=MANY, tick=0):
    disc, time = around(), clock(0, tick)
    aim = light_paths.aim(scene.tracer, scene.lights, disc, count, time)
    return aim, light_paths.land(scene.tracer, scene.lights, aim, time)


def under_a_roof():
    """A square room of half size 1 with a hole of 0.4 x 0.4 in its roof, the sun overhead, and nothing else."""
    t = mi.ScalarTransform4f
    part = lambda x, z, a, b: {  # noqa: E731
        "type": "cube", "bsdf": diffuse(ALBEDO), "to_world": t().translate([x, 1.05, z]).scale([a, 0.05, b]),
    }  # fmt: skip
    wall = lambda x, z, a, b: {  # noqa: E731
        "type": "cube", "bsdf": diffuse(ALBEDO), "to_world": t().translate([x, 0, z]).scale([a, 1.0, b]),
    }  # fmt: skip
    floor = {
        "type": "cube",
        "bsdf": diffuse(ALBEDO),
        "to_world": t().translate([0, -1.05, 0]).scale([1.1, 0.05, 1.1]),
    }
    return load({
        "type": "scene", "floor": floor,
        "roof-1": part(-0.65, 0, 0.45, 1.1), "roof-2": part(0.65, 0, 0.45, 1.1),
        "roof-3": part(0, -0.65, 0.2, 0.45), "roof-4": part(0, 0.65, 0.2, 0.45),
        "wall-1": wall(-1.05, 0, 0.05, 1.1), "wall-2": wall(1.05, 0, 0.05, 1.1),
        "wall-3": wall(0, -1.05, 1.0, 0.05), "wall-4": wall(0, 1.05, 1.0, 0.05),
        "sun": {"type": "directional", "direction": [0, -1, 0], "irradiance": rgb(5.0)},
    })  # fmt: skip


def test_paths_carry_the_power_of_a_lamp():
    """A point light of I W/sr sends 4 pi I into a closed room, of which the albedo leaves the walls again."""
    _, landed = sent(load(room(diffuse(ALBEDO), lamp=lamp())))
    intensity = np.array(landed.intensity, np.float64)[1]
    assert (intensity > 0).all()
    assert np.pi * intensity.sum() == pytest.approx(ALBEDO * 4 * np.pi * 2.0, rel=2e-3)


def test_paths_carry_the_power_of_several_lamps():
    _, landed = sent(load(room(diffuse(ALBEDO), a=lamp(), b=lamp(-0.5, 6.0), c=lamp(0.8, 0.5))))
    total = np.pi * np.array(landed.intensity, np.float64)[1].sum()
    assert total == pytest.approx(ALBEDO * 4 * np.pi * 8.5, rel=1e-2)


def test_paths_are_as_dense_as_they_say():
    """Paths that land on a part of a wall, against the integral of their density over it."""
    scene = load(room(diffuse(ALBEDO), lamp=lamp()))
    counts, expected = [], []
    for tick in range(8):
        _, landed = sent(scene, tick=tick)
        y, density = np.array(landed.surface.position).T, np.array(landed.density, np.float64)
        on_floor = (y[:, 1] < -0.999) & (np.abs(y[:, 0] - 0.3) < 0.4) & (np.abs(y[:, 2] + 0.4) < 0.4)
        counts.append(on_floor.sum())
        expected.append(0.64 / np.mean(1 / density[on_floor]))  # harmonic mean: they are samples of it
    assert np.sum(counts) == pytest.approx(np.sum(expected), rel=0.03)


def test_sunlight_comes_in_through_the_hole():
    """Of the sun on the disc 1.6 % passes the hole; most paths do, and carry what it lets in."""
    scene = under_a_roof()
    inside_share, power = [], []
    for tick in range(8):
        _, landed = sent(scene, 512, tick)
        y = np.array(landed.surface.position).T
        inside = (y[:, 1] < -0.9) & (np.abs(y[:, 0]) < 1) & (np.abs(y[:, 2]) < 1)
        inside_share.append(inside.mean())
        power.append(np.pi * np.array(landed.intensity, np.float64)[1][inside].sum())
    assert np.mean(inside_share) > 0.3
    assert np.mean(power) == pytest.approx(ALBEDO * 5.0 * 0.4 * 0.4, rel=0.05)


def test_no_cell_is_left_out():
    aim, _ = sent(under_a_roof())
    chance = np.array(aim.chance, np.float64)
    assert (chance > 0).all()
    assert chance.sum() == pytest.approx(1, abs=1e-5)
    assert np.allclose(np.array(aim.before), np.cumsum(chance) - chance, atol=1e-5)


def test_in_a_closed_room_all_directions_are_alike():
    aim, _ = sent(load(room(diffuse(ALBEDO), lamp=lamp())))
    assert np.ptp(np.array(aim.chance)) < 1e-6


def test_lamps_that_are_off_send_nothing():
    scene = load(room(diffuse(ALBEDO), a=lamp(), b=lamp(-0.5, 6.0)))
    _, landed = sent(scene.dimmed(1, 0.0))
    one = load(room(diffuse(ALBEDO), a=lamp()))
    total = lambda x: np.array(x.intensity, np.float64)[1].sum()  # noqa: E731
    assert total(landed) == pytest.approx(total(sent(one)[1]), rel=1e-2)
    _, dark = sent(scene.dimmed(None, 0.0))
    assert (np.array(dark.intensity) == 0).all()
    assert (np.array(dark.density) == 0).all()


def test_the_density_of_what_a_lamp_shines_past_is_none():
    scene = under_a_roof()
    aim, _ = sent(scene)
    beyond = surface_at(
        [[9.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, -1.0, 0.0]], [[0, 1, 0], [0, 1, 0], [0, -1, 0]]
    )
    found = np.array(
        light_paths.density(delta_light(scene.lights.delta, mi.UInt32(0)), mi.UInt32(0), beyond, aim)
    )
    assert found[0] == 0  # outside of the disc
    assert found[1] > 0
    assert found[2] == 0  # turned away


def test_cells_are_picked_in_proportion():
    chance = np.array([0.1, 0.0, 0.3, 0.05, 0.25, 0.05, 0.05, 0.2], np.float32)  # two lamps of 2 x 2
    aim = Aim(1, 2, around(), floats(chance), floats(np.cumsum(chance) - chance))
    steps = (np.arange(200) + 0.5) / 200
    u = np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2)
    cell, place = _picked(aim, mi.Point2f(floats(u[:, 0]), floats(u[:, 1])))
    cell, place = np.array(cell), np.array(place, np.float64)
    assert np.allclose(np.bincount(cell, minlength=8) / len(u), chance, atol=5e-3)
    for which in np.flatnonzero(chance):
        assert np.allclose(place[:, cell == which].mean(1), 0.5, atol=0.02)
    assert place.min() >= 0 and place.max() < 1
