"""Pictures of the surroundings: read as Mitsuba's `envmap` shows them."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.lighting.lights import environment_radiance
from probing import diffuse, load, sphere_points

COUNT = 20_000


def poles_and_seam():
    """Where columns or rows meet: both poles, and around the meridian where the picture's ends touch."""
    heights = np.linspace(-1, 1, 41)
    ring = np.sqrt(1 - heights**2)
    near = [np.stack([ring * np.sin(a), heights, ring * np.cos(a)], 1) for a in (-1e-3, 0, 1e-3)]
    return np.concatenate([*near, [[0, 1, 0], [0, -1, 0], [1e-4, 1, 0], [0, -1, 1e-4]]])


@pytest.mark.parametrize("size", [(32, 16), (7, 5), (2, 2)])
@pytest.mark.parametrize("angle", [0, 40])
def test_every_direction_shows_what_mitsuba_shows(size, angle):
    width, height = size
    texels = np.random.default_rng(0).random((height, width, 3)).astype(np.float32)
    turn = mi.ScalarTransform4f().rotate([0.6, 0.0, 0.8], angle)
    sky = {"type": "envmap", "bitmap": mi.Bitmap(texels), "to_world": turn, "scale": 2.0}
    scene = load({"type": "scene", "thing": {"type": "sphere", "bsdf": diffuse(0.5)}, "sky": sky})
    looks = np.concatenate([sphere_points(COUNT), poles_and_seam()])
    looks /= np.linalg.norm(looks, axis=1, keepdims=True)
    direction = mi.Vector3f(looks.T.astype(np.float32))
    beyond = dr.zeros(mi.SurfaceInteraction3f, len(looks))
    beyond.wi = -direction
    expected = np.array(mi.load_dict(sky).eval(beyond))
    found = np.array(environment_radiance(scene.lights, direction, mi.Bool(True)))
    assert expected.max() > 1
    assert np.abs(found - expected).max() < 1e-4 * width
    scene = scene.dimmed(None, 0.5)
    assert np.allclose(np.array(environment_radiance(scene.lights, direction, mi.Bool(True))), found / 2)
    dark = environment_radiance(scene.lights, direction, dr.full(mi.Bool, False, len(looks)))
    assert (np.array(dark) == 0).all()
