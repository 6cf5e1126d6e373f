"""What pixels see in mirrors, metals and glossy coats, against the same thing looked at directly."""

from dataclasses import replace

import mitsuba as mi
import numpy as np
import pytest

from ddgi.frame import Frame, render_frame
from ddgi.probes.field import IrradianceField
from ddgi.scene.camera import look_at
from probing import diffuse, load, rgb, small


def room(floor, **more):
    """A mirror-like floor under a wall of three colours, lit by a bulb; the rest is open."""
    stripes = np.array([[[0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8]]], np.float32)
    picture = {"type": "bitmap", "raw": True, "filter_type": "nearest", "bitmap": mi.Bitmap(stripes)}
    return load({
        "type": "scene",
        "floor": {"type": "rectangle", "bsdf": floor, "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], -90).scale(2)},
        "wall": {
            "type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": picture},
            "to_world": mi.ScalarTransform4f().translate([0, 1, -1]),
        },
        "bulb": {"type": "point", "position": [0, 1, 1.5], "intensity": rgb(5.0)},
        **more,
    })  # fmt: skip


def picture(scene, camera, frames=32, layer=None, **settings):
    s = small(**({"grid_counts": (4, 4, 4), "contact_pixels": 0.0} | settings))
    field, frame = IrradianceField.fit(scene, s), Frame.empty(camera, s)
    for tick in range(frames):
        field, frame = render_frame(scene, field, camera, tick, s, frame)
    return np.array(frame.layers[layer]) if layer else frame.numpy()


SIZE = (24, 12)


def down(fov=20.0):
    """At the floor where it mirrors the wall's middle."""
    return look_at((0, 0.6, 2.0), (0, 0, 0.7), fov=fov, size=SIZE)


def through(fov=20.0):
    """The same view from below the floor: what a perfect mirror shows, upside down."""
    return look_at((0, -0.6, 2.0), (0, 0, 0.7), fov=fov, size=SIZE)


MIRROR = {"type": "conductor", "material": "none"}


def test_a_mirror_shows_what_is_behind_its_plane():
    """The bulb's light alone, without its highlight: white floors light walls, which those that are not there do not."""
    mirrored = picture(
        room(MIRROR), down(), gather_energy_preservation=0.0, picture_layers=True, layer="indirect"
    )
    gone = {"type": "mask", "opacity": 0.0, "nested": diffuse(0.5)}
    direct = picture(room(gone), through(), picture_layers=True, layer="direct")[::-1]
    assert direct.max() > 0.2
    assert np.abs(mirrored - direct).mean() < 0.05 * direct.mean()


def test_without_tracing_a_mirror_is_matt():
    matt = picture(room(MIRROR), down(), gloss_bounces=0)
    assert np.abs(matt[..., 0] / matt[..., 2] - 1).mean() < 0.3  # no red to the left, no blue to the right
    mirrored = picture(room(MIRROR), down())
    assert (mirrored[:, 0, 0] > 3 * mirrored[:, 0, 2]).all()
    assert (mirrored[:, -1, 2] > 3 * mirrored[:, -1, 0]).all()


def test_single_frames_trace_no_reflections():
    scene, s = room(MIRROR), small(grid_counts=(4, 4, 4))
    field = IrradianceField.fit(scene, s)
    _, frame = render_frame(scene, field, down(), 0, s)
    _, plain = render_frame(scene, field, down(), 0, replace(s, gloss=replace(s.gloss, bounces=0)))
    assert np.array_equal(frame.numpy(), plain.numpy())


