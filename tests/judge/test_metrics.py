"""The judge judged: pictures whose difference is known."""

import numpy as np
import pytest

from ddgi.errors import DDGIError
from ddgi.judge import metrics
from ddgi.judge.metrics import difference, flip_exposures


@pytest.fixture(scope="module")
def scenery() -> np.ndarray:
    """A picture with edges, gradients and a bright spot, (72, 128, 3)."""
    y, x = np.mgrid[0:72, 0:128] / 72.0
    picture = np.stack([0.2 + 0.5 * x, 0.4 - 0.2 * y, 0.1 + 0.3 * x * y], -1)
    picture[20:50, 30:60] *= (0.2, 0.5, 1.5)
    picture[5:9, 100:108] = 20.0
    return picture.astype(np.float32)


def test_the_same_picture_has_no_error(scenery):
    found = difference(scenery, scenery)
    assert (found.flip_mean, found.flip_p99, found.rel_mse, found.mff_mean, found.mff_max) == (0, 0, 0, 0, 0)
    assert found.luminance_error == 0
    assert found.flip_map.shape == scenery.shape[:2]


@pytest.mark.parametrize("scale", [0.5, 0.9, 1.1, 2.0])
def test_a_scaled_picture(scenery, scale):
    found = difference(scenery * scale, scenery)
    assert found.luminance_error == pytest.approx(scale - 1, abs=1e-5)
    # Pixels far above the mean divided by 10 have (s r - r)^2 / r^2.
    assert found.rel_mse == pytest.approx((scale - 1) ** 2, rel=0.6)
    assert found.rel_mse < (scale - 1) ** 2
    assert found.flip_mean > 0.01


def test_errors_grow_with_the_difference(scenery):
    small, large = difference(scenery * 1.05, scenery), difference(scenery * 1.3, scenery)
    for name in ("flip_mean", "flip_p99", "rel_mse", "mff_mean", "mff_max"):
        assert 0 < getattr(small, name) < getattr(large, name), name


def test_a_shifted_picture(scenery):
    found = difference(np.roll(scenery, 3, axis=1), scenery)
    assert abs(found.luminance_error) < 1e-5, "the same pixels in another place"
    assert found.flip_mean > 0.02
    assert found.mff_max > 0.3


def test_a_noisy_picture(scenery):
    noise = np.random.default_rng(0).normal(0, 0.1, scenery.shape)
    found = difference(np.maximum(scenery * (1 + noise), 0).astype(np.float32), scenery)
    assert abs(found.luminance_error) < 0.01
    assert found.rel_mse == pytest.approx(0.01, rel=0.5), "the variance of the noise"
    assert found.flip_mean > 0.02


def test_unrelated_pictures_are_far_apart(scenery):
    other = np.random.default_rng(1).uniform(0, 1, scenery.shape).astype(np.float32)
    assert difference(other, scenery).flip_mean > 0.2
    assert difference(scenery[::-1, ::-1].copy(), scenery).flip_mean > 0.1


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0])
@pytest.mark.parametrize("which", ["picture", "reference"])
def test_values_that_are_no_light_are_refused(scenery, bad, which):
    pictures = {"picture": scenery.copy(), "reference": scenery.copy()}
    pictures[which][3, 4, 1] = bad
    with pytest.raises(DDGIError, match=f"the {which} holds 1 pixel"):
        difference(**pictures)


def test_shapes_must_agree(scenery):
    with pytest.raises(DDGIError, match="reference"):
        difference(scenery, scenery[1:])
    with pytest.raises(DDGIError, match="height, width, 3"):
        difference(scenery[..., 0], scenery[..., 0])


def test_black_pictures_have_an_answer():
    black, grey = np.zeros((16, 16, 3), np.float32), np.full((16, 16, 3), 0.5, np.float32)
    same = difference(black, black)
    assert (same.flip_mean, same.rel_mse, same.luminance_error) == (0, 0, 0)
    for found in (difference(grey, black), difference(black, grey)):
        assert np.isfinite(list(found.figures().values())[:6]).all()
        assert found.flip_mean > 0.2
    assert difference(black, grey).luminance_error == pytest.approx(-1)


def test_overexposed_pictures_have_an_answer(scenery):
    found = difference(scenery * 1e6, scenery * 1e6 * 1.1)
    assert found.luminance_error == pytest.approx(1 / 1.1 - 1, abs=1e-4)
    assert 0 < found.flip_mean < 0.5


def test_there_are_never_fewer_than_two_exposures():
    flat = np.full((8, 8, 3), 0.3, np.float32)
    assert flip_exposures(flat)[2] >= 2
    assert difference(flat * 2, flat).flip_mean > 0.05, "with one exposure FLIP answers 0 to anything"


def test_exposures_do_not_depend_on_black_around_the_picture(scenery):
    framed = np.zeros((144, 256, 3), np.float32)
    framed[30:102, 60:188] = scenery
    assert flip_exposures(framed) == pytest.approx(flip_exposures(scenery))


def test_the_brightest_pixel_sets_the_first_exposure(scenery):
    start, _, _ = flip_exposures(scenery)
    assert flip_exposures(scenery * 4)[0] == pytest.approx(start - 2, abs=1e-5)


def test_flip_not_installed_says_how_to_get_it(monkeypatch, scenery):
    import sys

    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    with pytest.raises(DDGIError, match="pip install flip-evaluator"):
        metrics.flip_map(scenery, scenery, (0, 1, 2))
