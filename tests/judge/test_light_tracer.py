"""Light traced from the lamps must be the light that paths from the camera find."""

from itertools import count

import mitsuba as mi
import numpy as np
import pytest

import ddgi
from ddgi.judge import light_tracer, reference
from ddgi.judge.light_tracer import LightTracer
from ddgi.judge.path_tracer import PathTracer
from ddgi.judge.reference import make_reference
from ddgi.scene.camera import look_at, make_camera, with_near

SIZE = (24, 16)


def indirect_both_ways(scene, camera, paths=2000, samples=2000):
    """Black where a lamp is seen: there, the difference of two noisy edges would drown the rest."""
    eye = PathTracer(scene)
    there = LightTracer(eye.scene, eye.origin).render(camera, paths, 1).picture
    direct = eye.render_direct(camera, samples, 3).picture
    back = eye.render(camera, samples, 2).picture - direct
    dim = direct.max(-1, keepdims=True) < 4 * direct.mean()
    return there * dim, back * dim


def light_tracer_of(scene):
    eye = PathTracer(scene)
    return LightTracer(eye.scene, eye.origin)


def test_indirect_light_of_the_furnace():
    """Radiance 1 is there, of which 0.5 is emitted and 0.25 reflected once."""
    furnace = ddgi.load_scene("furnace", size=SIZE)
    found = light_tracer_of(furnace).render(furnace.camera, 400, 0).picture
    assert found.mean() == pytest.approx(0.25, abs=0.005)


@pytest.mark.parametrize("name", ["cornell", "color-boxes", "statue-box", "ceiling-hole"])
def test_agrees_with_paths_from_the_camera(name):
    """Spot, sun, area lamps, smooth normals, cameras behind a wall that is cut away."""
    scene = ddgi.load_scene(name, size=SIZE, materials="diffuse")
    there, back = indirect_both_ways(scene, scene.camera)
    assert there.mean() == pytest.approx(back.mean(), rel=0.02)
    halves = [np.array_split(p.mean(-1), 2, axis) for p in (there, back) for axis in (0, 1)]
    for a, b in zip(halves[:2], halves[2:], strict=True):
        assert [x.mean() for x in a] == pytest.approx([x.mean() for x in b], rel=0.04)


@pytest.mark.parametrize("camera", ["wide", "near", "off its axis"])
def test_sees_with_any_pinhole_camera(camera):
    scene = ddgi.load_scene("cornell-point", size=SIZE)
    wide = look_at((0.4, 0.2, 0.8), (0, -0.6, -0.4), fov=110, size=SIZE)
    view = {
        "wide": wide,
        "near": with_near(scene.camera, 3.6),
        "off its axis": make_camera("o", (0, 0, 0.9), (0.3, -0.2, -1), (0.8, 0, 0), (0, 0.8, 0), SIZE),
    }[camera]
    there, back = indirect_both_ways(scene, view)
    difference = np.abs(there - back).mean() / back.mean()
    assert there.mean() == pytest.approx(back.mean(), rel=0.02)
    assert difference < 0.1


def test_equal_seeds_give_equal_paths():
    scene = ddgi.load_scene("cornell-point", size=SIZE)
    tracer = light_tracer_of(scene)
    a, b, c = (tracer.render(scene.camera, 4, seed).picture for seed in (5, 5, 6))
    assert np.allclose(a, b, rtol=1e-3, atol=1e-6), "but for the order of sums"
    assert not np.allclose(a, c, rtol=1e-3, atol=1e-6)


def test_many_passes_are_the_mean_of_their_paths(monkeypatch):
    scene = ddgi.load_scene("cornell-point", size=SIZE)
    tracer = light_tracer_of(scene)
    whole = tracer.render(scene.camera, 200, 0).picture
    monkeypatch.setattr(light_tracer, "MOST_LANES", 5000)
    assert tracer.render(scene.camera, 200, 0).picture.mean() == pytest.approx(whole.mean(), rel=0.05)


