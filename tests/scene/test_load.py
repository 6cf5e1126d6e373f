"""Scenes from names, files and dictionaries; and what is said of those that cannot be loaded."""

import time
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "scenes"


def load(*args, **keywords):
    from ddgi.scene.load import load_scene

    return load_scene(*args, **keywords)


def write(folder, body):
    path = folder / "room.xml"
    path.write_text(f'<scene version="3.0.0">\n{body}\n</scene>\n')
    return path


def refused(source, *parts, **keywords):
    """The one-line message, which names all of `parts`."""
    with pytest.raises(SceneError) as caught:
        load(source, **keywords)
    text = str(caught.value)
    assert "\n" not in text
    for part in parts:
        assert part in text, text
    return text


FLOOR = '<shape type="rectangle" id="floor"/>'


def test_cornell_box():
    scene = load(mi.cornell_box())
    assert set(scene.shapes) == {
        "light", "floor", "ceiling", "back", "green-wall", "red-wall", "small-box", "large-box"}  # fmt: skip
    assert scene.triangles == 36
    assert scene.up == (0, 1, 0)
    np.testing.assert_allclose(scene.bounds, [[-1, -1.01, -1], [1, 1, 1]], atol=1e-5)
    base = np.array(scene.materials.base).reshape(-1, 4)
    np.testing.assert_allclose(base[scene.shapes["red-wall"]], [0.570068, 0.0430135, 0.0443706, 1], atol=1e-6)
    assert scene.lights.area_count == 1
    assert scene.camera.size == (256, 256)
    assert scene.notes == ()


@pytest.mark.slow
def test_every_built_in_scene_loads():
    from ddgi.scene.library import BUILT_IN

    for name in BUILT_IN:
        scene = load(name, size=(32, 18))
        assert scene.name == name
        assert scene.up == (0, 1, 0)
        assert scene.camera.size == (32, 18)


def test_the_source_renders_as_the_reference(tmp_path):
    """The parsed scene that is kept can be built by Mitsuba after the file's folder is forgotten."""
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    body = (
        '<integrator type="bogus"/><shape type="obj" id="a"><string name="filename" value="a.obj"/></shape>'
    )
    scene = load(write(tmp_path, body + "<sensor type='perspective'><film type='nofilm'/></sensor>"))
    config = mi.parser.ParserConfig(mi.variant())
    built = mi.parser.instantiate(config, scene.source)
    assert len(built.shapes()) == 1
    assert built.environment() is not None  # the daylight it was given


def test_the_source_can_be_built_again():
    """Mitsuba puts what it built in the place of what was parsed: each reader gets a copy."""
    scene = load(mi.cornell_box())
    config = mi.parser.ParserConfig(mi.variant())
    first, second = (mi.parser.instantiate(config, scene.source) for _ in range(2))
    assert len(first.shapes()) == len(second.shapes()) == 8
    assert first.shapes()[0] is not second.shapes()[0]


def test_what_is_ours_cannot_stop_a_scene(tmp_path):
    body = """
    <integrator type="sppm"><float name="magic" value="3"/></integrator>
    <sensor type="perspective" id="eye">
        <sampler type="quantum"><integer name="n" value="2"/></sampler>
        <film type="holofilm"><integer name="width" value="40"/><integer name="height" value="30"/>
            <float name="depth" value="2"/><rfilter type="sinc"/></film>
    </sensor>"""
    scene = load(write(tmp_path, body + FLOOR))
    assert scene.camera.name == "eye"
    assert scene.camera.size == (40, 30)


def test_names_are_kept_and_made_unique(tmp_path):
    body = FLOOR + '<shape type="sphere"/><shape type="sphere"/>'
    scene = load(write(tmp_path, body))
    assert len(scene.shapes) == 3
    assert {s.id() for s in scene.mi_scene.shapes()} == set(scene.shapes)


def test_all_analytic_shapes():
    kinds = ("sphere", "rectangle", "disk", "cylinder", "cube")
    scene = load({"type": "scene", **{kind: {"type": kind} for kind in kinds}})
    assert set(scene.shapes) == set(kinds)


