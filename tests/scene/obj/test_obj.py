"""OBJ and PLY files whose answers are known on paper."""

from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

import ddgi
from ddgi.errors import SceneError
from ddgi.scene.notes import Notes
from ddgi.scene.obj.description import read_obj
from ddgi.scene.obj.geometry import read_pieces
from ddgi.scene.obj.polygons import triangulated
from ddgi.scene.obj.statements import read_statements

SHARED = Path(__file__).resolve().parents[3].parent / "shared" / "scenes"
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


@pytest.fixture(autouse=True)
def _backend():
    ddgi.use_backend()


def written(tmp_path, text, name="thing.obj"):
    path = tmp_path / name
    path.write_text(text)
    return path


def pieces(tmp_path, text, notes=None):
    path = written(tmp_path, text)
    return read_pieces(path, read_statements(path), notes or Notes())


def area(positions, faces):
    a, b, c = (positions[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a).sum(0) / 2


def materials(tmp_path, mtl, obj=SQUARE + "mtllib a.mtl\nusemtl m\nf 1 2 3 4\n", notes=None):
    """BSDF, and the shape, of a square with a material."""
    written(tmp_path, mtl, "a.mtl")
    plugins, _ = read_obj(written(tmp_path, obj), notes or Notes())
    return plugins["_material-0"], next(p for k, p in plugins.items() if k.startswith("_shape"))


# Geometry -----------------------------------------------------------------------------------------------


def test_a_square_is_two_triangles_of_four_vertices(tmp_path):
    (piece,) = pieces(tmp_path, SQUARE + "f 1 2 3 4\n")
    assert len(piece.positions) == 4
    assert len(piece.faces) == 2
    assert np.allclose(area(piece.positions, piece.faces), [0, 0, 1])


def test_negative_numbers_count_from_what_was_read_before_the_face(tmp_path):
    (piece,) = pieces(tmp_path, SQUARE + "f -4 -3 -2\nv 9 9 9\n")
    assert piece.positions.max() == 1


def test_continued_lines_and_comments(tmp_path):
    (piece,) = pieces(tmp_path, SQUARE + "f 1 2 \\\n3 4 # a square\n")
    assert len(piece.faces) == 2


@pytest.mark.parametrize("turned", [1, -1])
@pytest.mark.parametrize("start", range(6))
def test_a_concave_polygon_keeps_its_area_and_nothing_overlaps(start, turned):
    letter_l = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 3, 0], [0, 3, 0]], float)
    corners = np.roll(letter_l[::turned], start, 0)
    cut = triangulated(corners[None])[0]
    each = [area(corners, face[None])[2] for face in cut]
    assert np.isclose(sum(each), 4 * turned)
    assert np.isclose(np.abs(each).sum(), 4)  # none is turned around


def spiral(count, rounds=5):
    """(count, 3) corners of a band wound up."""
    angle = np.linspace(0.5, 1, count // 2) * 2 * np.pi * rounds
    way = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], 1)
    return np.concatenate([way * angle[:, None], (way * (angle - 2)[:, None])[::-1]])


def comb(count):
    """(count, 3) corners of a comb with long thin teeth."""
    x = np.arange(count - 2.0)
    teeth = np.stack([x, np.where(x % 2, 1000, 1), 0 * x], 1)
    return np.concatenate([teeth[::-1], [[0, -1, 0], [len(x) - 1.0, -1, 0]]])


@pytest.mark.timeout(60)  # a cubic search takes half an hour
@pytest.mark.parametrize("make", [spiral, comb])
@pytest.mark.parametrize("turned", [1, -1])
def test_a_polygon_of_many_corners_is_cut_in_seconds(make, turned):
    corners = make(10_000)[::turned]
    cut = triangulated(corners[None])[0]
    assert cut.shape == (9_998, 3)
    each = [area(corners, face[None])[2] for face in cut]
    x, y = corners[:, :2].T
    whole = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2  # the shoelace formula
    assert np.isclose(sum(each), whole)
    assert np.isclose(np.abs(each).sum(), abs(whole))  # none is turned around


@pytest.mark.parametrize("start", range(10))
def test_a_hole_that_is_joined_on_stays_a_hole(start):
    hole = [[1, 1, 0], [1, 3, 0], [3, 3, 0], [3, 1, 0], [1, 1, 0]]
    outside = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [0, 0, 0]]
    corners = np.roll(np.array(outside + hole, float), start, 0)
    each = [area(corners, face[None])[2] for face in triangulated(corners[None])[0]]
    assert np.isclose(sum(each), 12)
    assert np.isclose(np.abs(each).sum(), 12)


@pytest.mark.timeout(60)
def test_a_polygon_that_crosses_itself_is_cut_somehow():
    places = np.random.default_rng(0).random((2_000, 2))
    cut = triangulated(np.pad(places, ((0, 0), (0, 1)))[None])[0]
    assert cut.shape == (1_998, 3)
    assert len(np.unique(cut)) == 2_000