def scene_of(**parts):
    ddgi.use_backend("auto")
    floor = {"type": "rectangle", "bsdf": {"type": "diffuse"}}
    return mi.load_dict({"type": "scene", "floor": floor} | parts)


@pytest.mark.parametrize(
    "part, suits",
    [
        ({"type": "point", "position": [0, 0, 2]}, True),
        ({"type": "spot"}, True),
        ({"type": "rectangle", "emitter": {"type": "area"}, "bsdf": {"type": "diffuse"}}, True),
        ({"type": "sphere", "bsdf": {"type": "twosided", "b": {"type": "diffuse"}}}, True),
        ({"type": "constant"}, False),
        ({"type": "directional", "direction": [0, 0, -1]}, True),
        ({"type": "sphere", "bsdf": {"type": "conductor"}}, False),
        ({"type": "sphere", "bsdf": {"type": "plastic"}}, False),
        ({"type": "sphere", "bsdf": {"type": "roughplastic"}}, False),
        ({"type": "sphere", "bsdf": {"type": "dielectric"}}, False),
        ({"type": "sphere", "bsdf": {"type": "mask", "opacity": 0.5, "b": {"type": "diffuse"}}}, False),
    ],
)
def test_suits_matt_scenes_without_a_sky(part, suits):
    camera = look_at((0, 0, 3), (0, 0, 0), up=(0, 1, 0), size=SIZE)
    assert light_tracer.suits(scene_of(part=part), camera) == suits


def test_does_not_suit_parallel_rays_of_sight():
    flat = make_camera("o", (0, 0, 1), (0, 0, -1), (1, 0, 0), (0, 1, 0), SIZE, orthographic=True)
    assert not light_tracer.suits(scene_of(), flat)


@pytest.fixture
def even_clock(monkeypatch):
    """All samples take a second: what the machine does beside is not to decide."""
    monkeypatch.setattr(reference, "perf_counter", count().__next__)


@pytest.mark.parametrize(("seconds", "start"), [(1.0, "lamps"), (3.0, "lamps"), (5.0, "camera")])
def test_noise_counts_by_the_time_it_takes(monkeypatch, seconds, start):
    """Paths from the lamps with half the noise are worth it up to four times the time."""
    now = 0.0
    monkeypatch.setattr(reference, "perf_counter", lambda: now)

    def maker(noise, takes):
        def make(spp, before):
            nonlocal now
            now += takes
            return np.stack([np.full((8, 8, 3), noise), np.zeros((8, 8, 3))]), np.zeros((8, 8, 3))

        return make

    assert reference._better_start({"camera": maker(1.0, 1.0), "lamps": maker(0.5, seconds)}) == start


@pytest.mark.slow
def test_the_reference_starts_where_less_noise_comes_of_it(tmp_path, even_clock):
    """A room lit by one spot: hard to find for paths from the camera."""
    spot = ddgi.load_scene("statue-box", size=(96, 54), materials="diffuse")
    assert make_reference(spot, spot.camera, 10.0, 0, tmp_path).start == "lamps"
    sky = ddgi.load_scene("forest", size=SIZE, materials="diffuse")
    assert make_reference(sky, sky.camera, 10.0, 0, tmp_path).start == "camera"


def test_seldom_seen_light_does_not_pass_for_little_noise(tmp_path, even_clock):
    """The sun over a wide field with a house: nearly all paths from it end far from the picture."""
    house = ddgi.load_scene("house", camera="open", size=(64, 36), materials="diffuse")
    assert make_reference(house, house.camera, 10.0, 0, tmp_path).start == "camera"


def test_a_reference_goes_on_from_where_it_started(tmp_path):
    spot = ddgi.load_scene("statue-box", size=SIZE, materials="diffuse")
    coarse = make_reference(spot, spot.camera, 10.0, 0, tmp_path)
    fine = make_reference(spot, spot.camera, coarse.noise, 60, tmp_path)
    assert fine.start == coarse.start
    assert fine.spp > coarse.spp
    assert fine.noise < coarse.noise
