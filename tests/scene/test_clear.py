"""Materials and shapes made clear: rays and the path tracer pass them, by whatever name they are asked for."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError
from ddgi.judge.path_tracer import PathTracer
from ddgi.scene.fingerprint import fingerprint
from gltf_writing import Writer
from probing import diffuse, load, rgb


def sheet(z, **more):
    """Across the z axis, 2 wide."""
    return {"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0, 0, z]), **more}


def panes(**more):
    """A wall, with two sheets of one material and one of another in front of it."""
    return {
        "type": "scene",
        "Glass": diffuse(0.3, two_sided=True),
        "wall": sheet(0, bsdf=diffuse(0.5)),
        "near": sheet(1, bsdf={"type": "ref", "id": "Glass"}),
        "next": sheet(2, bsdf={"type": "ref", "id": "Glass"}),
        "last": sheet(3, paint=diffuse(0.5)),
        **more,
    }


def seen_at(scene):
    """Where a ray from the front ends [z]."""
    ray = mi.Ray3f(mi.Point3f(0.1, 0.2, 10), mi.Vector3f(0, 0, -1))
    return 10 - float(scene.mi_scene.ray_intersect(ray).t[0])


@pytest.mark.parametrize(
    ("names", "z"),
    [((), 3), (["Glass"], 3), (["last"], 2), (["LAST", "glass"], 0), (["paint", "next"], 1), (("Last", "near"), 2)],
)  # fmt: skip
def test_materials_and_shapes_by_name(names, z):
    assert seen_at(load(panes(), clear=names)) == pytest.approx(z, abs=1e-5)


def test_a_note_says_what_is_gone():
    scene = load(panes(), clear=["glass"])
    (note,) = (note for note in scene.notes if "clear shape" in note)
    assert note.startswith("2 clear shapes")
    assert '"near"' in note
    assert "near" not in scene.shapes


def test_the_path_tracer_has_the_same():
    """A sun through clear panes is a sun without them; and the wall shines as on paper."""
    sun = {"type": "directional", "direction": [0, 0, -1], "irradiance": rgb(2.0)}
    eye = {
        "type": "perspective",
        "fov": 20,
        "to_world": mi.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]),
        "film": {"type": "hdrfilm", "width": 8, "height": 8},
    }
    scene = load(panes(sun=sun, eye=eye), clear=["glass", "last"])
    picture = PathTracer(scene).render(scene.camera, 16, 0).picture
    np.testing.assert_allclose(picture, 0.5 * 2.0 / np.pi, rtol=1e-4)
    assert fingerprint(scene) != fingerprint(load(panes(sun=sun, eye=eye)))


def test_diffuse_materials_too():
    scene = load(panes(), clear=["glass", "last"], materials="diffuse")
    assert seen_at(scene) == pytest.approx(0, abs=1e-5)


def test_lamps_stay():
    lamp = {"type": "area", "radiance": rgb(1.0)}
    scene = load(panes(lamp=sheet(4, bsdf=diffuse(0.5), emitter=lamp)), clear=["lamp", "last"])
    assert seen_at(scene) == pytest.approx(4, abs=1e-5)
    assert any('"lamp": a lamp, which cannot be clear' in note for note in scene.notes)


@pytest.mark.parametrize("name", ["members", "Glass"])
@pytest.mark.parametrize("kind", ["merge", "shapegroup"])
def test_collections(kind, name):
    glass = {"type": "ref", "id": "Glass"}
    members = {"type": kind, "a": sheet(5, bsdf=glass), "b": sheet(6, bsdf=glass)}
    more = {"members": members}
    if kind == "shapegroup":
        more["shown"] = {"type": "instance", "group": {"type": "ref", "id": "members"}}
    assert seen_at(load(panes(**more))) == pytest.approx(6, abs=1e-5)
    scene = load(panes(**more), clear=[name])
    assert seen_at(scene) == pytest.approx(3, abs=1e-5)
    PathTracer(scene)


def test_gltf_names(tmp_path):
    """Two materials of one name, and one without any, on squares one behind the other."""
    writer = Writer()
    for z, material in enumerate(({"name": "wall"}, {"name": "Pane"}, {"name": "Pane"}, {})):
        writer.square(material | {"doubleSided": True}, translation=[-0.5, -0.5, z], name=f"square-{z}")
    path = writer.glb(tmp_path)
    for names, z in (([], 3), (["pane"], 3), (["pane", "material-3"], 0), (["square-3"], 2)):
        assert seen_at(load(path, clear=names, sky=[1, 1, 1])) == pytest.approx(z, abs=1e-5)


def test_obj_names(tmp_path):
    path = tmp_path / "a.obj"
    corners = "".join(f"v {x} {y} {z}\n" for z in (0, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
    path.write_text(f"{corners}g wall\nf 1 2 3 4\ng pane\nf 5 6 7 8\n")
    assert seen_at(load(path, clear=["Pane"], sky=[1, 1, 1])) == pytest.approx(0, abs=1e-5)


def test_mitsuba_names(tmp_path):
    """An id around a material without one, an id inside, and the name of a mesh file."""
    (tmp_path / "Pane7.obj").write_text("v -1 -1 3\nv 1 -1 3\nv 0 2 3\nf 1 2 3\n")
    move = '<transform name="to_world"><translate z="{}"/></transform>'
    path = tmp_path / "a.xml"
    path.write_text(f"""<scene version="3.0.0"><shape type="rectangle"/>
<shape type="rectangle">{move.format(1)}<bsdf type="twosided" id="outer"><bsdf type="diffuse"/></bsdf></shape>
<shape type="rectangle">{move.format(2)}<bsdf type="twosided"><bsdf type="diffuse" id="inner"/></bsdf></shape>
<shape type="obj"><string name="filename" value="Pane7.obj"/></shape></scene>""")
    for names, z in (([], 3), (["pane7"], 2), (["pane7", "inner"], 1), (["pane7", "inner", "outer"], 0)):
        assert seen_at(load(path, clear=names, sky=[1, 1, 1])) == pytest.approx(z, abs=1e-5)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["glas"], "no material or shape 'glas'; the nearest are Glass"),
        (["glass", "wrong"], "no material or shape 'wrong'"),
        (["a"], "the nearest are wall, Glass, near"),
        ([7], "no material or shape 7"),
        ("glass", "clear must be a list of names, not 'glass'"),
    ],
)
def test_names_that_fit_nothing(names, message):
    with pytest.raises(SceneError) as caught:
        load(panes(), clear=names)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
