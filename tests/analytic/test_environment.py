"""An open scene under an even sky: E = pi L, exactly."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.frame import render_frame
from ddgi.probes.field import IrradianceField, irradiance_map
from ddgi.scene.camera import look_at
from probing import camera_in, load, query_at, rgb, small, sphere_points, updated

SKY = (1.0, 0.25, 0.03)


def under_the_sky(**more):
    """A speck of dust under an even sky; the box of interest is set by the settings."""
    dot = {"type": "sphere", "radius": 1e-4, "center": [0.913, 0.377, 0.591]}
    return load({"type": "scene", "dot": dot, "sky": {"type": "constant", "radiance": rgb(*SKY)}, **more})


@pytest.mark.parametrize("gamma", [1.0, 5.0])
@pytest.mark.parametrize(("name", "error"), [("float32", 1e-3), ("float16", 5e-3)])
def test_irradiance_is_pi_l(name, error, gamma):
    s = small(states_method="off",
        volume_irradiance_format=name, volume_distance_format="float32" if name == "float32" else "float16",
        grid_box=((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)), blend_gamma=gamma, direct_environment="field",
    )  # fmt: skip
    field = updated(under_the_sky(), s, 40)
    expected = np.pi * np.array(SKY)
    assert np.allclose(irradiance_map(field, s), expected, rtol=error)
    anywhere = np.random.default_rng(0).uniform(-2, 2, (1000, 3))
    assert np.allclose(query_at(field.volumes[0], s, anywhere, sphere_points(1000)), expected, rtol=error)


def test_sampled_sky_leaves_the_field_black():
    s = small(
        states_method="off", grid_box=((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)), direct_environment="sampled"
    )
    assert irradiance_map(updated(under_the_sky(), s, 3), s).max() < 1e-4


@pytest.mark.parametrize("environment", ["field", "sampled"])
def test_ground_under_the_sky(environment):
    """A white plate under L shows L rho, whichever way the sky is gathered."""
    plate = {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f().scale(100),
        "bsdf": {"type": "diffuse", "reflectance": rgb(0.8)},
    }
    scene = load({"type": "scene", "plate": plate, "sky": {"type": "constant", "radiance": rgb(0.5)}})
    camera = look_at((0, 0, 2.0), (0.3, 0.1, 0.0), fov=40, size=(24, 24))
    s = small(
        states_method="off",
        grid_box=((-2.0, -2.0, 0.0), (2.0, 2.0, 2.0)),
        direct_environment=environment,
        volume_irradiance_size=8,
    )
    field, frame = IrradianceField.fit(scene, s), None
    for tick in range(48):
        field, frame = render_frame(scene, field, camera, tick, s, frame)
    # Sampled, 576 pixels of 48 samples each spread by 1.3 / sqrt(27,648) = 0.8 %, less by their even
    # spread. In the field, the texels around the zenith see a little ground: 1 % for 8 x 8 texels.
    assert frame.numpy().mean() == pytest.approx(0.4, rel=0.02)


def test_the_sky_itself_is_seen():
    s = small(states_method="off", grid_box=((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)))
    scene = under_the_sky()
    _, frame = render_frame(scene, IrradianceField.fit(scene, s), camera_in((8, 8)), 0, s)
    assert np.allclose(frame.numpy(), SKY, rtol=1e-5)
