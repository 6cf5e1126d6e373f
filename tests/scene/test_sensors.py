"""Cameras see exactly what Mitsuba's sensors see."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError, SettingsError

FILM = {"type": "hdrfilm", "width": 96, "height": 64}


def load(**sensors):
    from ddgi.scene.load import load_scene

    return load_scene({"type": "scene", **sensors, "ball": {"type": "sphere"}})


def pose():
    return mi.ScalarTransform4f().look_at(origin=[1, 2.5, -3], target=[0.2, 0.4, 1], up=[0.1, 1, 0])


def vectors(array):
    return np.array(array, np.float64).reshape(3, -1).T


def our_rays(camera, x, y):
    """Origins and unit directions, by the formula in `Camera`'s docstring."""
    position, forward, right, up = (
        vectors(v) for v in (camera.position, camera.forward, camera.right, camera.up)
    )
    offset = (2 * x - 1)[:, None] * right + (1 - 2 * y)[:, None] * up
    if camera.orthographic:
        return position + offset, np.broadcast_to(forward, offset.shape)
    direction = forward + offset
    return np.broadcast_to(position, offset.shape), direction / np.linalg.norm(
        direction, axis=1, keepdims=True
    )


CASES = {
    "default axis": {"fov": 50},
    "y": {"fov": 50, "fov_axis": "y"},
    "diagonal": {"fov": 70, "fov_axis": "diagonal"},
    "smaller": {"fov": 40, "fov_axis": "smaller"},
    "larger": {"fov": 40, "fov_axis": "larger"},
    "focal length": {"focal_length": "35mm"},
    "principal point": {"fov": 60, "principal_point_offset_x": 0.2, "principal_point_offset_y": -0.1},
    "crop": {
        "fov": 60,
        "film": {**FILM, "crop_width": 30, "crop_height": 20, "crop_offset_x": 5, "crop_offset_y": 40},
    },
    "thin lens": {"type": "thinlens", "fov": 50, "aperture_radius": 0.1, "focus_distance": 3.0},
    "orthographic": {"type": "orthographic"},
}


@pytest.mark.parametrize("case", CASES)
def test_rays_are_those_of_the_sensor(case):
    description = {"type": "perspective", "film": FILM, "to_world": pose(), **CASES[case]}
    if case == "orthographic":
        description["to_world"] = description["to_world"] @ mi.ScalarTransform4f().scale([2.0, 2.0, 1.0])
    camera = load(sensor=description).camera
    sensor = mi.load_dict(description)
    x, y = np.random.default_rng(1).random((2, 64)).astype(np.float32)
    ray, _ = sensor.sample_ray(0.0, 0.5, mi.Point2f(x, y), mi.Point2f(0.5))
    origin, direction = our_rays(camera, x, y)
    np.testing.assert_allclose(direction, np.broadcast_to(vectors(ray.d), direction.shape), atol=3e-6)
    # Mitsuba starts rays on the near plane: the lines must be the same.
    apart = vectors(ray.o) - origin
    np.testing.assert_allclose(np.cross(apart, direction), 0, atol=1e-5)
    assert camera.size == tuple(sensor.film().crop_size())


def test_a_mirrored_sensor_stays_mirrored():
    flip = mi.ScalarTransform4f().scale([-1.0, 1.0, 1.0])
    description = {"type": "perspective", "fov": 50, "film": FILM, "to_world": pose() @ flip}
    camera, sensor = load(sensor=description).camera, mi.load_dict(description)
    ray, _ = sensor.sample_ray(0.0, 0.5, mi.Point2f(0.9, 0.2), mi.Point2f(0.5))
    np.testing.assert_allclose(
        our_rays(camera, np.array([0.9]), np.array([0.2]))[1], vectors(ray.d), atol=3e-6
    )


def test_near_is_zero_unless_the_file_asks():
    scene = load(
        a={"type": "perspective", "film": FILM, "to_world": pose()},
        b={"type": "perspective", "film": FILM, "to_world": pose(), "near_clip": 0.75},
    )
    assert [float(c.near[0]) for c in scene.cameras] == [0.0, 0.75]


def test_select_camera_by_name_and_number():
    sensor = {"type": "perspective", "film": FILM}
    scene = load(left=sensor, right=sensor)
    assert scene.select_camera("right").camera.name == "right"
    assert scene.select_camera(1).camera.name == "right"
    assert {c.name for c in scene.select_camera("right").cameras} == {"left", "right"}
    with pytest.raises(SceneError, match="left, right"):
        scene.select_camera("middle")
    with pytest.raises(SceneError, match="left, right"):
        scene.select_camera(2)


def test_look_at_and_what_may_be_changed_about_it():
    from ddgi.scene.camera import look_at, with_near, with_size

    camera = look_at((0, 0, 0), (0, 0, -2), fov=90, size=(200, 100))
    np.testing.assert_allclose(vectors(camera.forward), [[0, 0, -1]], atol=1e-7)
    np.testing.assert_allclose(vectors(camera.right), [[1, 0, 0]], atol=1e-6)
    np.testing.assert_allclose(vectors(camera.up), [[0, 0.5, 0]], atol=1e-6)
    square = with_size(camera, (64, 64))
    np.testing.assert_allclose(vectors(square.right), [[1, 0, 0]], atol=1e-6)
    np.testing.assert_allclose(vectors(square.up), [[0, 1, 0]], atol=1e-6)
    assert square.size == (64, 64)
    wide = with_size(camera, (400, 100))
    np.testing.assert_allclose(vectors(wide.right), [[2, 0, 0]], atol=1e-6)
    np.testing.assert_allclose(vectors(wide.up), [[0, 0.5, 0]], atol=1e-6)
    assert float(with_near(camera, 0.5).near[0]) == 0.5
    with pytest.raises(SettingsError, match="pixels"):
        with_size(camera, (0, 4))
    with pytest.raises(SettingsError, match="near"):
        with_near(camera, -1)
    with pytest.raises(SettingsError, match="pixels"):
        with_size(camera, (100_000, 100_000))
    with pytest.raises(SettingsError, match="where it stands"):
        look_at((1, 1, 1), (1, 1, 1))
    with pytest.raises(SettingsError, match="choose another up"):
        look_at((1, 1, 1), (1, 3, 1))
    with pytest.raises(SettingsError, match="target must be three finite"):
        look_at((1, 1, 1), (1, float("nan"), 1))
    with pytest.raises(SettingsError, match="180"):
        look_at((0, 0, 0), (0, 0, 1), fov=180)


def test_a_sensor_at_nan_is_named():
    matrix = np.eye(4)
    matrix[0, 3] = np.nan
    with pytest.raises(SceneError, match='"eye"'):
        load(eye={"type": "perspective", "film": FILM, "to_world": mi.ScalarTransform4f(matrix)})


def test_other_sensors_are_left_out():
    scene = load(meter={"type": "radiancemeter", "origin": [0, 0, 3], "direction": [0, 0, -1]})
    assert any("radiancemeter" in note for note in scene.notes)
