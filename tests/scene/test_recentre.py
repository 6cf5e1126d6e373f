"""Scenes far from the origin: the same as at the origin, in whatever file they come, and nobody has to know."""

import mitsuba as mi
import numpy as np
import pytest

import ddgi
from ddgi.cli.request import SceneRequest
from ddgi.errors import SettingsError
from ddgi.judge.metrics import difference
from ddgi.judge.path_tracer import PathTracer
from ddgi.probes.field import IrradianceField
from ddgi.scene.camera import camera_rays, look_at
from ddgi.scene.recentre import origin_for
from ddgi.survey.report import survey
from gltf_writing import Writer
from probing import diffuse, load, rgb, small

FAR = np.array([12000.3, -8000.7, 5000.1])
"""Single precision is up to 5e-4 off there."""
NEAR = np.zeros(3)
EXACT = 1e-6
"""Single precision of coordinates up to 3 about the scene's own origin."""
SIZE = (64, 48)
SAME = 1e-3
"""Mean FLIP: rays that just miss an edge may hit it."""
FLOOR = np.array([[-1.0, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]])
LAMP, EYE, TARGET = np.array([0.25, 1, 0.5]), np.array([0.3, 0.9, 2.4]), np.array([0.0, 0.4, 0.0])


def column(values, width):
    return np.array(values, np.float64).reshape(-1, width)[:, :3]


def seen_from(offset, scale=1.0):
    return look_at(offset + scale * EYE, offset + scale * TARGET, fov=60, size=SIZE)


# ---- where to count from --------------------------------------------------------------------------------


@pytest.mark.parametrize("middle", [(0, 0, 0), (5, 0, 0), (0, -9.9, 5)])
def test_scenes_that_are_near_count_from_zero(middle):
    assert not origin_for(np.array(middle) - 5, np.array(middle) + 5).any()


@pytest.mark.parametrize("size", [1e-3, 0.7, 1.0, 30.0, 8000.0])
@pytest.mark.parametrize("away", [1.5, 40.0, 1e5])
def test_origins_are_in_the_middle_of_scenes_and_exact_in_single_precision(size, away):
    middle = size * away * np.array([1.0, -0.123, 0.77])
    origin = origin_for(middle - size / 2, middle + size / 2)
    assert (np.abs(origin - middle) < size / 8).all()
    assert (np.float32(origin) == origin).all()


def test_what_is_nowhere_or_endless_counts_from_zero():
    assert not origin_for([np.inf] * 3, [-np.inf] * 3).any()
    assert not origin_for([0, 0, 0], [0, 0, 0]).any()
    assert not origin_for([-1e308] * 3, [1.7e308] * 3).any()


def test_a_point_far_away_is_far_away():
    """Single precision makes one of what is small and far."""
    assert np.abs(origin_for(FAR, FAR) - FAR).max() < 1e-3


# ---- places, by importer ---------------------------------------------------------------------------------


def gltf(folder, offset):
    """A floor, a lamp and a camera, below nodes that add up to `offset`."""
    writer = Writer()
    writer.node(name="floor", mesh=writer.mesh(FLOOR), root=False)
    writer.light({"type": "point", "intensity": 3.0}, name="lamp", translation=LAMP.tolist(), root=False)
    lens = {"type": "perspective", "perspective": {"yfov": 1.0, "aspectRatio": 4 / 3, "znear": 0.01}}
    writer.node(name="eye", camera=writer.add("cameras", lens), translation=EYE.tolist(), root=False)
    writer.node(name="box", mesh=writer.mesh(FLOOR * 0.2 + [0, 0.4, 0]), root=False)
    half = (offset / 2).tolist()
    writer.node(name="inner", children=[0, 1, 2, 3], translation=half, root=False)
    writer.node(name="outer", children=[4], translation=half)
    return writer.gltf(folder)