def test_groups_and_materials_make_shapes(tmp_path):
    text = (
        SQUARE + "o left\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\no right\nf 1 2 4\no left\nusemtl a\nf 2 3 4\n"
    )
    made = pieces(tmp_path, text)
    assert [(p.name, p.material, len(p.faces)) for p in made] == [
        ("left", "a", 2), ("left", "b", 1), ("right", "b", 1),
    ]  # fmt: skip


def test_corners_with_other_texture_coordinates_are_other_vertices(tmp_path):
    text = SQUARE + "vt 0 0\nvt 1 1\nvn 0 0 2\nf 1/1/1 2/1/1 3/1/1\nf 1/2/1 3/1/1 4/1/1\n"
    (piece,) = pieces(tmp_path, text)
    assert len(piece.positions) == 5
    assert np.allclose(piece.normals, [0, 0, 1])


def test_faces_without_normals_stay_flat_beside_smooth_ones(tmp_path):
    made = pieces(tmp_path, SQUARE + "vn 0 0 1\nf 1//1 2//1 3//1\nf 1 3 4\n")
    assert [p.normals is None for p in made] == [False, True]


def test_triangles_without_area_are_left_out_and_counted(tmp_path):
    notes = Notes()
    (piece,) = pieces(tmp_path, SQUARE + "f 1 2 3\nf 1 1 2\n", notes)
    assert len(piece.faces) == 1
    assert "1 triangle(s) without area left out" in notes.lines()


def test_colours_of_vertices(tmp_path):
    text = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n"
    (piece,) = pieces(tmp_path, text)
    assert np.array_equal(piece.colors, np.eye(3))
    assert ddgi.load_scene(tmp_path / "thing.obj").materials.vertex_colors is not None


@pytest.mark.parametrize(
    ("text", "line", "what"),
    [
        ("v 0 0\nf 1 1 1\n", 1, "2 number"),
        ("v 0 0 0\nv 0 zero 0\nf 1 1 1\n", 2, "not made of numbers"),
        ("v 0 0 nan\nf 1 1 1\n", 1, "not finite"),
        (SQUARE + "f 1 2\n", 5, "2 corner"),
        (SQUARE + "f 1 2 5\n", 5, "v 5 of 4"),
        (SQUARE + "f 1 2 0\n", 5, "v 0 of 4"),
        (SQUARE + "f -5 1 2\n", 5, "v -5 of 4"),
        (SQUARE + "f 1/1 2/1 3/1\n", 5, "vt 1 of 0"),
        (SQUARE + "f 1 2 x\n", 5, "'x'"),
    ],
)
def test_a_mistake_is_one_line_with_its_number(tmp_path, text, line, what):
    with pytest.raises(SceneError) as error:
        read_obj(written(tmp_path, text), Notes())
    message = str(error.value)
    assert "\n" not in message
    assert f"thing.obj: line {line}:" in message
    assert what in message


def test_no_faces_is_an_error(tmp_path):
    with pytest.raises(SceneError, match="no faces"):
        read_obj(written(tmp_path, SQUARE), Notes())


# Materials ----------------------------------------------------------------------------------------------


def test_diffuse_and_emission(tmp_path):
    bsdf, shape = materials(tmp_path, "newmtl m\nKd 0.1 0.2 0.3\nKe 4 5 6\n")
    assert bsdf["type"] == "twosided"
    assert bsdf["nested"]["reflectance"]["value"] == [0.1, 0.2, 0.3]
    assert shape["emitter"]["radiance"]["value"] == [4, 5, 6]


def test_opacity(tmp_path):
    for text in ("d 0.25", "Tr 0.75", "Tr 1\nd 0.25"):
        bsdf, _ = materials(tmp_path, f"newmtl m\nKd 1 1 1\n{text}\n")
        assert bsdf["type"] == "mask"
        assert bsdf["opacity"]["value"] == 0.25


def test_glass_and_gloss_and_mirror(tmp_path):
    glass, _ = materials(tmp_path, "newmtl m\nillum 7\nTf 0.9 0.8 0.7\nNi 1.3\n")
    assert (glass["type"], glass["int_ior"]) == ("dielectric", 1.3)
    gloss, _ = materials(tmp_path, "newmtl m\nKd 0.5 0.5 0.5\nKs 1 1 1\nNs 198\nillum 2\n")
    assert gloss["nested"]["type"] == "roughplastic"
    assert gloss["nested"]["alpha"] == pytest.approx(0.1)  # sqrt(2 / 200)
    mirror, _ = materials(tmp_path, "newmtl m\nKd 0 0 0\nKs 1 1 1\nillum 5\n")
    assert mirror["nested"]["type"] == "roughconductor"
    nearly, _ = materials(tmp_path, "newmtl m\nKd 0.01 0.01 0.01\nKs 0.95 0.95 0.95\nillum 5\n")
    assert nearly["nested"]["type"] == "roughconductor"
    tiles, _ = materials(tmp_path, "newmtl m\nKd 0.3 0.3 0.3\nKs 0.9 0.9 0.9\nillum 5\n")
    assert tiles["nested"]["type"] == "roughplastic"


