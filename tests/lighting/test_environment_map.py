"""Pictures of the surroundings: read as Mitsuba's `envmap` shows them."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.lighting import environment_map
from ddgi.lighting.lights import environment_light, environment_radiance
from probing import diffuse, load, points, sphere_points

COUNT = 20_000


def spiral(count):
    """Evenly spread directions, (count, 3)."""
    n = np.arange(count) + 0.5
    z, angle = 1 - 2 * n / count, np.pi * (1 + 5**0.5) * n
    ring = np.sqrt(1 - z * z)
    return np.stack([ring * np.cos(angle), ring * np.sin(angle), z], 1)


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


@pytest.mark.parametrize("size", [(32, 16), (7, 5), (2, 2)])
@pytest.mark.parametrize("kind", ["even", "sunny", "black"])
def test_sampled_light_is_what_the_picture_sends(size, kind):
    """Means over samples of power times x, y, z, 1 against the same over even directions; the sun is found."""
    width, height = size
    texels = np.random.default_rng(1).random((height, width, 3)).astype(np.float32)
    texels *= kind != "black"
    texels[height // 2, width // 3] *= 1000 if kind == "sunny" else 1
    turn = mi.ScalarTransform4f().rotate([0.6, 0.0, 0.8], 40)
    sky = {"type": "envmap", "bitmap": mi.Bitmap(texels), "to_world": turn}
    scene = load({"type": "scene", "thing": {"type": "sphere", "bsdf": diffuse(0.5)}, "sky": sky})
    count = 1 << 16
    u = np.random.default_rng(2).random((2, count))
    light = environment_light(scene.lights, points(np.zeros((count, 3))), mi.Point2f(u), mi.Bool(True))
    direction, power = np.array(light.direction, np.float64), np.array(light.power, np.float64)
    assert np.allclose(np.linalg.norm(direction, axis=0), 1, atol=1e-5)
    looks = spiral(8 * count)
    seen = np.array(environment_radiance(scene.lights, mi.Vector3f(points(looks)), mi.Bool(True)), np.float64)
    of = lambda d, x: (x[1] * np.concatenate([d, np.ones((1, d.shape[1]))])).mean(1)  # noqa: E731
    expected = of(looks.T, seen) * 4 * np.pi
    assert np.allclose(of(direction, power), expected, atol=0.02 * expected[3] + 1e-20)
    if kind == "sunny":
        assert power[1].std() < 1.6 * power[1].mean()  # of even directions it would be ten times the mean


def test_density_is_that_of_the_directions():
    """The mean of 1/density is the whole sphere, whatever the picture."""
    texels = np.random.default_rng(3).random((9, 12, 3)).astype(np.float32) ** 4
    sky = {"type": "envmap", "bitmap": mi.Bitmap(texels)}
    scene = load({"type": "scene", "thing": {"type": "sphere", "bsdf": diffuse(0.5)}, "sky": sky})
    u = mi.Point2f(np.random.default_rng(4).random((2, 1 << 18)))
    _, density = environment_map.sample(scene.lights.environment_map, u)
    assert np.mean(1 / np.array(density, np.float64)) == pytest.approx(4 * np.pi, rel=0.01)
