"""The path-traced reference: right, honest about its noise, kept, and never taken from a stale file."""

from dataclasses import replace

import numpy as np
import pytest

import ddgi
from ddgi.judge import cache
from ddgi.judge.path_tracer import PathTracer
from ddgi.judge.reference import PILOT_PIXELS, _fewer_pixels, kept, make_reference
from ddgi.scene.camera import look_at, with_size


@pytest.fixture(scope="module")
def scene():
    return ddgi.load_scene("cornell-point", size=(24, 24))


@pytest.fixture(scope="module")
def furnace():
    return ddgi.load_scene("furnace", size=(12, 8))


def test_furnace_is_exactly_one(furnace):
    found = PathTracer(furnace).render(furnace.camera, 256, 0).picture
    # Radiance 1 everywhere; paths end by Russian roulette, which costs a little noise.
    assert found.mean() == pytest.approx(1, abs=0.01)


def test_direct_light_of_the_furnace(furnace):
    """Emission 0.5, and of that 0.5 reflected once: 0.75 of the 1 that is there."""
    found = PathTracer(furnace).render_direct(furnace.camera, 64, 0).picture
    assert found.mean() == pytest.approx(0.75, abs=0.01)


def test_samples_depend_on_their_seed_alone(scene):
    tracer = PathTracer(scene)
    a, b, c = (tracer.render(scene.camera, 2, seed).picture for seed in (5, 5, 6))
    assert np.array_equal(a, b)
    assert not np.array_equal(a, c)


def test_passes_do_not_repeat_each_other(scene, monkeypatch):
    from ddgi.judge import path_tracer

    monkeypatch.setattr(path_tracer, "MOST_LANES", 24 * 24)  # one sample a pass
    several = PathTracer(scene).render(scene.camera, 2, 0).picture
    one = PathTracer(scene).render(scene.camera, 1, 0).picture
    assert not np.array_equal(several, one)


@pytest.mark.parametrize("camera", ["own", "moved", "orthographic", "near"])
def test_sees_what_our_camera_sees(scene, camera):
    """Direct light of a point light has no noise, so both sides must agree pixel by pixel."""
    from ddgi.scene.camera import make_camera, with_near

    size = (24, 24)
    view = {
        "own": scene.camera,
        "moved": look_at((0.4, 0.2, 0.8), (0, -0.6, -0.4), fov=70, size=size),
        "orthographic": make_camera(
            "o", (0, 0, 0.9), (0, 0, -1), (0.8, 0, 0), (0, 0.8, 0), size, orthographic=True
        ),
        "near": with_near(scene.camera, 3.6),
    }[camera]
    s = ddgi.RenderSettings.preset("default")
    s = replace(s, grid=replace(s.grid, counts=(2, 2, 2)), rays=replace(s.rays, per_probe=8))
    field, frame = ddgi.IrradianceField.fit(scene, s), None
    for tick in range(64):
        field, frame = ddgi.render_frame(scene, field, view, tick, s, frame)
    ours = np.array(frame.picture.immediate).T.reshape(24, 24, 3)
    theirs = PathTracer(scene).render_direct(view, 256, 0).picture
    assert ours.mean() > 0.01
    # 64 and 256 places within each pixel: edges differ a little.
    assert np.abs(ours - theirs).mean() < 0.02 * theirs.mean()


def test_halves_are_independent_and_their_mean_is_the_picture(scene, tmp_path):
    found = make_reference(scene, scene.camera, 10.0, 0, tmp_path)
    assert found.spp == 16
    assert not np.array_equal(*found.halves)
    assert np.allclose(found.picture, found.halves.mean(0))
    assert found.noise > 0
    assert found.good_for(2.1 * found.noise)
    assert not found.good_for(1.9 * found.noise)


def test_is_refined_until_it_is_good_enough_and_then_kept(scene, tmp_path):
    coarse = make_reference(scene, scene.camera, 10.0, 60, tmp_path)
    fine = make_reference(scene, scene.camera, coarse.noise, 60, tmp_path)
    assert fine.spp > coarse.spp
    assert fine.good_for(coarse.noise)
    again = make_reference(scene, scene.camera, coarse.noise, 60, tmp_path)
    assert np.array_equal(again.halves, fine.halves)
    assert (again.spp, again.noise) == (fine.spp, fine.noise)
    assert len(list(tmp_path.iterdir())) == 1


def test_refining_adds_to_what_is_there(scene, tmp_path):
    """16 samples and then 16 more are the mean of both, and of the same samples as 32 at once."""
    coarse = make_reference(scene, scene.camera, 10.0, 0, tmp_path)
    fine = make_reference(scene, scene.camera, coarse.noise * 1.6, 60, tmp_path)
    more = fine.halves * fine.spp - coarse.halves * coarse.spp
    assert (more > -1e-3).all()


