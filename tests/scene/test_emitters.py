"""Lights carry the energy that Mitsuba's emitters carry."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError


def load(**emitters):
    from ddgi.scene.load import load_scene

    return load_scene({"type": "scene", "floor": {"type": "rectangle"}, **emitters})


def rgb(*value):
    return {"type": "rgb", "value": list(value)}


def table(values, width):
    return np.array(values).reshape(-1, width)


def irradiance(emitter, normal, count=1 << 17):
    """(3,) of a surface with this normal [W/m^2]: Monte Carlo over the emitter's own sampling."""
    random = mi.PCG32(count)
    u = random.next_float32()
    sample, weight = emitter.sample_direction(
        dr.zeros(mi.Interaction3f, count), mi.Point2f(u, random.next_float32())
    )
    cosine = dr.maximum(dr.dot(sample.d, mi.Vector3f(normal)), 0)
    return np.array(dr.mean(weight * cosine, axis=1)).ravel()


def test_point_and_directional():
    from ddgi.lighting.lights import DIRECTIONAL, POINT

    delta = load(
        bulb={"type": "point", "position": [1, 2, 3], "intensity": rgb(4, 5, 6)},
        sun={"type": "directional", "direction": [0, -3, 4], "irradiance": rgb(7, 8, 9)},
    ).lights.delta
    assert delta.count == 2
    assert list(delta.kind) == [POINT, DIRECTIONAL]
    np.testing.assert_allclose(table(delta.position, 4)[0, :3], [1, 2, 3])
    np.testing.assert_allclose(table(delta.intensity, 4)[:, :3], [[4, 5, 6], [7, 8, 9]], rtol=1e-5)
    np.testing.assert_allclose(table(delta.direction, 4)[1, :3], [0, -0.6, 0.8], atol=1e-6)


@pytest.mark.parametrize("beam", [15.0, 5.0, 20.0])
def test_spot_falls_off_as_mitsuba_has_it(beam):
    place = mi.ScalarTransform4f().look_at(origin=[0, 3, 0], target=[0, 0, 0], up=[1, 0, 0])
    description = {
        "type": "spot",
        "to_world": place,
        "intensity": 2.0,
        "cutoff_angle": 20.0,
        "beam_width": beam,
    }
    delta = load(lamp=description).lights.delta
    cutoff, slope = table(delta.cone, 2)[0]
    np.testing.assert_allclose(table(delta.direction, 4)[0, :3], [0, -1, 0], atol=1e-6)
    angle = np.radians(np.linspace(0.5, 24.5, 49))
    it = dr.zeros(mi.SurfaceInteraction3f, angle.size)
    it.p = mi.Point3f(np.float32(3 * np.tan(angle)), 0, 0)
    _, weight = mi.load_dict(description).sample_direction(it, mi.Point2f(0.5))
    expected = np.array(weight)[0] * (3 / np.cos(angle)) ** 2
    ours = 2.0 * np.clip((cutoff - angle) * slope, 0, 1)
    np.testing.assert_allclose(ours, expected, atol=3e-4)


def test_area_lights_are_emitters_of_the_traced_scene():
    above = mi.ScalarTransform4f().translate([0, 0, 1])
    lamp = {"type": "rectangle", "to_world": above, "emitter": {"type": "area", "radiance": rgb(1, 2, 3)}}
    hidden = {"type": "sphere", "bsdf": {"type": "dielectric"}}
    scene = load(a=lamp, b=lamp, glass=hidden)
    assert scene.lights.area_count == 2
    assert dr.width(scene.lights.area) == 2
    assert scene.lights.environment is None
    assert len(scene.mi_scene.emitters()) == 2
    emission = table(scene.materials.emission, 4)
    np.testing.assert_allclose(emission[scene.shapes["a"], :3], [1, 2, 3], rtol=1e-6)
    np.testing.assert_allclose(emission[scene.shapes["floor"]], 0)
    assert scene.materials.any_emission
    si = scene.mi_scene.ray_intersect(mi.Ray3f([0.3, 0.2, 5], [0, 0, -1]))
    assert si.emitter(scene.mi_scene)[0] is not None


def test_textured_radiance_is_kept():
    picture = {"type": "bitmap", "raw": True, "bitmap": mi.Bitmap(np.full((2, 2, 3), 12.0, np.float32))}
    scene = load(screen={"type": "rectangle", "emitter": {"type": "area", "radiance": picture}})
    assert np.array(scene.materials.emission_texture)[scene.shapes["screen"]] == 0
    assert np.array(scene.materials.textures.texels)[0] == 12


