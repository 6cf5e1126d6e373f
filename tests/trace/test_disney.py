"""Disney's diffuse term: its means are those of the term itself, summed up by hand."""

import numpy as np
import pytest

from ddgi.trace import disney

MIDDLE = (np.arange(200) + 0.5) / 200
ROUGHNESS = (0.0, 0.4, 1.0)


def between(light, viewer, azimuth):
    """Cosine of the angle between two directions, from those with the normal and the azimuth between them."""
    return light * viewer + np.sqrt((1 - light**2) * (1 - viewer**2)) * np.cos(azimuth)


@pytest.mark.parametrize("roughness", ROUGHNESS)
@pytest.mark.parametrize("viewer", [0.02, 0.3, 0.6, 1.0])
def test_mean_over_light_from_everywhere(viewer, roughness):
    light, azimuth = np.meshgrid(MIDDLE, np.pi * MIDDLE, indexing="ij")
    term = disney.towards(light, viewer, between(light, viewer, azimuth), roughness)
    assert disney.under_even_light(viewer, roughness) == pytest.approx((2 * light * term).mean(), abs=1e-4)


@pytest.mark.parametrize("roughness", ROUGHNESS)
def test_mean_over_both_directions(roughness):
    term = disney.under_even_light(MIDDLE, roughness)
    assert disney.even(roughness) == pytest.approx((2 * MIDDLE * term).mean(), abs=1e-4)


@pytest.mark.parametrize("roughness", ROUGHNESS)
def test_light_and_viewer_may_change_places(roughness):
    a, b = np.random.default_rng(1).uniform(0, 1, (2, 100))
    cosine = between(a, b, 1.0)
    np.testing.assert_allclose(
        disney.towards(a, b, cosine, roughness), disney.towards(b, a, cosine, roughness)
    )