def test_what_is_not_read_of_a_material_is_told_once_with_its_line(tmp_path):
    notes = Notes()
    materials(tmp_path, "newmtl m\nKd 1 1 1\nPr 0.5\nPr 0.6\n", notes=notes)
    assert [note for note in notes.lines() if "not read" in note] == [
        "a.mtl: line 3: lines that start with 'Pr' are not read"
    ]


def test_a_picture_upside_down_as_the_format_has_it(tmp_path):
    (tmp_path / "Maps").mkdir()
    texels = np.zeros((2, 2, 3), np.uint8)
    texels[0, 0] = 255, 0, 0  # above left: u = 0.25, v = 0.75 in the file
    mi.Bitmap(texels).write(str(tmp_path / "Maps" / "A b.png"))
    obj = SQUARE + "mtllib A.MTL\nusemtl m\nvt 0.25 0.75\nf 1/1 2/1 3/1\n"
    bsdf, shape = materials(tmp_path, "newmtl m\nmap_Kd -s 1 1 1 maps\\a B.png\n", obj)
    texture = mi.load_dict(bsdf["nested"]["reflectance"])
    si = mi.SurfaceInteraction3f()
    si.uv = mi.Point2f(np.array(shape["texcoords"])[:2])
    assert np.allclose(np.array(texture.eval(si)).ravel(), [1, 0, 0], atol=1e-3)


def test_scale_and_offset_are_of_the_files_upward_v(tmp_path):
    mi.Bitmap(np.zeros((2, 2, 3), np.uint8)).write(str(tmp_path / "a.png"))
    bsdf, _ = materials(tmp_path, "newmtl m\nmap_Kd -s 2 3 -o 0.1 0.2 a.png\n")
    u, v = 0.3, 0.4
    matrix = np.array(bsdf["nested"]["reflectance"]["to_uv"].matrix).reshape(3, 3)
    assert np.allclose(matrix @ [u, 1 - v, 1], [2 * u + 0.1, 1 - (3 * v + 0.2), 1])


def test_missing_files_are_notes(tmp_path):
    notes = Notes()
    bsdf, _ = materials(tmp_path, "newmtl m\nmap_Kd none.png\n", notes=notes)
    assert bsdf["nested"]["reflectance"]["value"] == [0.5] * 3
    assert notes.lines() == ("picture not found: none.png",)
    notes = Notes()
    read_obj(written(tmp_path, "mtllib none.mtl\nusemtl x\n" + SQUARE + "f 1 2 3\n"), notes)
    assert notes.lines() == ("material file not found: none.mtl", "no material 'x': grey instead")


@pytest.mark.parametrize("name", ["../a.png", "/etc/a.png", "C:\\a.png", "b/../../a.png"])
def test_files_outside_the_folder_are_refused(tmp_path, name):
    with pytest.raises(SceneError, match=r"a\.mtl: line 2: map_Kd: .* leads out of the scene's folder"):
        materials(tmp_path, f"newmtl m\nmap_Kd {name}\n")


def test_a_mistake_in_a_material_names_its_line(tmp_path):
    with pytest.raises(SceneError, match=r"a\.mtl: line 2: Kd 'red' is not made of numbers"):
        materials(tmp_path, "newmtl m\nKd red\n")


# Whole scenes -------------------------------------------------------------------------------------------


def test_an_obj_without_lamps_gets_daylight(tmp_path):
    scene = ddgi.load_scene(written(tmp_path, SQUARE + "f 1 2 3 4\n"))
    assert (scene.triangles, scene.up) == (2, (0, 1, 0))
    assert any(note.startswith("no light in the scene: a clear sky") for note in scene.notes)


PLY = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
{properties}element face 1
property list uchar int vertex_indices
end_header
0 0 0{color}
1 0 0{color}
0 1 0{color}
3 0 1 2
"""


def test_ply(tmp_path):
    scene = ddgi.load_scene(written(tmp_path, PLY.format(properties="", color=""), "a.ply"))
    assert scene.triangles == 1
    assert scene.materials.vertex_colors is None
    names = "".join(f"property uchar {c}\n" for c in ("red", "green", "blue"))
    path = written(tmp_path, PLY.format(properties=names, color=" 255 0 51"), "b.ply")
    colors = ddgi.load_scene(path).materials.vertex_colors
    assert np.allclose(colors.values.numpy().reshape(-1, 4)[0], [1, 0, 0.2, 1])


def test_what_is_no_ply_is_refused(tmp_path):
    with pytest.raises(SceneError, match="is not a PLY file"):
        ddgi.load_scene(written(tmp_path, "solid", "a.ply"))


@pytest.mark.scenes
@pytest.mark.parametrize(
    ("name", "triangles", "lamps"),
    [
        ("cornell-mcguire/CornellBox-Original", 36, 1),
        ("cornell-mcguire/CornellBox-Sphere", 1100, 1),
        ("lumen-ddgi/occluded", 3948, 0),
    ],
)
def test_files_made_by_others(name, triangles, lamps):
    if not SHARED.is_dir():
        pytest.skip(f"shared scenes are not at {SHARED}")
    scene = ddgi.load_scene(SHARED / f"{name}.obj")
    assert scene.triangles == triangles
    assert sum(light.kind == "area" for light in scene.named_lights) == lamps
