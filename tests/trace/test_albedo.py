"""How much materials send back: limits known on paper, and the inverse."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.trace.albedo import albedo, facing, gloss, rough_share


def test_smooth_facets_lose_nothing_and_rough_ones_more_and_more():
    assert rough_share(0.0) == 1
    shares = rough_share(np.linspace(0, 1, 50))
    assert (np.diff(shares) < 0).all()
    assert shares[-1] == pytest.approx(0.375, abs=0.002)  # Mitsuba's white `roughconductor` of alpha 1


def test_without_reflectance_there_is_no_gloss():
    assert gloss(0.0, 0.3) == 0
    assert albedo(0.4, 0.0, 0.3, 0.0, False) == pytest.approx(0.4)


@pytest.mark.parametrize("eta", [1.3, 1.5, 2.0])
def test_smooth_gloss_is_the_diffuse_fresnel_reflectance(eta):
    cosine = (np.arange(4096) + 0.5) / 4096
    exact = 2 * np.mean(np.array(mi.fresnel(mi.Float(cosine), mi.Float(eta))[0], np.float64) * cosine)
    assert gloss(((eta - 1) / (eta + 1)) ** 2, 0.0) == pytest.approx(exact, abs=0.013)


@pytest.mark.parametrize("alpha", [0.0, 0.2, 0.9])
def test_facing_is_the_inverse_of_gloss(alpha):
    for f0 in (0.2, 0.5, 1.0):
        assert facing(gloss(f0, alpha), alpha) == pytest.approx(f0)


def test_never_more_than_arrives():
    base, metallic, alpha, specular = (mi.Float(x) for x in np.random.default_rng(0).random((4, 10_000)))
    whole = np.array(albedo(base, metallic, alpha, specular, base > 0.5))
    assert (whole >= 0).all()
    assert (whole <= 1).all()
    assert albedo(1.0, 0.0, 0.0, 0.04, False) == 1
    assert albedo(1.0, 1.0, 0.0, 0.04, True) == 1
