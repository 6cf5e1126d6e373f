"""The quality gate: light must not get worse. `regions.py` says against what, and how to set it anew."""

import json

import numpy as np
import pytest

from quality.regions import KEPT, REGION, SCENES, SIZE, error, region_means

ALLOWED = 1.05
"""How much the mean FLIP of a scene may rise."""

kept = json.loads(KEPT.read_text())


def test_every_scene_has_its_numbers():
    assert kept.keys() == SCENES.keys()
    for numbers in kept.values():
        assert np.shape(numbers["means"]) == (SIZE[1] // REGION, SIZE[0] // REGION, 3)
        assert numbers["noise"] < 0.5 * numbers["flip_mean"], "errors would drown in the reference's noise"


def test_regions_are_means():
    picture = np.zeros((12, 18, 3))
    picture[:6, 6:12] = 3.0
    picture[0, 12] = 36.0
    assert np.allclose(region_means(picture)[..., 0], [[0, 3, 1], [0, 0, 0]])


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_light_is_no_worse_than_it_was(name):
    numbers = kept[name]
    assert error(name, np.array(numbers["means"])) <= ALLOWED * numbers["flip_mean"]
