"""Points that lamps light, seen by the probes: the same light, with less noise."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.probes import lamplit
from ddgi.probes.field import IrradianceField, irradiance_map, radiance_map
from ddgi.sampling import clock
from probing import changed, diffuse, load, rgb, room, small, updated


def settled(scene, s, updates=120, seed=0):
    """Mean maps over many updates."""
    s = changed(s, seed=seed, blend_warm_up=1, blend_recency=1.0, blend_hysteresis=0.9999)
    field = updated(scene, s, updates)
    return irradiance_map(field, s), radiance_map(field, s)


def spot(target=(0.9, -0.9, 0.3)):
    return {
        "type": "spot", "intensity": rgb(20.0), "cutoff_angle": 12.0, "beam_width": 8.0,
        "to_world": mi.ScalarTransform4f().look_at([-0.5, 0.8, 0.1], list(target), [0, 0, 1]),
    }  # fmt: skip


def bulb(x, y, z, intensity):
    return {"type": "point", "position": [x, y, z], "intensity": rgb(intensity)}


def veil():
    """A sheet that lets two thirds of the light through, before what the spot shines at."""
    return {
        "type": "rectangle",
        "bsdf": {"type": "mask", "opacity": 1 / 3, "nested": diffuse(0.6, two_sided=True)},
        "to_world": mi.ScalarTransform4f().translate([0.3, -0.2, 0.2]).rotate([0, 1, 0], 70).scale(0.6),
    }


SCENES = ("one spot", "a veil", "sun", "six bulbs", "enamel")


def scene_of(name):
    if name == "one spot":
        return load(room(diffuse(0.5), lamp=spot()))
    if name == "enamel":  # half of what it reflects is gloss
        enamel = {"type": "roughplastic", "alpha": 0.5, "int_ior": 3.0, "diffuse_reflectance": rgb(0.3)}
        return load(room(enamel, lamp=spot()))
    if name == "a veil":
        return load(room(diffuse(0.5), lamp=spot(), veil=veil()))
    if name == "six bulbs":
        bulbs = {
            f"bulb-{i}": bulb(0.7 * np.cos(i), 0.2 * i - 0.5, 0.7 * np.sin(i), 0.3 + 0.2 * i)
            for i in range(6)
        }
        return load(room(diffuse(0.5), **bulbs))

    def flat(height, half):
        return mi.ScalarTransform4f().translate([0, height, 0]).rotate([1, 0, 0], -90).scale(half)

    return load({
        "type": "scene",
        "sun": {"type": "directional", "direction": [0.4, -0.8, 0.3], "irradiance": rgb(4.0)},
        "floor": {"type": "rectangle", "bsdf": diffuse(0.7), "to_world": flat(-1, 2.0)},
        "shelf": {"type": "rectangle", "bsdf": diffuse(0.5, two_sided=True), "to_world": flat(-0.3, 0.5)},
    })  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("length", [1, 2])
def test_the_mean_is_the_same(name, length):
    scene = scene_of(name)
    s = small(gather_path_length=length, contact_hits=0.0, gather_energy_preservation=0.0)
    s = changed(
        s, blend_fit_texels=False
    )  # fitted texels of noisy maps are cut off at zero: 0.6 % more, paths or not
    if name == "sun":
        s = changed(s, grid_box=((-1.0, -0.9, -1.0), (1.0, 1.0, 1.0)))
    if name == "enamel":
        s = changed(s, rays_per_probe=256)  # few rays in its lobe meet what the spot shines at
    with_paths = settled(scene, s)
    rays = settled(scene, changed(s, rays_from_lamps=0, rays_per_probe=512))
    for a, b in zip(with_paths, rays, strict=True):
        assert a.mean() == pytest.approx(b.mean(), rel=5e-3)
        if length == 1:  # what paths bring beyond first surfaces is as noisy as it was
            assert np.abs(a - b).mean() < 0.1 * b.mean()


@pytest.mark.slow
def test_noise_is_less():
    """Maps of few updates against each other, with paths and without."""
    scene = scene_of("one spot")

    def noise(s):
        maps = [settled(scene, s, 8, seed)[0] for seed in range(4)]
        return np.std(maps, axis=0).mean()

    assert noise(small()) < 0.6 * noise(small(rays_from_lamps=0))


def seen_points(scene, s, tick=0):
    field, time = IrradianceField.fit(scene, s), clock(0, tick)
    vol = field.volumes[0]
    paths = lamplit.send(scene.tracer, scene.lights, vol.grid, s.rays.from_lamps, False, time)
    return paths, lamplit.seen(scene.tracer, vol.grid, vol.awake, paths, s.rays.per_probe, time), vol.grid


def test_no_point_is_brighter_than_what_is_there():
    """However near to a probe, a point brings no more than a ray that meets it would."""
    scene, s = scene_of("one spot"), small()
    _, points, _ = seen_points(scene, s)
    brought = np.array(points.radiance).reshape(-1, 4)[:, 1]
    nearest = np.linalg.norm(np.array([0.9, -0.9, 0.3]) - [-0.5, 0.8, 0.1]) - 0.3
    assert 0 < brought.max() < 0.5 / np.pi * 20.0 / nearest**2


def sets_seen(scene, s, tick):
    """Which of the eight sets of points each probe of the first cell looks at."""
    paths, points, grid = seen_points(scene, s, tick)
    landed = np.array(paths.landed.surface.position).T.reshape(lamplit.SETS, points.count, 3)
    corners = [0, 1, 4, 5, 16, 17, 20, 21]  # of 4 x 4 x 4 probes
    at = np.array(grid.position(mi.UInt32(corners))).T
    looks = np.array(points.direction).reshape(grid.size, points.count, 4)[corners, :, :3]
    to = landed[None] - at[:, None, None]
    to /= np.linalg.norm(to, axis=-1, keepdims=True)
    return np.abs(to - looks[:, None]).sum((2, 3)).argmin(1)


def test_neighbours_see_other_points_and_all_in_turn():
    scene, s = load(room(diffuse(0.5), lamp=bulb(0.0, 0.0, 0.0, 1.0))), small(rays_from_lamps=2)
    seen = np.array([sets_seen(scene, s, tick) for tick in range(lamplit.SETS)])
    everything = list(range(lamplit.SETS))
    assert all(sorted(of_a_tick) == everything for of_a_tick in seen)
    assert all(sorted(of_a_probe) == everything for of_a_probe in seen.T)


def test_without_lamps_there_are_no_paths():
    scene, s = load(room(diffuse(0.5), glow={"type": "constant", "radiance": rgb(1.0)})), small()
    vol = IrradianceField.fit(scene, s).volumes[0]
    assert lamplit.send(scene.tracer, scene.lights, vol.grid, 16, False, clock(0, 0)) is None
    lit = scene_of("one spot")
    assert lamplit.send(lit.tracer, lit.lights, vol.grid, 0, False, clock(0, 0)) is None
