"""Lights and cameras where the file puts them: inverse squares, cones, and rays through corners."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi import load_scene
from ddgi.errors import SceneError
from ddgi.scene.camera import camera_rays, look_at
from ddgi.trace import disney
from gltf_writing import Writer

DOWN = [-(0.5**0.5), 0, 0, 0.5**0.5]
"""A quarter turn around +x, so that -z points down."""
MATT = {"pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.5, 0.5, 0.5, 1]}}
LAMBERT = 0.5 * disney.even(1.0)
"""Its albedo with materials="diffuse"."""


def floor_and_light(light, **node):
    """A floor of 20 m by 20 m at y = 0, facing up, under a light."""
    writer = Writer()
    writer.square(MATT, scale=[20, 20, 1], rotation=DOWN, translation=[-10, 0, 10])
    writer.light(light, **node)
    return writer


def directly_lit(scene, x, z):
    """Radiance of a path-traced pixel of the floor, lamp light only. (3,)."""
    from ddgi.judge.path_tracer import PathTracer

    scene.reference = PathTracer(scene)
    camera = look_at([x, 5, z + 0.01], [x, 0, z], fov=0.01, size=(1, 1))
    return scene.reference.render_direct(camera, 64, 0).picture[0, 0]


def matt_share(scene, light_elevation_cos):
    """What the reference's BSDF sends straight up of light from that angle to the normal, without cosine."""
    bsdf = scene.reference.scene.shapes()[0].bsdf()
    si = mi.SurfaceInteraction3f()
    si.wi, si.t = mi.Vector3f(0, 0, 1), 1
    aside = float(np.sqrt(1 - light_elevation_cos**2))
    value = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(aside, 0, light_elevation_cos))
    return np.array(value).ravel() / light_elevation_cos


@pytest.mark.parametrize(("x", "height"), [(0, 2), (0, 4), (2, 2)])
def test_a_point_light_follows_the_inverse_square(tmp_path, x, height):
    """100 cd, taken as 100 W/sr: E = I cos / d^2."""
    light = {"type": "point", "name": "bulb", "intensity": 100, "color": [1, 0.5, 0]}
    scene = load_scene(floor_and_light(light, translation=[0, height, 0]).glb(tmp_path), materials="diffuse")
    assert [(found.name, found.kind) for found in scene.named_lights] == [("bulb", "point")]
    distance = np.hypot(x, height)
    irradiance = 100 * np.array([1, 0.5, 0]) * (height / distance) / distance**2
    np.testing.assert_allclose(directly_lit(scene, x, 0), LAMBERT / np.pi * irradiance, rtol=1e-3)


def test_the_sun_has_the_irradiance_of_its_lux(tmp_path):
    light = {"type": "directional", "intensity": 3}
    scene = load_scene(floor_and_light(light, rotation=DOWN, name="sun").glb(tmp_path))
    assert [(found.name, found.kind) for found in scene.named_lights] == [("sun", "directional")]
    lit = directly_lit(scene, 0, 0)
    np.testing.assert_allclose(lit, 3 * matt_share(scene, 0.9999), rtol=1e-2)


def test_the_cone_of_a_spot(tmp_path):
    """From 2 m, inner half angle atan(1/2), outer 45 degrees: full at 1 m aside, dark beyond 2 m."""
    cone = {"innerConeAngle": float(np.arctan(0.5)), "outerConeAngle": np.pi / 4}
    light = {"type": "spot", "intensity": 100, "spot": cone}
    writer = floor_and_light(light, rotation=DOWN, translation=[0, 2, 0], scale=[3, 3, 3], name="spot")
    scene = load_scene(writer.glb(tmp_path), materials="diffuse")

    def full(x):
        return LAMBERT / np.pi * 100 * 2 / np.hypot(x, 2) ** 3

    np.testing.assert_allclose(directly_lit(scene, 0, 0), full(0), rtol=1e-3)
    np.testing.assert_allclose(directly_lit(scene, 0.99, 0), full(0.99), rtol=1e-2)
    assert 0.1 * full(1.5) < directly_lit(scene, 1.5, 0)[0] < 0.9 * full(1.5)
    assert directly_lit(scene, 2.05, 0).max() == 0
    assert directly_lit(scene, 0, 2.05).max() == 0


@pytest.mark.parametrize("spot", [{"innerConeAngle": 1, "outerConeAngle": 0.5}, {"outerConeAngle": 2}])
def test_cones_that_are_none(tmp_path, spot):
    with pytest.raises(SceneError, match="its cone must have inner < outer"):
        load_scene(floor_and_light({"type": "spot", "spot": spot}, name="spot").glb(tmp_path))


def test_a_light_is_dimmed_by_its_name(tmp_path):
    scene = load_scene(
        floor_and_light({"type": "point"}, name="Lamp.001", translation=[0, 1, 0]).glb(tmp_path)
    )
    assert np.array(scene.dimmed("Lamp.001", 0.5).lights.delta.intensity)[0] == 0.5


def camera_scene(folder, camera, **node):
    writer = Writer()
    writer.square()
    writer.node(camera=writer.add("cameras", camera), name="Cam.001", **node)
    return load_scene(writer.glb(folder), sky=[1, 1, 1], camera="Cam.001")