def test_up_is_the_axis_nearest_the_cameras():
    to_world = mi.ScalarTransform4f().look_at(origin=[3, 0, 1], target=[0, 0, 0], up=[0, 0.2, 1])
    room = {
        "type": "scene",
        "eye": {"type": "perspective", "to_world": to_world},
        "floor": {"type": "rectangle"},
    }
    assert load(room).up == (0, 0, 1)
    assert load(room, up="-x").up == (-1, 0, 0)
    np.testing.assert_allclose(load(room, up=(0, 3, 4)).up, (0, 0.6, 0.8))


def test_camera_by_name_or_of_ones_own():
    from ddgi.scene.camera import look_at

    assert load("house", camera="sealed").camera.name == "sealed"
    assert load("house", camera=1).camera.name == load("house").cameras[1].name
    own = look_at((0, 1, 0), (1, 1, 0), name="own")
    assert load("house", camera=own, size=(20, 10)).camera.name == "own"
    refused("house", "sealed", camera="attic")


def test_arrays_are_opaque_so_that_scenes_share_kernels():
    import drjit as dr

    scene = load(mi.cornell_box())
    for array in (
        scene.camera.near,
        scene.camera.position.x,
        scene.materials.base,
        scene.lights.delta.intensity,
    ):
        assert array.state in (dr.VarState.Evaluated, dr.VarState.Dirty)


# Bad input ------------------------------------------------------------------------------------------


def test_unknown_names_and_files(tmp_path):
    refused("nosuch", "nosuch", "cornell")
    refused("nosuch.xml", "not found")
    refused(str(tmp_path), "folder")
    (tmp_path / "a.blend").write_text("x")
    refused(tmp_path / "a.blend", ".blend")
    (tmp_path / "e.xml").write_text("")
    refused(tmp_path / "e.xml", "empty")


def test_what_is_no_source_is_named_by_its_type():
    from ddgi.scene.library import BUILT_IN
    from ddgi.scene.load import load_scene

    with pytest.raises(SceneError) as refused:
        load_scene(BUILT_IN["cornell"].build())
    assert str(refused.value) == "a scene is a name, a path or a dictionary, not a Blueprint"


def test_malformed_xml(tmp_path):
    path = tmp_path / "m.xml"
    path.write_text('<scene version="3.0.0">\n<shape type="rectangle">\n')
    refused(path, "m.xml", "line")
    path.write_text('<scene version="3.0.0">\n<shape type="rectangle"><ref id="nowhere"/></shape></scene>')
    refused(path, "nowhere", "line 2")


def test_unknown_plugins_and_properties(tmp_path):
    refused(write(tmp_path, '<shape type="teapot" id="t"/>'), "teapot", "line 2")
    text = '<shape type="sphere" id="ball"><float name="radios" value="2"/></shape>'
    notes = load(write(tmp_path, text)).notes
    assert any(all(part in note for part in ("radios", "ball", "line 2")) for note in notes)
    refused({"type": "scene", "b": {"tpe": "diffuse"}}, "type")
    refused({"type": "diffuse"}, "scene")


def test_missing_files(tmp_path):
    text = '<shape type="obj" id="chair"><string name="filename" value="models/chair.obj"/></shape>'
    refused(write(tmp_path, text), "models/chair.obj", "chair", "line 2")


def test_no_geometry(tmp_path):
    refused(write(tmp_path, ""), "no geometry")
    refused(write(tmp_path, '<shape type="sphere"><bsdf type="dielectric"/></shape>'), "no geometry")
    (tmp_path / "empty.obj").write_text("v 0 0 0\n")
    text = '<shape type="obj"><string name="filename" value="empty.obj"/></shape>'
    refused(write(tmp_path, text), "no geometry")