@pytest.mark.parametrize("area", ["sampled", "field"])
@pytest.mark.parametrize("alpha", [0.02, 0.1, 0.3])
def test_a_lamp_in_rough_metal_is_as_bright_as_for_a_path_tracer(alpha, area):
    """Whether rays of the lobe find the lamp, or samples of the lamp the lobe; nothing else gives light."""
    metal = {"type": "roughconductor", "material": "none", "alpha": alpha, "distribution": "ggx"}
    lamp = {
        "type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0, 0.6, -0.8]).scale([0.4, 0.3, 1]),
        "bsdf": diffuse(0.0), "emitter": {"type": "area", "radiance": rgb(3.0)},
    }  # fmt: skip
    scene = load({
        "type": "scene", "lamp": lamp,
        "floor": {"type": "rectangle", "bsdf": metal, "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], -90).scale(2)},
    })  # fmt: skip
    camera = down(40.0)
    ours = picture(scene, camera, frames=128, direct_area=area)
    from ddgi.judge.path_tracer import PathTracer

    truth = PathTracer(scene).render(camera, 512, 0).picture
    assert truth.mean() > 0.1
    assert ours.mean() == pytest.approx(truth.mean(), rel=0.03)


@pytest.mark.parametrize("bounces", [1, 2])
def test_a_mirror_in_a_mirror(bounces):
    """Two mirrors at a right angle show what is behind the viewer: with one bounce the second is matt."""
    scene = load({
        "type": "scene",
        "a": {"type": "rectangle", "bsdf": MIRROR, "to_world": mi.ScalarTransform4f().rotate([0, 1, 0], 45).translate([0, 0, -1])},
        "b": {"type": "rectangle", "bsdf": MIRROR, "to_world": mi.ScalarTransform4f().rotate([0, 1, 0], -45).translate([0, 0, -1])},
        "lamp": {
            "type": "rectangle", "bsdf": diffuse(0.0), "emitter": {"type": "area", "radiance": rgb(1.0)},
            "to_world": mi.ScalarTransform4f().translate([0, 0, 6]).rotate([0, 1, 0], 180),
        },
    })  # fmt: skip
    camera = look_at((0.0, 0, 3), (0, 0, -1), fov=4.0, size=SIZE)
    shown = picture(scene, camera, gloss_bounces=bounces)
    if bounces == 2:
        assert shown.mean() == pytest.approx(1, rel=0.02)
    else:
        assert shown.mean() < 0.5


def test_two_rough_bounces_converge_pixel_by_pixel():
    """Two rough metals at a right angle: every pixel tends to the path tracer's mean, none to a value of its own."""
    rough = {"type": "roughconductor", "material": "none", "alpha": 0.4, "distribution": "ggx"}
    turned = lambda angle: mi.ScalarTransform4f().rotate([0, 1, 0], angle).translate([0, 0, -1])  # noqa: E731
    bright = np.linspace(0, 4, 9, dtype=np.float32)[:, None, None].repeat(16, 1).repeat(3, 2)
    scene = load({
        "type": "scene",
        "a": {"type": "rectangle", "bsdf": rough, "to_world": turned(45)},
        "b": {"type": "rectangle", "bsdf": rough, "to_world": turned(-45)},
        "sky": {"type": "envmap", "bitmap": mi.Bitmap(bright)},
    })  # fmt: skip
    shown = picture(scene, look_at((0.0, 0, 3), (0, 0, -1), fov=4.0, size=SIZE), frames=256)
    grain = shown - shown.mean(0)  # neighbours in a row see all but the same
    assert grain.std() < 0.06 * shown.mean()


def test_a_polished_ball_strews_no_dots_on_a_rough_floor():
    """Highlights of the sun in it, met by wide lobes, were dots that no number of frames took away."""
    floor = {"type": "roughconductor", "material": "none", "alpha": 0.5, "distribution": "ggx"}
    ball = {"type": "sphere", "center": [0, 0.6, 0], "radius": 0.5, "bsdf": MIRROR}
    sun = {"type": "directional", "direction": [0.3, -1, -0.5], "irradiance": rgb(3.0)}
    view = look_at((0, 2.5, 2.5), (0, 0, 1.2), fov=30.0, size=(96, 48))
    below = picture(room(floor, ball=ball, sun=sun), view, frames=32)[24:].max(-1)  # nothing but the floor
    assert below.max() < 4 * np.median(below)


def test_walls_beside_a_lamp_strew_no_dots_through_wide_lobes():
    """One ray in hundreds meets the wall a hair from the bulb, where it is thousands of times as bright."""
    floor = {"type": "roughconductor", "material": "none", "alpha": 0.3, "distribution": "ggx"}
    near = {"type": "point", "position": [0, 1, -0.99], "intensity": rgb(0.02)}
    view = look_at((0, 0.6, 2.0), (0, 0, 0.3), fov=30.0, size=(96, 48))
    shown = picture(room(floor, near=near), view, frames=32)
    assert shown.max() < 4 * np.median(shown.max(-1))