def corner_rays(camera):
    """Origins and directions through the middles of the four outermost pixels."""
    width, height = camera.size
    pixels = mi.UInt32([0, width - 1, width * (height - 1), width * height - 1])
    origin, direction = camera_rays(camera, mi.Point3d(0), pixels, mi.Point2f(0.5))
    return np.array(origin).T, np.array(direction).T


def test_a_perspective_camera(tmp_path):
    """90 degrees high, twice as wide, at (1, 2, 3), half a turn around +y: looks along +z, right is -x."""
    lens = {"type": "perspective", "perspective": {"yfov": np.pi / 2, "aspectRatio": 2, "znear": 0.25}}
    scene = camera_scene(tmp_path, lens, translation=[1, 2, 3], rotation=[0, 1, 0, 0], scale=[7, 7, 7])
    camera = scene.camera
    assert camera.size == (720, 360)
    assert np.array(camera.near).item() == 0.25
    origin, direction = corner_rays(camera)
    slopes = direction / direction[:, 2:]
    np.testing.assert_allclose(origin - 0.25 * slopes, [[1, 2, 3]] * 4, atol=1e-5)  # rays start at znear
    edge = 1 - 1 / 360
    np.testing.assert_allclose(slopes[0], [2 * (1 - 1 / 720), edge, 1], atol=1e-4)  # top left
    np.testing.assert_allclose(slopes[3], [-2 * (1 - 1 / 720), -edge, 1], atol=1e-4)


def test_an_orthographic_camera(tmp_path):
    lens = {"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 1.5, "znear": 0, "zfar": 10}}
    scene = camera_scene(tmp_path, lens, translation=[1, 2, 3])
    camera = scene.camera
    assert camera.orthographic
    assert camera.size == (720, 360)
    origin, direction = corner_rays(camera)
    np.testing.assert_allclose(direction, [[0, 0, -1]] * 4, atol=1e-6)
    np.testing.assert_allclose(origin[0, :2], [1 - 3 * (1 - 1 / 720), 2 + 1.5 * (1 - 1 / 360)], atol=1e-4)
    np.testing.assert_allclose(origin[3, :2], [1 + 3 * (1 - 1 / 720), 2 - 1.5 * (1 - 1 / 360)], atol=1e-4)


@pytest.mark.parametrize(
    ("camera", "message"),
    [
        ({"type": "perspective"}, "not how wide"),
        ({"type": "perspective", "perspective": {"yfov": 4, "znear": 1}}, "below pi"),
        ({"type": "perspective", "perspective": {"yfov": 0, "znear": 1}}, "yfov"),
        ({"type": "orthographic", "orthographic": {"xmag": 0, "ymag": 1, "znear": 0}}, "must not be zero"),
        ({"type": "fisheye"}, r"cameras\[0\].type"),
    ],
)
def test_cameras_that_are_none(tmp_path, camera, message):
    with pytest.raises(SceneError, match=message):
        camera_scene(tmp_path, camera)


def test_what_moves_is_kept(tmp_path):
    writer = Writer()
    writer.square(name="door")
    times, turns = writer.accessor([0, 1, 3]), writer.accessor([[0, 0, 0, 1], [0, 1, 0, 0], [0, 0, 0, 1]])
    spline = writer.accessor([[k, 0, 0] for k in range(9)])
    channels = [
        {"sampler": 0, "target": {"node": 0, "path": "rotation"}},
        {"sampler": 1, "target": {"node": 0, "path": "translation"}},
    ]
    samplers = [
        {"input": times, "output": turns},
        {"input": times, "output": spline, "interpolation": "CUBICSPLINE"},
    ]
    writer.add("animations", {"name": "open", "channels": channels, "samplers": samplers})
    rig = load_scene(writer.glb(tmp_path), sky=[1, 1, 1]).rig
    assert rig.nodes[0].shapes == ("door",)
    (clip,) = rig.clips
    assert (clip.name, clip.duration) == ("open", 3)
    assert [c.path for c in clip.channels] == ["rotation", "translation"]
    assert clip.channels[0].values.tolist() == [[0, 0, 0, 1], [0, 1, 0, 0], [0, 0, 0, 1]]
    assert clip.channels[1].values.shape == (3, 3, 3)
    assert clip.channels[1].values[1, 1].tolist() == [4, 0, 0]


def test_a_picture_by_the_names_in_the_file(run, tmp_path):
    """What shares its name is numbered: a light after its camera, a mesh last."""
    writer = floor_and_light({"type": "point", "intensity": 50}, name="square", translation=[0, 3, 0])
    lens = {"type": "perspective", "perspective": {"yfov": 0.8, "aspectRatio": 2, "znear": 0.1}}
    writer.json["nodes"][1]["camera"] = writer.add("cameras", lens)
    writer.node(camera=0, name="Cam.001", translation=[0, 1, 8])
    path, picture = writer.glb(tmp_path), tmp_path / "out.png"
    options = "--frames", "1", "--size", "16x8", "--camera", "Cam.001", "--set", "grid.counts=[2,2,2]"
    code, _, err = run("render", path, "-o", picture, *options)
    assert code == 0, err
    assert picture.stat().st_size > 0
    scene = load_scene(path, camera="Cam.001")
    assert [camera.name for camera in scene.cameras] == ["Cam.001", "square"]
    assert [light.name for light in scene.named_lights] == ["square-2"]
    assert set(scene.shapes) == {"square-3"}
