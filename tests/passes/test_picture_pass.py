"""Adding frames up, and showing them."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.frame import render_frame
from ddgi.passes import tone
from ddgi.probes.field import IrradianceField
from probing import camera_in, diffuse, load, rgb, room, small


def lit_room(**light):
    return load(
        room(
            diffuse(0.5), light={"type": "point", "position": [0.2, 0.1, 0.0], "intensity": rgb(1.0)} | light
        )
    )


def frames(scene, s, ticks, camera=None):
    """Frames of one run, each added to the one before."""
    camera = camera or camera_in((16, 12))
    field, frame, out = IrradianceField.fit(scene, s), None, []
    for tick in ticks:
        field, frame = render_frame(scene, field, camera, tick, s, frame)
        out.append(frame)
    return out


def test_layers_add_up_to_the_picture():
    s = small(picture_layers=True)
    frame = frames(lit_room(), s, range(4))[-1]
    layers = {name: np.array(x) for name, x in frame.layers.items()}
    total = layers["direct"] + layers["indirect"] + layers["emission"]
    assert np.allclose(frame.numpy(), total, rtol=1e-5, atol=1e-6)
    # indirect = albedo E / pi, albedo 0.5 everywhere
    assert np.allclose(layers["indirect"], layers["irradiance"] * 0.5 / np.pi, rtol=1e-4, atol=1e-6)
    assert np.allclose(layers["albedo"], 0.5, atol=1e-3)
    length = np.linalg.norm(layers["normal"], axis=-1)
    assert np.median(length) == pytest.approx(1, abs=1e-5)
    assert length.min() > 0.5  # means over edges are shorter; where three walls meet 1 / sqrt(3)
    assert layers["depth"].shape == (12, 16, 1)
    assert (layers["depth"] > 0).all()


def test_no_layers_unless_asked_for():
    assert frames(lit_room(), small(), [0])[0].layers == {}


def test_direct_light_is_the_plain_mean_of_frames():
    """Each frame's own direct light, rendered alone; the picture after n frames is their mean."""
    scene, s = lit_room(), small(picture_layers=True)
    together = frames(scene, s, range(5))[-1]
    alone = []
    field = IrradianceField.fit(scene, s)
    for tick in range(5):
        _, frame = render_frame(scene, field, camera_in((16, 12)), tick, s)
        alone.append(np.array(frame.layers["direct"]))
    assert np.allclose(np.array(together.layers["direct"]), np.mean(alone, axis=0), rtol=1e-4, atol=1e-6)


def test_a_still_noiseless_picture_does_not_change():
    """Without antialiasing, a point light's direct light is the same in every frame."""
    s = small(gbuffer_antialias=False, picture_layers=True)
    shown = [np.array(f.layers["direct"]) for f in frames(lit_room(), s, range(6))]
    assert np.allclose(shown[0], shown[-1], rtol=1e-5)


def test_light_that_is_no_number_is_counted_and_black():
    from dataclasses import replace

    scene = lit_room()
    broken = replace(scene.lights.delta, intensity=mi.Float([float("nan"), 1.0, 1.0, 0.0]))
    scene = replace(scene, lights=replace(scene.lights, delta=broken))
    frame = frames(scene, small(), range(2))[-1]
    assert np.isfinite(frame.numpy()).all()
    assert frame.non_finite > 0


def test_image_has_the_cameras_shape():
    frame = frames(lit_room(), small(), [0], camera_in((20, 10)))[0]
    assert frame.image.shape == (10, 20, 3)
    assert frame.numpy().dtype == np.float32


# ---- tone ------------------------------------------------------------------------------------------------


def grey(value, shape=(4, 4)):
    return np.full((*shape, 3), value, np.float32)


@pytest.mark.parametrize("level", [1e-3, 1.0, 500.0])
def test_automatic_exposure_makes_an_even_picture_middle_grey(level):
    assert level * 2 ** tone.automatic_exposure(grey(level)) == pytest.approx(0.18, rel=1e-4)


def test_automatic_exposure_ignores_black_and_survives_it():
    half = grey(1.0)
    half[:2] = 0
    assert tone.automatic_exposure(half) == pytest.approx(np.log2(0.18), abs=1e-4)
    assert tone.automatic_exposure(grey(0.0)) == 0
    half[0, 0] = np.nan
    assert np.isfinite(tone.automatic_exposure(half))


def test_linear_curve_is_srgb():
    """IEC 61966-2-1: 0.0031308 -> 0.04045, 0.2140 -> 0.5, 1 -> 1; above it clips."""
    s = tone.Settings(exposure=0.0, curve="linear")
    for x, y in ((0.0, 0.0), (0.0031308, 0.04045), (0.21404, 0.5), (1.0, 1.0), (7.0, 1.0)):
        assert np.allclose(tone.tone_map(grey(x), s), y, atol=1e-4)


def test_exposure_counts_in_stops():
    for curve in ("linear", "filmic"):
        a = tone.tone_map(grey(0.05), tone.Settings(exposure=2.0, curve=curve))
        assert np.allclose(a, tone.tone_map(grey(0.2), tone.Settings(exposure=0.0, curve=curve)), atol=1e-5)


@pytest.mark.parametrize("curve", ["linear", "filmic"])
def test_curves_are_monotone_and_stay_in_range(curve):
    x = np.geomspace(1e-6, 1e9, 400, dtype=np.float32)
    y = tone.tone_map(np.repeat(x[:, None, None], 3, 2), tone.Settings(exposure=0.0, curve=curve))[:, 0, 0]
    assert (np.diff(y) >= -1e-6).all()
    assert y.min() >= 0
    assert y.max() <= 1
    broken = tone.tone_map(grey(np.nan), tone.Settings(exposure=0.0, curve=curve))
    assert np.isfinite(broken).all()