def obj(folder, offset, scale=1.0):
    """A floor and a shelf in text."""
    corners = offset + scale * np.concatenate([FLOOR, FLOOR * 0.2 + [0, 0.4, 0]])
    path = folder / "floor.obj"
    path.write_text(
        "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in corners.tolist()) + "f 1 2 3 4\nf 5 6 7 8\n"
    )
    return path


def ply(folder, offset):
    """A floor; `offset` is rounded to single precision."""
    names = "".join(f"property float {axis}\n" for axis in "xyz")
    header = f"ply\nformat ascii 1.0\nelement vertex 4\n{names}element face 2\n"
    corners = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in (FLOOR + offset).tolist())
    path = folder / "floor.ply"
    path.write_text(
        f"{header}property list uchar int vertex_indices\nend_header\n{corners}3 0 1 2\n3 0 2 3\n"
    )
    return path


def plugin(kind, offset, folder):
    """A plugin that has a place, and half the sides of its box about `offset`."""
    x, y, z = offset.tolist()
    there = mi.ScalarTransform4d().translate([x, y, z])
    quarter = mi.ScalarTransform4d().rotate([0, 0, 1], 90)
    ball = {"type": "ref", "id": "group"}
    return {
        "sphere": ({"type": "sphere", "center": [x, y, z], "radius": 0.5}, (0.5, 0.5, 0.5)),
        "turned sphere": ({"type": "sphere", "center": [y, -x, z], "to_world": quarter}, (1, 1, 1)),
        "cylinder": ({"type": "cylinder", "p0": [x - 1, y, z], "p1": [x + 1, y, z]}, (1, 1, 1)),
        "turned cylinder": (
            {"type": "cylinder", "p0": [y - 1, -x, z], "p1": [y + 1, -x, z], "radius": 0.5, "to_world": quarter},
            (0.5, 1, 0.5),
        ),
        "cube": ({"type": "cube", "to_world": there @ quarter}, (1, 1, 1)),
        "disk": ({"type": "disk", "to_world": there}, (1, 1, 0)),
        "rectangle": ({"type": "rectangle", "to_world": there}, (1, 1, 0)),
        "ply": ({"type": "ply", "filename": str(ply(folder, NEAR)), "to_world": there}, (1, 0, 1)),
        "merge": ({"type": "merge", "inner": {"type": "cube", "to_world": there}}, (1, 1, 1)),
        "instance": ({"type": "instance", "to_world": there, "ball": ball}, (1, 1, 1)),
    }[kind]  # fmt: skip


@pytest.mark.parametrize(
    "kind",
    ["sphere", "turned sphere", "cylinder", "turned cylinder", "cube", "disk", "rectangle", "ply", "merge", "instance"],
)  # fmt: skip
def test_every_kind_of_shape_is_where_it_was(kind, tmp_path):
    description, half = plugin(kind, FAR, tmp_path)
    group = {"type": "shapegroup", "ball": {"type": "sphere"}}
    scene = load({"type": "scene", "group": group, "thing": description})
    check_place(scene, FAR - half, FAR + half)
    theirs = mi.parser.instantiate(mi.parser.ParserConfig(mi.variant()), scene.source).bbox()
    for side in ("min", "max"):
        ours = getattr(scene.mi_scene.bbox(), side)
        np.testing.assert_allclose(np.ravel(getattr(theirs, side)), np.ravel(ours), rtol=0, atol=EXACT)


def check_place(scene, low, high):
    """The corners in the file's coordinates; what is traced lies about the origin."""
    np.testing.assert_allclose(scene.bounds, [low, high], rtol=0, atol=EXACT)
    traced = [np.ravel(corner) for corner in (scene.mi_scene.bbox().min, scene.mi_scene.bbox().max)]
    assert np.abs(traced).max() < 3
    assert any(note.startswith("far from the origin: computed around") for note in scene.notes)


