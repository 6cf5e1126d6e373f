"""What does not fit together is refused, in one line, rather than drawn as nonsense."""

from dataclasses import replace

import pytest

from ddgi import IrradianceField, RenderSettings, SettingsError, load_scene, render_frame
from ddgi.scene.camera import with_size

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
        ({"query": {"sqrt_blending": False}}, "sqrt_blending"),
    ],
)
def test_a_field_of_other_settings(scene, other, named):
    field = IrradianceField.fit(scene, settings())
    with pytest.raises(SettingsError, match=named):
        render_frame(scene, field, scene.camera, 0, settings(**other))


def test_a_previous_frame_of_another_size_or_other_layers(scene):
    s = settings()
    field, frame = render_frame(scene, IrradianceField.fit(scene, s), scene.camera, 0, s)
    with pytest.raises(SettingsError, match="previous frame"):
        render_frame(scene, field, with_size(scene.camera, (16, 16)), 1, s, frame)
    with pytest.raises(SettingsError, match="layers"):
        render_frame(scene, field, scene.camera, 1, settings(picture={"layers": True}), frame)


def test_settings_that_may_change_between_frames(scene):
    s = settings()
    field, frame = render_frame(scene, IrradianceField.fit(scene, s), scene.camera, 0, s)
    render_frame(scene, field, scene.camera, 1, settings(query={"wrap_offset": 0.2}), frame)