def test_constant_environment_is_an_emitter_of_the_traced_scene():
    scene = load(sky={"type": "constant", "radiance": 2.0})
    assert scene.lights.environment is not None
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = mi.Vector3f(0, -1, 0)
    np.testing.assert_allclose(np.array(scene.lights.environment.eval(si)).ravel(), 2, rtol=1e-6)


@pytest.mark.parametrize("tilted", [False, True])
def test_sun_and_sky_split_without_loss(tilted):
    """Sky picture and sun row together light a surface as the model does, within 2 %."""
    turn = mi.ScalarTransform4f().rotate([1, 0, 0], -90) if tilted else mi.ScalarTransform4f()
    up = [0, 1, 0] if tilted else [0, 0, 1]
    sun = [0.6, 0.7, 0.3] if tilted else [0.6, 0.3, 0.7]
    description = {"type": "sunsky", "sun_direction": sun, "turbidity": 4.0, "to_world": turn}
    lights = load(sky=description).lights
    assert lights.delta.count == 1
    direction = table(lights.delta.direction, 4)[0, :3]
    np.testing.assert_allclose(direction, -np.array(sun) / np.linalg.norm(sun), atol=2e-3)
    ours = irradiance(lights.environment, up) + table(lights.delta.intensity, 4)[0, :3] * -(
        direction @ np.array(up)
    )
    np.testing.assert_allclose(ours, irradiance(mi.load_dict(description), up), rtol=0.02)


def test_the_baked_sky_looks_like_the_model_everywhere():
    description = {"type": "sunsky", "sun_direction": [0.6, 0.3, 0.7], "sun_scale": 0.0}
    scene = load(sky=description)
    assert any("no light" in note for note in scene.notes) is False
    directions = np.random.default_rng(5).normal(size=(3, 2000))
    directions /= np.linalg.norm(directions, axis=0)
    directions = directions[:, np.abs(directions[2]) > 0.03]  # the horizon is a jump
    si = dr.zeros(mi.SurfaceInteraction3f, directions.shape[1])
    si.wi = mi.Vector3f(np.float32(-directions))
    ours, theirs = (np.array(e.eval(si)) for e in (scene.lights.environment, mi.load_dict(description)))
    np.testing.assert_allclose(ours, theirs, rtol=0.02, atol=1e-4)
    assert scene.lights.delta.count == 0


def test_no_light_at_all_means_daylight():
    scene = load()
    assert any("no light" in note for note in scene.notes)
    assert scene.lights.environment is not None
    assert scene.lights.delta.count == 1


def test_added_sun_sky_and_lamps():
    from ddgi.lighting.lights import DIRECTIONAL
    from ddgi.scene.load import load_scene

    room = {"type": "scene", "floor": {"type": "rectangle"}}
    scene = load_scene(
        room, sun=(90, 30, 5.0), sky=(0.1, 0.2, 0.3), lights=[{"type": "point", "intensity": 3.0}], up="y"
    )
    delta = scene.lights.delta
    assert delta.count == 2
    assert int(delta.kind[0]) == DIRECTIONAL
    # Azimuth 90 degrees is +x where +y is up; light travels away from there.
    expected = [-np.cos(np.radians(30)), -0.5, 0]
    np.testing.assert_allclose(table(delta.direction, 4)[0, :3], expected, atol=1e-6)
    np.testing.assert_allclose(table(delta.intensity, 4)[0, :3], 5)
    assert not any("no light" in note for note in scene.notes)
    # An added sky takes the place of the scene's own; a sun of one's own replaces the model's.
    own = {**room, "env": {"type": "constant", "radiance": 9.0}}
    scene = load_scene(own, sky="sunsky", sun=(0, 45, 1.0))
    assert scene.lights.environment.class_name() == "EnvironmentMapEmitter"
    assert scene.lights.delta.count == 1
    assert any("gives way" in note for note in scene.notes)