def test_bad_vertices_and_faces(tmp_path):
    (tmp_path / "nan.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n")
    text = '<shape type="obj" id="spoiled"><string name="filename" value="nan.obj"/></shape>'
    refused(write(tmp_path, text), "spoiled")
    header = (
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    (tmp_path / "bad.ply").write_text(header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 77\n")
    text = '<shape type="ply" id="spoiled"><string name="filename" value="bad.ply"/></shape>'
    refused(write(tmp_path, text), "spoiled", "77")
    (tmp_path / "bad.ply").write_text(header + "0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n")
    refused(write(tmp_path, text), "spoiled")


def test_a_mesh_object_with_bad_vertices():
    from ddgi.scene.mesh_keys import mesh

    corners = np.array([[0, 0, 0], [1, 0, 0], [0, np.inf, 0]])
    bad = mesh("bad", corners, np.array([[0, 1, 2]]), bsdf={"type": "diffuse"})
    refused({"type": "scene", "spoiled": bad}, "spoiled", "finite")


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_transforms_and_numbers_must_be_finite(value):
    matrix = np.eye(4)
    matrix[1, 3] = value
    shape = {"type": "sphere", "to_world": mi.ScalarTransform4f(matrix)}
    refused({"type": "scene", "ball": shape}, "ball", "to_world", "finite")
    refused({"type": "scene", "ball": {"type": "sphere", "radius": float(value)}}, "ball", "radius", "finite")


def test_triangles_without_area_are_told_of_and_not_counted(tmp_path):
    """Of four triangles one is a point, and one a line."""
    (tmp_path / "flat.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 3 4\nf 1 1 1\nf 1 2 4\n"
    )
    lamp = {"type": "point", "position": [0, 0, 3], "intensity": {"type": "rgb", "value": 1.0}}
    mesh = {"type": "obj", "filename": str(tmp_path / "flat.obj")}
    scene = load({"type": "scene", "mesh": mesh, "lamp": lamp})
    assert scene.triangles == 2
    assert any(note.startswith("2 triangle(s) without area") for note in scene.notes)


# Real scenes ----------------------------------------------------------------------------------------

REAL = {  # folder: triangles at least, area lights, sky, seconds
    "cornell-bitterli": (36, 1, False, 5),
    "veach-ajar": (4400, 1, False, 20),
    "veach-bidir": (3000, 2, False, 5),
    "staircase2": (28000, 13, False, 20),
    "classroom": (100000, 0, True, 20),
}


@pytest.mark.scenes
@pytest.mark.parametrize("name", REAL)
def test_real_scenes(name):
    path = SHARED / name / "scene_mi3.xml"
    if not path.exists():
        pytest.skip(f"shared scenes are not at {SHARED}")
    triangles, area, sky, seconds = REAL[name]
    start = time.perf_counter()
    scene = load(path)
    assert time.perf_counter() - start < seconds
    assert scene.name == name
    assert scene.triangles >= triangles
    assert scene.lights.area_count == area
    assert (scene.lights.environment is not None) is sky
    assert scene.up == (0, 1, 0)
    base = np.array(scene.materials.base).reshape(-1, 4)
    surface = np.array(scene.materials.surface).reshape(-1, 4)
    assert ((base >= 0) & (base <= 1)).all()
    assert ((surface >= 0) & (surface <= 1)).all()
    assert (surface[list(scene.shapes.values()), 3] == 1).mean() > 0.9  # these scenes say twosided throughout


@pytest.mark.scenes
@pytest.mark.parametrize("name", ["cornell-bitterli", "veach-bidir", "staircase2"])
def test_files_for_other_renderers(name):
    """The originals: integrators that Mitsuba does not know are no obstacle."""
    path = SHARED / name / "scene.xml"
    if not path.exists():
        pytest.skip(f"shared scenes are not at {SHARED}")
    assert load(path).triangles > 0


@pytest.mark.scenes
def test_a_parameter_of_an_older_renderer_is_left_out():
    path = SHARED / "classroom" / "scene.xml"
    if not path.exists():
        pytest.skip(f"shared scenes are not at {SHARED}")
    assert any("ext_eta" in note and "line 211" in note for note in load(path).notes)
