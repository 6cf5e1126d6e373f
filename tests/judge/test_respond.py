"""Response: of one bounce, known on paper; and what is said where there is none."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError
from ddgi.judge.respond import frames_to_cover, respond
from ddgi.scene.camera import look_at
from probing import camera_in, dark_light, diffuse, load, rgb, room, small


def bulb(x, intensity=1.0):
    return {"type": "point", "position": [x, 0.4, 0.1], "intensity": rgb(intensity)}


def scene_with(albedo=0.5, **lights):
    return load(room(diffuse(albedo), **lights), camera=camera_in((16, 12)))


def settings(**values):
    few = {"grid_counts": (3, 3, 3), "rays_per_probe": 64, "volume_irradiance_size": 4}
    return small(**(few | values))


def one_bounce(**values):
    """The field holds what lamps light, and nothing feeds back."""
    return settings(gather_energy_preservation=0.0, contact_hits=0.0, **values)


# ---- counting ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("hysteresis", "frames"), [(0.97, 76), (0.9, 22), (0.5, 4), (0.0, 1)])
def test_paper(hysteresis, frames):
    """ln 0.1 / ln 0.97 = 75.6."""
    left = hysteresis ** np.arange(200)
    assert frames_to_cover(left, 0.0) == frames
    assert frames_to_cover(1 - left, 1.0) == frames
    assert frames_to_cover(2 + 3 * left, 2.0) == frames


def test_a_curve_that_does_not_get_there():
    assert frames_to_cover(np.linspace(1, 0.11, 50), 0.0) is None
    assert frames_to_cover(np.array([1.0]), 0.0) is None


# ---- scenes ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("hysteresis", "frames"), [(0.97, 76), (0.9, 22), (0.5, 4)])
def test_one_bounce_takes_as_long_as_on_paper(hysteresis, frames):
    s = one_bounce(
        blend_hysteresis=hysteresis, rays_per_probe=128
    )  # 64 are too noisy where little is averaged
    result = respond(scene_with(bulb=bulb(0.2)), s)
    # Off: every texel falls alike. On: the noise, below 1 % of the step, crosses 90 % some frames off.
    assert result.off.frames == pytest.approx(frames, abs=1)
    assert result.on.frames == pytest.approx(frames, abs=max(1, 0.06 * frames))
    assert result.noise < 0.01
    assert len(result.off.curve) == result.off.frames + 1
    assert result.off.curve[-1] == pytest.approx(0.1 * result.off.curve[0], rel=1 - hysteresis + 0.02)
    assert result.on.curve[0] == 0


@pytest.mark.slow
def test_gamma_follows_falling_light_faster_and_rising_light_slower():
    """S^(1/5) is blended: a^(5 n) = 0.1 after 15.1 frames; (1 - a^n)^5 = 0.9 after 127."""
    result = respond(scene_with(bulb=bulb(0.2)), one_bounce(blend_gamma=5.0))
    assert result.off.frames == pytest.approx(16, abs=1)
    assert result.on.frames == pytest.approx(127, abs=13)


@pytest.mark.slow
def test_bounces_make_it_slower():
    s = settings(blend_hysteresis=0.8)
    once = respond(scene_with(bulb=bulb(0.2)), one_bounce(blend_hysteresis=0.8))
    often = respond(scene_with(0.8, bulb=bulb(0.2)), s)
    assert often.off.frames > 1.3 * once.off.frames
    assert often.on.frames > 1.3 * once.on.frames


@pytest.mark.slow
def test_one_of_two_lights():
    """The other goes on; the level ends where it alone has it."""
    scene = scene_with(near=bulb(0.2), far=bulb(-0.5, 0.5))
    s = one_bounce(blend_hysteresis=0.9)
    result = respond(scene, s, "near")
    assert result.light == "near"
    assert result.off.frames == pytest.approx(22, abs=4)
    assert result.on.frames == pytest.approx(22, abs=4)
    assert result.on.curve[0] > 0
    assert respond(scene, s, 0) == result


def test_never_within_the_limit_is_said():
    result = respond(scene_with(bulb=bulb(0.2)), one_bounce(), limit=5)
    assert result.off.frames is None
    assert result.on.frames is None
    assert result.figures()["off_frames"] is None
    assert len(result.off.curve) == 6


@pytest.mark.parametrize("preset_warm_up", [0, 8])
def test_warm_up_of_the_settings_does_not_matter(preset_warm_up):
    s = one_bounce(blend_hysteresis=0.9, blend_warm_up=preset_warm_up)
    assert respond(scene_with(bulb=bulb(0.2)), s).off.frames == pytest.approx(22, abs=1)


def test_lights_without_effect_are_refused():
    scene = scene_with(bulb=bulb(0.2), off=dark_light())
    with pytest.raises(SceneError, match="light 'off' hardly changes the indirect light"):
        respond(scene, settings(), "off")
    with pytest.raises(SceneError, match=r"no indirect light \(it is black\)"):
        respond(scene.dimmed(None, 0), settings())


def lone(shape):
    """One shape under a point light, and nothing for the light to bounce to."""
    lamp = {"type": "point", "position": [0.2, 0.1, 1.5], "intensity": rgb(1.0)}
    view = look_at((0, -2, 2), (0, 0, 0), up=(0, 0, 1), size=(16, 12))
    return load({"type": "scene", "shape": shape | {"bsdf": diffuse(0.8)}, "lamp": lamp}, camera=view)


@pytest.mark.parametrize(
    ("scene", "why"),
    [
        (lambda: scene_with(0.0, bulb=bulb(0.2)), r"no indirect light \(it is black\)"),
        # What the texels at the horizon of probes just above it saw of it is half a percent of its light.
        (lambda: lone({"type": "rectangle"}), "together hardly change the indirect light"),
        (
            lambda: lone({"type": "sphere", "radius": 0.3}),
            r"no indirect light \(all its light is direct\)",
        ),
    ],
    ids=["black room", "floor", "ball"],
)
def test_direct_light_alone_is_refused(scene, why):
    with pytest.raises(SceneError, match=why):
        respond(scene(), settings())


def test_the_field_alone_lights_what_no_lamp_reaches():
    """All lamps are left to the field: there is no direct light to compare with."""
    lamp = {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f().translate([0, 0.95, 0]).rotate([1, 0, 0], 90).scale(0.4),
        "emitter": {"type": "area", "radiance": rgb(3.0)},
        "bsdf": diffuse(0.0),
    }
    scene = load(room(diffuse(0.5), lamp=lamp), camera=camera_in((16, 12)))
    s = one_bounce(blend_hysteresis=0.9, direct_area="field", rays_per_probe=1024)
    assert respond(scene, s).off.frames is not None


def test_unknown_lights_are_refused_before_the_work():
    with pytest.raises(SceneError, match=r"no light 'lamp': there are bulb \(point\)"):
        respond(scene_with(bulb=bulb(0.2)), settings(), "lamp")