def check_things(scene):
    """A lamp and a camera where they are in the file."""
    lamp = column(scene.lights.delta.position, 4)[0] + scene.origin
    np.testing.assert_allclose(lamp, FAR + LAMP, rtol=0, atol=EXACT)
    np.testing.assert_allclose(np.ravel(scene.camera.position), FAR + EYE, rtol=0, atol=EXACT)
    eye = np.ravel(scene.camera.eye(scene.tracer.origin))
    np.testing.assert_allclose(eye + np.array(scene.origin), FAR + EYE, rtol=0, atol=EXACT)


def test_a_gltf_file_with_its_nodes(tmp_path):
    scene = load(gltf(tmp_path, FAR))
    check_place(scene, FAR - [1, 0, 1], FAR + np.array([1, 0.4, 1]))
    check_things(scene)
    outer = next(node for node in scene.rig.nodes if node.name == "outer")
    assert np.array_equal(outer.local[:3, 3], FAR / 2), "the rig is in the file's coordinates"


def test_a_gltf_file_of_instances(tmp_path):
    writer = Writer()
    places = writer.accessor([[-1, 0, 0], [1, 0, 0]])
    instancing = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}}
    writer.node(mesh=writer.mesh(FLOOR), extensions=instancing, translation=FAR.tolist())
    writer.use("EXT_mesh_gpu_instancing")
    check_place(load(writer.gltf(tmp_path)), FAR - [2, 0, 1], FAR + np.array([2, 0, 1]))


def test_a_skinned_gltf_file_that_its_joint_takes_away(tmp_path):
    writer = Writer()
    writer.node(name="joint", translation=FAR.tolist())
    skin = writer.add("skins", {"joints": [0]})
    weights = writer.accessor(np.tile([1.0, 0, 0, 0], (4, 1)))
    joints = writer.accessor(np.zeros((4, 4)), "u1")
    writer.node(mesh=writer.mesh(FLOOR, JOINTS_0=joints, WEIGHTS_0=weights), skin=skin)
    check_place(load(writer.gltf(tmp_path)), FAR - [1, 0, 1], FAR + np.array([1, 0, 1]))


def test_an_obj_file(tmp_path):
    check_place(load(obj(tmp_path, FAR)), FAR - [1, 0, 1], FAR + np.array([1, 0.4, 1]))


def test_an_obj_file_smaller_than_single_precision_there(tmp_path):
    scene = load(obj(tmp_path, FAR, scale=1e-4))
    np.testing.assert_allclose(
        scene.bounds, [FAR - [1e-4, 0, 1e-4], FAR + np.array([1e-4, 4e-5, 1e-4])], atol=1e-10, rtol=0
    )


def test_a_ply_file(tmp_path):
    """Words are exact, whatever type its header says."""
    low, high = (FAR + side * np.array([1, 0, 1]) for side in (-1, 1))
    check_place(load(ply(tmp_path, FAR)), low, high)


def test_a_mitsuba_file(tmp_path):
    x, y, z = FAR.tolist()
    eye, target = (",".join(map(repr, (FAR + p).tolist())) for p in (EYE, TARGET))
    lamp = " ".join(f'{axis}="{value!r}"' for axis, value in zip("xyz", (FAR + LAMP).tolist(), strict=True))
    path = tmp_path / "scene.xml"
    path.write_text(
        '<scene version="3.0.0">'
        f'<sensor type="perspective"><transform name="to_world"><lookat origin="{eye}" target="{target}" up="0,1,0"/></transform></sensor>'
        f'<emitter type="point"><point name="position" {lamp}/></emitter>'
        f'<shape type="cube"><transform name="to_world"><translate x="{x!r}" y="{y!r}" z="{z!r}"/></transform></shape>'
        "</scene>"
    )
    scene = load(path)
    check_place(scene, FAR - 1, FAR + 1)
    check_things(scene)
    assert not any("times" in note for note in scene.notes), "nothing is said twice"


# ---- what the user says ----------------------------------------------------------------------------------


