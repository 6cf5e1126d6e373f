"""What pixels see."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.passes import gbuffer
from ddgi.sampling import clock
from ddgi.scene.camera import look_at, make_camera, with_near
from probing import dark_light, diffuse, load

STILL = gbuffer.Settings(antialias=False)


def wall(bsdf=None, half=4.0):
    """A wall across z = 0 that looks towards +z."""
    shape = {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f().scale(half),
        "bsdf": bsdf or diffuse(0.5),
    }
    return load({"type": "scene", "dark": dark_light(), "wall": shape})


def seen(scene, camera, tick=0, s=STILL):
    return gbuffer.gbuffer(scene.tracer, camera, clock(0, tick), s)


def grid_of(camera, x):
    return np.array(x, np.float64).T.reshape(camera.size[1], camera.size[0], -1)


def test_pixels_lie_where_the_pinhole_puts_them():
    """Five metres before the wall, 90 degrees wide: the picture spans +-5 m across, +-2.5 m up."""
    camera = look_at((0, 0, 5.0), (0, 0, 0), fov=90, size=(8, 4))
    p = grid_of(camera, seen(wall(half=9.0), camera).position)
    x = (np.arange(8) + 0.5) / 8 * 10 - 5
    y = 2.5 - (np.arange(4) + 0.5) / 4 * 5
    assert np.allclose(p[..., 0], x[None], atol=1e-4)  # row by row from the top left
    assert np.allclose(p[..., 1], y[:, None], atol=1e-4)


def test_depth_runs_along_the_ray():
    camera = look_at((0, 0, 5.0), (0, 0, 0), fov=90, size=(8, 4))
    hit = seen(wall(half=9.0), camera)
    p = grid_of(camera, hit.position)
    assert np.allclose(
        grid_of(camera, hit.distance)[..., 0], np.linalg.norm(p - [0, 0, 5.0], axis=-1), rtol=1e-5
    )


def test_orthographic_rays_are_parallel():
    camera = make_camera("map", (0, 0, 5.0), (0, 0, -1), (2, 0, 0), (0, 1, 0), (8, 4), orthographic=True)
    hit = seen(wall(), camera)
    assert np.allclose(np.array(hit.distance), 5, rtol=1e-5)
    assert np.allclose(grid_of(camera, hit.position)[0, :, 0], (np.arange(8) + 0.5) / 8 * 4 - 2, atol=1e-5)


def test_the_near_plane_hides_what_is_closer():
    """To the camera alone: a wall 5 m away is there at 4.9 m and gone at 5.1 m, in every pixel."""
    camera = look_at((0, 0, 5.0), (0, 0, 0), fov=60, size=(8, 4))
    assert np.array(seen(wall(), with_near(camera, 4.9)).valid).all()
    assert not np.array(seen(wall(), with_near(camera, 5.1)).valid).any()


def test_antialiasing_fills_the_pixel_evenly():
    camera = look_at((0, 0, 5.0), (0, 0, 0), fov=90, size=(2, 2))
    scene = wall(half=20.0)
    offsets = np.array(
        [grid_of(camera, seen(scene, camera, t, gbuffer.Settings()).position)[0, 0, :2] for t in range(64)]
    )
    # The top left pixel spans x in [-5, 0], y in [0, 5].
    u = (offsets - [-5, 0]) / 5
    assert u.min() >= 0
    assert u.max() <= 1
    assert len({tuple(c) for c in np.floor(u * 4).astype(int)}) == 16  # no cell of 4 x 4 is left out
    assert np.allclose(u.mean(0), 0.5, atol=0.05)


def test_without_antialiasing_frames_repeat():
    camera = look_at((0.3, 0.2, 5.0), (0, 0, 0), size=(16, 9))
    a, b = (np.array(seen(wall(), camera, t).position) for t in (1, 2))
    assert np.array_equal(a, b)


def test_camera_rays_pass_masks_by_their_share():
    mask = {"type": "mask", "opacity": 0.3, "nested": diffuse(0.5, two_sided=True)}
    camera = look_at((0, 0, 5.0), (0, 0, 0), fov=30, size=(128, 128))
    valid = np.array(seen(wall(mask), camera).valid)
    assert valid.mean() == pytest.approx(0.3, abs=4.5 * np.sqrt(0.21 / valid.size))
    assert dr.width(seen(wall(mask), camera).distance) == 128 * 128
