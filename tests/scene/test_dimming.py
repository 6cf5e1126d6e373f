"""Lights turned down: the picture follows in proportion, and nothing is recorded anew."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError
from ddgi.frame import advance, expose, render_frame
from ddgi.probes.field import IrradianceField
from probing import camera_in, diffuse, load, rgb, small


def lamp(x, radiance):
    place = mi.ScalarTransform4f().translate([x, 0.95, 0]).rotate([1, 0, 0], 90).scale(0.2)
    glow = {"type": "area", "radiance": radiance}
    return {"type": "rectangle", "to_world": place, "emitter": glow, "bsdf": diffuse(0.2)}


KINDS = {
    "bulb": "point",
    "torch": "spot",
    "sun": "directional",
    "lamp": "area",
    "screen": "area",
    "sky": "environment",
}


def every_light():
    texels = np.linspace(0.5, 4, 48, dtype=np.float32).reshape(4, 4, 3)
    down = mi.ScalarTransform4f().look_at(origin=[0, 0.5, 0], target=[0.2, -0.3, -1], up=[0, 1, 0])
    return {
        "bulb": {"type": "point", "position": [0.2, 0.5, 0.1], "intensity": rgb(1, 2, 3)},
        "torch": {"type": "spot", "to_world": down, "intensity": rgb(5.0)},
        "sun": {"type": "directional", "direction": [0.1, -0.2, -1], "irradiance": rgb(2.0)},
        "lamp": lamp(-0.5, rgb(4, 3, 2)),
        "screen": lamp(0.5, {"type": "bitmap", "raw": True, "bitmap": mi.Bitmap(texels)}),
        "sky": {"type": "constant", "radiance": rgb(0.3, 0.5, 0.7)},
    }


def side(to_world, albedo):
    return {"type": "rectangle", "to_world": to_world, "bsdf": diffuse(albedo)}


def floor():
    return side(mi.ScalarTransform4f().translate([0, -1, 0]).rotate([1, 0, 0], -90), 0.6)


def scene_with(*names):
    """A floor, a back wall and a left wall under some of the lights."""
    t = mi.ScalarTransform4f
    return load({
        "type": "scene",
        "floor": floor(),
        "back": side(t().translate([0, 0, -1]), 0.7),
        "left": side(t().translate([-1, 0, 0]).rotate([0, 1, 0], 90), 0.5),
        **{name: light for name, light in every_light().items() if name in names},
    })  # fmt: skip


def pictures(scene, s, frames=3):
    """(immediate, indirect), (N, 3) each."""
    field, frame = IrradianceField.fit(scene, s), None
    for tick in range(frames):
        field, frame = render_frame(scene, field, camera_in((24, 18)), tick, s, frame)
    return np.array(frame.picture.immediate).T, np.array(frame.picture.indirect).T


def modes(mode):
    # Light paths are shared out over all lamps, also those that are off, and would have other noise.
    return small(direct_area=mode, direct_environment=mode, picture_layers=True, rays_from_lamps=0)


def test_lights_have_names_and_kinds():
    lights = scene_with(*KINDS).named_lights
    assert [light.name for light in lights] == list(KINDS)
    assert [light.kind for light in lights] == list(KINDS.values())


def test_names_are_made_up_where_there_are_none(tmp_path):
    path = tmp_path / "scene.xml"
    bulb = '<emitter type="point"><rgb name="intensity" value="1"/></emitter>'
    ball = (
        '<shape type="sphere"><emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>'
        '<shape type="sphere" id="big"/>'
    )
    path.write_text(f'<scene version="3.0.0">{bulb}{bulb}{ball}<emitter type="sunsky"/></scene>')
    names = [light.name for light in load(path).named_lights]
    assert names == ["point", "point-2", "environment-sun", "sphere", "environment"]


@pytest.mark.parametrize("mode", ["sampled", "field"])
def test_all_off_is_black(mode):
    for part in pictures(scene_with(*KINDS).dimmed(None, 0), modes(mode)):
        assert (part == 0).all()


@pytest.mark.parametrize("mode", ["sampled", "field"])
@pytest.mark.parametrize("name", [*KINDS, None])
def test_half_the_light_is_half_the_picture(name, mode):
    """One light alone, and all together. Half is exact in floating point, but for the maps' square roots."""
    scene = scene_with(*(KINDS if name is None else [name]))
    whole, half = pictures(scene, modes(mode)), pictures(scene.dimmed(name, 0.5), modes(mode))
    assert whole[1].max() > 1e-3
    assert whole[0].max() > 1e-3 or mode == "field"
    assert np.array_equal(half[0], whole[0] / 2)
    assert np.allclose(half[1], whole[1] / 2, rtol=1e-5)