@pytest.mark.parametrize("up", ["x", "y", "z", "-y"])
def test_the_sky_is_brighter_above_whatever_is_up(up):
    from ddgi.scene.load import load_scene

    scene = load_scene({"type": "scene", "floor": {"type": "rectangle"}}, up=up)
    upward = list(scene.up)
    above = irradiance(scene.lights.environment, upward, 1 << 13)
    below = irradiance(scene.lights.environment, [-x for x in upward], 1 << 13)
    assert (above > 10 * below).all()
    assert np.dot(table(scene.lights.delta.direction, 4)[0, :3], upward) < -0.5


def test_environment_picture(tmp_path):
    from ddgi.scene.load import load_scene

    path = tmp_path / "sky.exr"
    texels = np.zeros((8, 16, 3), np.float32)
    texels[:3] = 4
    mi.Bitmap(texels).write(str(path))
    room = {"type": "scene", "floor": {"type": "rectangle"}}
    scene = load_scene(room, env=path, up="z")
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = mi.Vector3f(0, 0, -1)
    np.testing.assert_allclose(np.array(scene.lights.environment.eval(si)).ravel(), 4, rtol=1e-3)
    with pytest.raises(SceneError, match="not found"):
        load_scene(room, env=tmp_path / "no.exr")
    (tmp_path / "a.png").write_bytes(b"x")
    with pytest.raises(SceneError, match="hdr"):
        load_scene(room, env=tmp_path / "a.png")


WRONG = {
    "area": {
        "type": "rectangle",
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [1, -2, 3]}},
    },
    "point": {"type": "point", "intensity": {"type": "rgb", "value": [1, float("nan"), 3]}},
    "spot": {"type": "spot", "intensity": -1.0},
    "directional": {"type": "directional", "irradiance": {"type": "rgb", "value": [1, float("inf"), 3]}},
    "constant": {"type": "constant", "radiance": -1.0},
}


@pytest.mark.parametrize("kind", WRONG)
def test_wrong_light_is_refused_by_name(kind):
    with pytest.raises(SceneError, match="culprit"):
        load(culprit=WRONG[kind])


@pytest.mark.parametrize("value", [-1.0, np.nan])
def test_wrong_environment_pictures_are_refused_by_name(value):
    texels = np.ones((4, 8, 3), np.float32)
    texels[2, 3] = value
    with pytest.raises(SceneError, match='"culprit"'):
        load(culprit={"type": "envmap", "bitmap": mi.Bitmap(texels)})


def test_undershoot_of_resampled_environment_pictures_is_black():
    """Also in the parsed scene, from which the reference is rendered."""
    texels = np.ones((16, 32, 3), np.float32)
    texels[5, 6] = -3.0
    scene = load(sky={"type": "envmap", "bitmap": mi.Bitmap(texels)})
    assert any("negative" in note for note in scene.notes)
    built = mi.parser.instantiate(mi.parser.ParserConfig(mi.variant()), scene.source)
    for environment in (scene.lights.environment, built.environment()):
        data = mi.traverse(environment)["data"].numpy()
        assert data.min() == 0
        assert data.max() == 1


def test_two_environments_are_one_too_many():
    with pytest.raises(SceneError, match="another environment"):
        load(a={"type": "constant"}, b={"type": "constant"})


def test_projectors_are_left_out_with_a_note():
    scene = load(beamer={"type": "projector", "irradiance": {"type": "checkerboard"}}, bulb={"type": "point"})
    assert scene.lights.delta.count == 1
    assert any("beamer" in note for note in scene.notes)


BAD_ADDITIONS = [
    {"sun": (0, 0, -1)},
    {"sky": "overcast"},
    {"sky": (1, 2)},
    {"lights": [{"type": "area"}]},
    {"sky": "sunsky", "env": "x.exr"},
    {"up": "w"},
]


@pytest.mark.parametrize("bad", BAD_ADDITIONS, ids=str)
def test_wrong_added_lights(bad):
    from ddgi.scene.load import load_scene

    with pytest.raises(SceneError):
        load_scene({"type": "scene", "floor": {"type": "rectangle"}}, **bad)


@pytest.mark.parametrize(("lamp", "said"), [(1.0, False), (1e4, True)])
def test_small_lamps_in_a_picture_are_noted(lamp, said):
    """Four texels of 8,192: at 1e4 they give most of the light."""
    texels = np.ones((64, 128, 3), np.float32)
    texels[20:22, 30:32] = lamp
    scene = load(sky={"type": "envmap", "bitmap": mi.Bitmap(texels)})
    assert any("direct.environment=sampled" in note for note in scene.notes) == said