def test_lights_cameras_and_boxes_of_the_user_are_in_the_files_coordinates(tmp_path):
    lamp = {"type": "point", "position": (FAR + LAMP).tolist(), "intensity": rgb(1)}
    scene = load(obj(tmp_path, FAR), lights=[lamp], camera=seen_from(FAR))
    check_things(scene)
    box = tuple((FAR - 1).tolist()), tuple((FAR + 1).tolist())
    grid = IrradianceField.fit(scene, small(grid_box=box, grid_margin=0.0)).volumes[0].grid
    np.testing.assert_allclose(np.ravel(grid.origin) + scene.origin, FAR - 1, rtol=0, atol=EXACT)
    with pytest.raises(
        SettingsError, match=r"grid.box, \(0, 0, 0\) to \(1, 1, 1\), .*outside the scene, \(11999\.3, "
    ):
        IrradianceField.fit(scene, small(grid_box=((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))))


def test_options_of_the_command_line_are_in_the_files_coordinates(tmp_path):
    there = lambda p: tuple((FAR + p).tolist())  # noqa: E731
    request = SceneRequest(
        look=(*there(EYE), *there(TARGET)),
        point=((*there(LAMP), 1.0, 1.0, 1.0),),
        spot=((*there(LAMP), *there(TARGET), 1.0, 1.0, 1.0, 40.0),),
    )
    scene = request.open(str(obj(tmp_path, FAR)))
    check_things(scene)
    spot = column(scene.lights.delta.position, 4)[1] + scene.origin
    np.testing.assert_allclose(spot, FAR + LAMP, rtol=0, atol=EXACT)
    aim = (TARGET - LAMP) / np.linalg.norm(TARGET - LAMP)
    np.testing.assert_allclose(column(scene.lights.delta.direction, 4)[1], aim, atol=1e-5)


def test_a_survey_speaks_the_files_coordinates(tmp_path):
    box = tuple((FAR - 1).tolist()), tuple((FAR + 1).tolist())
    found = survey(load(gltf(tmp_path, FAR), size=SIZE), small(grid_box=box, grid_margin=0.0))
    np.testing.assert_allclose(found.volume.box, box, rtol=0, atol=EXACT)
    np.testing.assert_allclose(found.lights[0].position, FAR + LAMP, rtol=0, atol=EXACT)
    assert not found.lights[0].outside
    assert found.cameras[0].outside == 0


def test_cameras_half_a_millimetre_apart_have_references_of_their_own(tmp_path):
    scene = load(obj(tmp_path, FAR))
    one, other = seen_from(FAR), seen_from(FAR + np.array([5e-4, 0, 0]))
    assert one.fingerprint(scene.origin) != other.fingerprint(scene.origin)
    assert not one.same_view(other)


def test_what_comes_as_an_object_stays_and_is_told_of(tmp_path):
    sphere = mi.load_dict({"type": "sphere", "center": FAR.tolist(), "bsdf": diffuse(0.5)})
    scene = load({"type": "scene", "thing": sphere})
    assert scene.origin == (0, 0, 0)
    assert any("came as objects" in note for note in scene.notes)
    np.testing.assert_allclose(scene.bounds, [FAR - 1, FAR + 1], atol=1e-3)


def test_scenes_near_the_origin_are_left_alone(tmp_path):
    scene = load(obj(tmp_path, np.array([1.5, 0, 0])))
    assert scene.origin == (0, 0, 0)
    assert not any("far from the origin" in note for note in scene.notes)


# ---- pictures --------------------------------------------------------------------------------------------


def picture(scene, offset, scale=1.0):
    """The probes stand in a given box: a fitted one depends on what single rays hit."""
    low, high = (tuple((offset + scale * np.array(c)).tolist()) for c in ((-0.9, 0.1, -0.9), (0.9, 0.9, 0.9)))
    settings, frame = small(grid_counts=(4, 3, 4), grid_box=(low, high), grid_margin=0.0), None
    field = IrradianceField.fit(scene, settings)
    for tick in range(4):
        field, frame = ddgi.render_frame(scene, field, scene.camera, tick, settings, frame)
    return frame.numpy()