@pytest.mark.parametrize("name", ["bulb", "torch", "sun", "sky"])
def test_one_light_off_is_the_scene_without_it(name):
    s = modes("sampled")
    off = pictures(scene_with(*KINDS).dimmed(name, 0), s)
    without = pictures(scene_with(*(n for n in KINDS if n != name)), s)
    for a, b in zip(off, without, strict=True):
        # The other lights' samples are the same; only sums come in another order.
        assert np.allclose(a, b, atol=1e-5 * b.max())


def test_lamps_add_up():
    """Either of two lamps off, and the other: together as with both. 7,000 samples each spread by 1 %."""
    s = small(direct_camera_samples=16)
    scene = load({"type": "scene", "floor": floor(), "a": lamp(-0.5, rgb(2.0)), "b": lamp(0.4, rgb(5.0))})
    both, a, b = (pictures(x, s, 1)[0].mean() for x in (scene, scene.dimmed("b", 0), scene.dimmed("a", 0)))
    assert min(a, b) > 0.1 * both
    assert a + b == pytest.approx(both, rel=0.04)


def test_shares_multiply_and_the_scene_stays_as_it_was():
    scene = scene_with(*KINDS)
    before = [np.array(x) for x in (scene.lights.delta.intensity, scene.materials.emission)]
    twice = scene.dimmed("lamp", 0.5).dimmed(3, 0.5).dimmed("sky", 3.0)
    assert np.allclose(np.array(twice.lights.area_share), [0.25, 1])
    assert np.allclose(np.array(twice.lights.environment_share), 3)
    scene.dimmed(None, 0)
    for x, y in zip(before, (scene.lights.delta.intensity, scene.materials.emission), strict=True):
        assert np.array_equal(x, np.array(y))
    assert twice.mi_scene is scene.mi_scene


@pytest.mark.slow
@pytest.mark.parametrize("names", [["bulb"], ["lamp"], ["sky"], list(KINDS)])
def test_dimming_records_nothing_anew(names):
    scene, s = scene_with(*names), modes("field")
    pictures(scene, s, 6)  # up to the second recording, if there is one
    before = advance().recordings, expose().recordings
    for share in (0, 0.5, 1, 7):
        pictures(scene.dimmed(None, share), s)
        for light in names:
            pictures(scene.dimmed(light, share), s, 2)
    assert (advance().recordings, expose().recordings) == before


@pytest.mark.parametrize("light", ["lantern", 6, -1, "6", ""])
def test_unknown_lights_are_refused(light):
    with pytest.raises(SceneError, match=r"no light .*bulb \(point\), .*sky \(environment\)"):
        scene_with(*KINDS).dimmed(light, 0.5)


@pytest.mark.parametrize("share", [-0.1, np.nan, np.inf])
def test_wrong_shares_are_refused(share):
    with pytest.raises(SceneError, match="0 or more"):
        scene_with("bulb").dimmed(None, share)


def test_sampled_lights_are_off_at_points():
    """No lamp is picked when all are off."""
    from ddgi.lighting.lights import pick_area_light

    lights = scene_with("lamp", "screen").dimmed(None, 0).lights
    _, chance = pick_area_light(lights, dr.zeros(mi.Point3f, 8), dr.arange(mi.Float, 8) / 8)
    assert (np.array(chance) == 0).all()