def test_time_runs_out_and_it_says_so(scene, tmp_path):
    found = make_reference(scene, scene.camera, 1e-4, 0, tmp_path)
    assert found.spp == 16
    assert not found.good_for(1e-4)
    again = make_reference(scene, scene.camera, 1e-4, 1e-3, tmp_path)
    assert again.spp == 32, "a few samples to see how long one takes, however many there are already"


@pytest.mark.parametrize(
    ("size", "fewer"), [((24, 24), (24, 24)), ((1920, 1080), (120, 67)), ((180, 3840), (19, 418))]
)
def test_the_pilot_looks_at_few_pixels(scene, size, fewer):
    found = _fewer_pixels(with_size(scene.camera, size)).size
    assert found == pytest.approx(fewer, abs=1)
    assert found[0] * found[1] <= PILOT_PIXELS


def test_files_that_do_not_fit_are_ignored(scene, tmp_path, monkeypatch):
    found = make_reference(scene, scene.camera, 10.0, 0, tmp_path)
    key = cache.Key.of(scene, scene.camera, tmp_path)
    assert kept(key).spp == found.spp
    assert kept(replace(key, text="something else")) is None
    whole = key.path.read_bytes()
    key.path.write_bytes(whole[: len(whole) // 2])
    assert kept(key) is None
    key.path.write_bytes(b"")
    assert kept(key) is None
    assert make_reference(scene, scene.camera, 10.0, 0, tmp_path).spp == found.spp, "made anew"
    monkeypatch.setattr(cache, "FORMAT", cache.FORMAT + 1)
    assert kept(cache.Key.of(scene, scene.camera, tmp_path)) is None


@pytest.mark.parametrize(
    "damage",
    [
        {"direct": np.zeros((3, 3, 3), np.float32)},
        {"halves": np.zeros((2, 24, 20, 3), np.float32)},
        {"direct": np.full((24, 24, 3), np.nan, np.float32)},
        {"more": 1},
    ],
)
def test_damaged_arrays_are_made_anew(scene, tmp_path, damage):
    found = make_reference(scene, scene.camera, 10.0, 0, tmp_path)
    key = cache.Key.of(scene, scene.camera, tmp_path)
    cache.store(key, {**cache.load(key, {}), **damage})
    assert kept(key) is None
    assert np.array_equal(
        make_reference(scene, scene.camera, 10.0, 0, tmp_path).halves.shape, found.halves.shape
    )


def test_what_a_view_shows_decides_where_it_is_kept(scene, tmp_path):
    key = cache.Key.of(scene, scene.camera, tmp_path)
    assert cache.Key.of(ddgi.load_scene("cornell-point", size=(24, 24)), scene.camera, tmp_path) == key
    others = [
        cache.Key.of(scene, look_at((0, 0, 3), (0, 0, 0), size=(24, 24)), tmp_path),
        cache.Key.of(
            ddgi.load_scene("cornell-point", size=(32, 24)),
            ddgi.load_scene("cornell-point", size=(32, 24)).camera,
            tmp_path,
        ),
        cache.Key.of(ddgi.load_scene("cornell", size=(24, 24)), scene.camera, tmp_path),
    ]
    assert len({key.path, *(other.path for other in others)}) == 4


def test_an_unwritable_folder_is_an_error(scene, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ddgi.OutputError, match="DDGI_CACHE_DIR"):
        make_reference(scene, scene.camera, 10.0, 0, tmp_path / "file")


@pytest.mark.parametrize("opacity", [0.0, 0.5, 1.0])
def test_a_card_casts_as_much_shadow_as_it_is_there(opacity):
    """Light straight above, a card between: E / pi = (1 - opacity) albedo / (pi d^2)."""
    import mitsuba as mi

    ddgi.use_backend("auto")
    floor = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}}
    scene = ddgi.load_scene(
        {
            "type": "scene",
            "floor": {"type": "rectangle", "bsdf": floor},
            "card": {
                "type": "rectangle",
                "to_world": mi.ScalarTransform4f().translate([0, 0, 1]).scale(0.3),
                "bsdf": {
                    "type": "mask",
                    "opacity": opacity,
                    "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
                },
            },
            "light": {"type": "point", "position": [0, 0, 2], "intensity": {"type": "rgb", "value": 1.0}},
        }
    )
    beside_the_card = look_at((0.6, 0, 1.5), (0, 0, 0), up=(0, 0, 1), fov=5, size=(8, 8))
    found = PathTracer(scene).render_direct(beside_the_card, 256, 0).picture
    assert found.mean() == pytest.approx((1 - opacity) * 0.5 / np.pi / 4, rel=0.03, abs=1e-4)
