"""What does not fit together is refused, in one line, rather than drawn as nonsense."""

from dataclasses import replace

import numpy as np
import pytest

from ddgi import IrradianceField, RenderSettings, SettingsError, load_scene, render_frame
from ddgi.scene.camera import look_at, with_size

SMALL = {"grid": {"counts": (3, 3, 3)}, "rays": {"per_probe": 16}}


def settings(**groups):
    s = RenderSettings.preset("default")
    for name, fields in (SMALL | groups).items():
        s = replace(s, **{name: replace(getattr(s, name), **fields)})
    return s


@pytest.fixture(scope="module")
def scene():
    return load_scene("cornell-point", size=(32, 24))


@pytest.mark.parametrize(
    ("other", "named"),
    [
        ({"volume": {"irradiance_size": 16}}, "volume"),
        ({"volume": {"irradiance_format": "rgbe8"}}, "volume"),
        ({"query": {"sqrt_blending": True}}, "sqrt_blending"),
    ],
)
def test_a_field_of_other_settings(scene, other, named):
    field = IrradianceField.fit(scene, settings())
    with pytest.raises(SettingsError, match=named):
        render_frame(scene, field, scene.camera, 0, settings(**other))


def frames_in(frame):
    return int(frame.picture.frames[0])


@pytest.mark.parametrize("change", ["size", "place", "layers"])
def test_a_previous_frame_of_another_picture_is_not_averaged_in(scene, change):
    s, camera = settings(), scene.camera
    field, frame = render_frame(scene, IrradianceField.fit(scene, s), camera, 0, s)
    if change == "size":
        camera = with_size(camera, (16, 16))
    elif change == "place":
        camera = look_at((0, 0, 3), (0, 0, 0), size=camera.size)
    else:
        s = settings(picture={"layers": True})
    _, mixed = render_frame(scene, field, camera, 1, s, frame)
    _, fresh = render_frame(scene, field, camera, 1, s)
    assert frames_in(mixed) == 1
    assert np.array_equal(mixed.numpy(), fresh.numpy())


def test_a_camera_built_anew_with_the_same_numbers_goes_on(scene):
    s = settings()
    field, frame = IrradianceField.fit(scene, s), None
    for tick in range(3):
        camera = look_at((0, 0, 3), (0, 0, 0), size=(8, 8))
        field, frame = render_frame(scene, field, camera, tick, s, frame)
    assert frames_in(frame) == 3


@pytest.mark.parametrize("tick", [-1, 2**32, 1.5])
def test_ticks_that_are_none(scene, tick):
    s = settings()
    with pytest.raises(SettingsError, match="tick must be a whole number"):
        render_frame(scene, IrradianceField.fit(scene, s), scene.camera, tick, s)


def test_a_volume_outside_the_scene(scene):
    s = settings(grid={"counts": (3, 3, 3), "box": ((10.0, 0.0, 0.0), (12.0, 1.0, 1.0))})
    with pytest.raises(SettingsError, match="wholly outside the scene"):
        IrradianceField.fit(scene, s)


@pytest.mark.parametrize(
    ("group", "field", "value"),
    [("blend", "hysteresis", float("nan")), ("rays", "per_probe", 7), ("query", "wrap", "round")],
)
def test_settings_built_in_python_are_checked_where_they_are_built(group, field, value):
    with pytest.raises(SettingsError, match=rf"^{group}\.{field} must be"):
        replace(getattr(RenderSettings(), group), **{field: value})


def test_numbers_of_numpy_are_numbers():
    s = replace(RenderSettings().rays, per_probe=np.int64(64))
    assert type(s.per_probe) is int
    assert replace(RenderSettings().blend, gamma=np.float32(2)).gamma == 2.0


def test_groups_are_not_mixed_up():
    s = RenderSettings()
    with pytest.raises(SettingsError, match="rays must be a group"):
        replace(s, rays=s.blend)


def test_settings_that_may_change_between_frames(scene):
    s = settings()
    field, frame = render_frame(scene, IrradianceField.fit(scene, s), scene.camera, 0, s)
    render_frame(scene, field, scene.camera, 1, settings(query={"wrap_offset": 0.2}), frame)