def lit_dictionary(offset, scale=1.0):
    """A floor, a ball that stands on it and a lamp a hundredth of its size above them, under a sun."""
    place = mi.ScalarTransform4d().translate(offset.tolist()).scale(scale)
    flat = mi.ScalarTransform4d().rotate([1, 0, 0], -90)
    down = mi.ScalarTransform4d().translate([0, 0.61, 0]).rotate([1, 0, 0], 90).scale([0.3, 0.3, 1])
    lid = mi.ScalarTransform4d().translate([0, 0.62, 0]).rotate([1, 0, 0], 90).scale([0.5, 0.5, 1])
    ball = {"type": "sphere", "center": [0, 0.3, 0], "radius": 0.3, "to_world": place}
    point = (offset + scale * LAMP).tolist()
    return {
        "type": "scene",
        "floor": {"type": "rectangle", "to_world": place @ flat, "bsdf": diffuse(0.6, two_sided=True)},
        "ball": {**ball, "bsdf": diffuse(0.7)},
        "lid": {"type": "rectangle", "to_world": place @ lid, "bsdf": diffuse(0.8, two_sided=True)},
        "area": {
            "type": "rectangle", "to_world": place @ down, "bsdf": diffuse(0.5),
            "emitter": {"type": "area", "radiance": rgb(2.0)},
        },
        "point": {"type": "point", "position": point, "intensity": rgb(0.5 * scale**2)},
        "sun": {"type": "directional", "direction": [0.3, -1.0, -0.6], "irradiance": rgb(1.0)},
    }  # fmt: skip


def dictionary_scene(folder, offset):
    return load(lit_dictionary(offset), camera=seen_from(offset))


def gltf_scene(folder, offset):
    return load(gltf(folder, offset), size=SIZE)


def obj_scene(folder, offset):
    lamp = {"type": "point", "position": (offset + LAMP).tolist(), "intensity": rgb(3)}
    return load(obj(folder, offset), camera=seen_from(offset), lights=[lamp])


@pytest.mark.slow
@pytest.mark.parametrize("write", [gltf_scene, obj_scene, dictionary_scene])
def test_pictures_of_far_scenes_are_those_of_near_ones(write, tmp_path):
    near, far = (picture(write(tmp_path, offset), offset) for offset in (NEAR, FAR))
    assert near.mean() > 0.02
    assert difference(far, near).flip_mean < SAME


@pytest.mark.slow
@pytest.mark.parametrize(("scale", "offset"), [(1e3, NEAR), (1e3, 1e3 * FAR), (1e-3, FAR)])
def test_pictures_are_the_same_in_every_unit(scale, offset):
    """Lights are scaled along, so that radiance stays."""
    metres = picture(load(lit_dictionary(NEAR), camera=seen_from(NEAR)), NEAR)
    others = picture(load(lit_dictionary(offset, scale), camera=seen_from(offset, scale)), offset, scale)
    assert difference(others, metres).flip_mean < SAME


def test_references_of_far_scenes_are_those_of_near_ones():
    near, far = (load(lit_dictionary(o), camera=seen_from(o)) for o in (NEAR, FAR))
    a, b = (PathTracer(scene).render(scene.camera, 16, 0).picture for scene in (near, far))
    assert difference(b, a).flip_mean < SAME


def test_a_camera_made_by_hand_sees_a_far_scene():
    """The functions that take a camera take it in the file's coordinates, wherever it comes from."""
    scene = load(lit_dictionary(FAR), camera=seen_from(FAR))
    own, ours = (
        camera_rays(camera, scene.tracer.origin, mi.UInt32([0, 99]), mi.Point2f(0.5))
        for camera in (scene.camera, seen_from(FAR))
    )
    assert np.array_equal(np.array(own), np.array(ours))
    np.testing.assert_allclose(np.array(ours[0])[:, 0] + scene.origin, FAR + EYE, rtol=0, atol=EXACT)
