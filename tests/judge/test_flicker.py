"""Flicker: zero where nothing changes, and as filtered noise has it on paper."""

from dataclasses import replace

import mitsuba as mi
import numpy as np
import pytest

from ddgi.judge.digits import bitmap
from ddgi.judge.false_colour import false_colour, scale_top
from ddgi.judge.flicker import flicker, mean_change
from ddgi.settings import PRESETS
from probing import camera_in, diffuse, load, rgb, room, small


def lit_room(**more):
    """A room with a bulb near a corner, so that probes' rays differ."""
    bulb = {"type": "point", "position": [-0.6, 0.7, 0.5], "intensity": rgb(1.0)}
    return load(room(diffuse(0.5), bulb=bulb, **more), camera=camera_in((24, 18)))


def settings(**values):
    few = {"grid_counts": (3, 3, 3), "rays_per_probe": 32, "volume_irradiance_size": 4, "tone_exposure": 1.0}
    return small(**(few | values))


# ---- the metric alone --------------------------------------------------------------------------------


def test_change_sums_channels_and_averages_pairs():
    black, grey = np.zeros((2, 3, 3)), np.full((2, 3, 3), 0.1)
    assert np.allclose(mean_change([black, grey, black, grey]), 0.3)
    assert np.allclose(mean_change([black, black, grey]), 0.15)
    red = np.zeros((2, 3, 3))
    red[0, 1, 0] = 0.5
    change = mean_change([black, red])
    assert change.shape == (2, 3)
    assert change[0, 1] == 0.5
    assert change.sum() == 0.5


def test_still_pictures_do_not_change():
    picture = np.random.default_rng(0).random((4, 5, 3))
    assert (mean_change([picture] * 5) == 0).all()


# ---- scenes ------------------------------------------------------------------------------------------


def test_a_black_picture_does_not_flicker():
    result = flicker(lit_room().dimmed(None, 0), settings(), warm_up=3, frames=4)
    assert result.mean == result.worst == 0


def test_an_even_field_does_not_flicker():
    """Radiance is 1 wherever a ray goes; rounding of float32 is left, spread by the sRGB curve."""
    s = settings(direct_environment="field", grid_box=((-1.0,) * 3, (1.0,) * 3))
    dot = {"type": "sphere", "radius": 1e-4, "center": [0.913, 0.377, 0.591]}
    scene = load({"type": "scene", "dot": dot, "sky": {"type": "constant", "radiance": rgb(1.0)}})
    result = flicker(replace(scene, cameras=(camera_in((16, 12)),)), s, warm_up=12, frames=10)
    assert result.worst < 1e-5


def test_what_is_reported():
    result = flicker(lit_room(), settings(blend_hysteresis=0.9), warm_up=12, frames=6)
    figures = result.figures()
    assert result.change.shape == (18, 24)
    assert 0 < figures["flicker_mean"] < figures["flicker_max"] < 3
    assert (figures["frames"], figures["warm_up"], figures["hysteresis"]) == (6, 12, 0.9)
    assert figures["exposure"] == 1.0


def test_sampled_lamps_do_not_count():
    """The lamp's own light is noisy, one sample a pixel; the field hardly moves."""
    lamp = {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f().translate([0, 0.95, 0]).rotate([1, 0, 0], 90).scale(0.4),
        "emitter": {"type": "area", "radiance": rgb(3.0)},
        "bsdf": diffuse(0.0),
    }
    scene = load(room(diffuse(0.5), lamp=lamp), camera=camera_in((24, 18)))
    frozen = settings(blend_hysteresis=0.9999, blend_warm_up=0)
    assert flicker(scene, frozen, warm_up=4, frames=5).mean < 1e-4


def test_hysteresis_is_a_filter():
    """(1 - a) sqrt(2 / (1 + a)) of the noise is left between frames: 0.3 times as much at 0.97 as at 0.9."""
    change = [flicker(lit_room(), settings(blend_hysteresis=a), warm_up=150).mean for a in (0.9, 0.97)]
    # 50 frames of a filter that remembers 33, over 27 probes: the ratio's spread is below a tenth.
    assert change[1] / change[0] == pytest.approx(0.3 * np.sqrt(1.9 / 1.97), rel=0.2)


def test_more_rays_flicker_less():
    # Of rays alone: light paths have noise of their own.
    few = [settings(rays_per_probe=n, rays_from_lamps=0) for n in (16, 64, 256)]
    change = [flicker(lit_room(), s, warm_up=60).mean for s in few]
    # At most as independent samples: half for four times as many. Even spread makes it less.
    assert change[1] < 0.6 * change[0]
    assert change[2] < 0.6 * change[1]


@pytest.mark.slow
def test_light_paths_flicker_less():
    without, few, many = (
        flicker(lit_room(), settings(rays_per_probe=64, rays_from_lamps=n), warm_up=60).mean
        for n in (0, 8, 32)
    )
    assert few < 0.75 * without
    assert many < 0.95 * few  # what is left is the noise of rays; 0.83 to 0.90 with five seeds


def test_exposure_is_that_of_the_mean_picture():
    result = flicker(lit_room(), settings(tone_exposure=None), warm_up=5, frames=2)
    assert np.isfinite(result.exposure)
    assert result.exposure != 1.0


@pytest.mark.parametrize("preset", PRESETS)
def test_presets_have_the_hysteresis_of_the_definition(preset):
    assert PRESETS[preset].blend.hysteresis == 0.97


# ---- the map -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("high", "top"), [(0.0, 1), (0.004, 0.005), (0.01, 0.01), (0.6, 1), (2.4, 5)])
def test_scales_end_at_round_numbers(high, top):
    assert scale_top(np.full((3, 4), high)) == pytest.approx(top)


def test_colours_rise_in_lightness():
    colours = false_colour(np.linspace(0, 2, 50)[None], 1.0)
    assert colours.shape == (8, 50, 3)
    lightness = colours[0] @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(lightness) >= 0).all()
    assert lightness[0] < 1e-3
    assert lightness[25:] == pytest.approx(lightness[-1])


def test_the_scale_has_numbers():
    values = np.zeros((480, 300))
    scale, tenfold = (false_colour(values, top)[480:] for top in (0.05, 0.5))
    assert scale.shape == (20, 300, 3), "a 24th of the height"
    none, most = scale[:, :150], scale[:, 150:]
    assert (none == 1).all(-1).sum() == 12 * 2**2, "0 in white: twelve pixels, each two by two"
    assert (most == 0).all(-1).sum() > (tenfold[:, 150:] == 0).all(-1).sum(), "0.05 in black, longer than 0.5"


def test_a_scale_too_narrow_for_numbers_has_none():
    scale = false_colour(np.zeros((10, 12)), 0.005)[10:]
    assert np.allclose(scale, scale[:1])


@pytest.mark.parametrize("exponent", range(-9, 8))
@pytest.mark.parametrize("step", [1, 2, 5])
def test_every_scale_can_be_written(exponent, step):
    assert bitmap(step * 10.0**exponent).shape[0] == 5


def test_digits_are_drawn():
    assert ["".join(".#"[int(x)] for x in row) for row in bitmap(1.5)] == [
        ".#....###",
        "##....#..",
        ".#....###",
        ".#......#",
        "###.#.###",
    ]
