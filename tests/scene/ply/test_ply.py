"""PLY files whose answers are known on paper: triangles, quads and polygons, in words and in bytes."""

import struct

import mitsuba as mi
import numpy as np
import pytest

import ddgi
from ddgi.errors import SceneError
from ddgi.scene.notes import Notes
from ddgi.scene.ply.description import read_ply

FORMATS = ("ascii", "binary_little_endian", "binary_big_endian")
CODES = {"float": "f", "double": "d", "uchar": "B", "char": "b", "ushort": "H", "int": "i", "uint": "I"}
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
ARROW = [(2, 0, 0), (1, 0.5, 0), (2, 2, 0), (0, 2, 0), (0, 0, 0)]
"""Hollow at its second corner: a fan from the first would leave it."""


def packed(fmt, types, row):
    """The bytes or words of numbers."""
    if fmt == "ascii":
        return " ".join(map(str, row)).encode() + b" "
    order = "<" if "little" in fmt else ">"
    return b"".join(struct.pack(order + CODES[t], value) for t, value in zip(types, row, strict=True))


def ply(
    folder,
    vertices,
    faces,
    fmt="ascii",
    *,
    kind="float",
    more=(),
    values=(),
    index=("uchar", "int"),
    newline="\n",
    extra=(),
    between=b"",
):
    """A file; `more` are further properties of vertices, as (type, name), and `values` theirs; `extra` header lines."""
    header = ["ply", f"format {fmt} 1.0", "comment made by a test", f"element vertex {len(vertices)}"]
    header += [f"property {kind} {axis}" for axis in "xyz"] + [f"property {t} {name}" for t, name in more]
    header += [*extra, f"element face {len(faces)}", f"property list {index[0]} {index[1]} vertex_indices"]
    data = newline.join([*header, "end_header", ""]).encode()
    types = [kind] * 3 + [t for t, _ in more]
    for number, vertex in enumerate(vertices):
        data += packed(fmt, types, (*vertex, *(values[number] if more else ())))
    data += between
    for face in faces:
        data += packed(fmt, [index[0]] + [index[1]] * len(face), (len(face), *face))
    path = folder / "thing.ply"
    path.write_bytes(data)
    return path


def mesh(path, notes=None):
    """Positions in the file's coordinates, faces, normals and colours of its shape."""
    description, origin = read_ply(path, notes or Notes())
    shape = description["_shape-0"]

    def table(key, width):
        return np.array(shape[key]).reshape(-1, width) if key in shape else None

    return table("positions", 3) + origin, table("faces", 3), table("normals", 3), table("colors", 3)


def area(positions, faces):
    a, b, c = positions[faces].swapaxes(0, 1)
    return np.cross(b - a, c - a) / 2


@pytest.mark.parametrize("fmt", FORMATS)
@pytest.mark.parametrize(
    ("vertices", "faces", "triangles", "total"),
    [
        (SQUARE, [(0, 1, 2), (0, 2, 3)], 2, 1.0),
        (SQUARE, [(0, 1, 2, 3)], 2, 1.0),
        (ARROW, [(0, 1, 2, 3, 4)], 3, 3.0),
        ([*SQUARE, (3, 0, 0)], [(0, 1, 2, 3), (1, 4, 2)], 3, 2.0),  # of several sizes
    ],
)
def test_polygons_in_every_format(tmp_path, fmt, vertices, faces, triangles, total):
    positions, found, normals, _ = mesh(ply(tmp_path, vertices, faces, fmt))
    parts = area(positions, found)
    assert len(found) == triangles
    assert (parts[:, 2] > 0).all()  # wound as in the file, and none outside
    assert parts.sum(0) == pytest.approx([0, 0, total])
    np.testing.assert_allclose(normals, np.tile([0, 0, 1], (len(vertices), 1)), atol=1e-6)


@pytest.mark.parametrize("fmt", FORMATS)
@pytest.mark.parametrize(
    "index", [("uchar", "uint"), ("int", "int"), ("ushort", "ushort"), ("char", "uchar")]
)
def test_types_of_numbers(tmp_path, fmt, index):
    positions, faces, _, _ = mesh(ply(tmp_path, SQUARE, [(0, 1, 2, 3)], fmt, kind="double", index=index))
    assert area(positions, faces).sum(0) == pytest.approx([0, 0, 1])


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("fmt", FORMATS)
def test_line_ends(tmp_path, newline, fmt):
    positions, *_ = mesh(ply(tmp_path, SQUARE, [(0, 1, 2, 3)], fmt, newline=newline))
    np.testing.assert_array_equal(positions, SQUARE)


@pytest.mark.parametrize("fmt", FORMATS)
def test_what_else_is_in_a_file_is_passed_over(tmp_path, fmt):
    """An element between vertices and faces whose lists differ in length, and one that is empty."""
    extra = ("element strip 2", "property list uchar int members", "property float w", "element none 0")
    between = packed(fmt, ["uchar", "int", "int", "float"], (2, 7, 8, 0.5))
    between += packed(fmt, ["uchar", "float"], (0, 0.5))
    positions, faces, _, _ = mesh(ply(tmp_path, SQUARE, [(0, 1, 2)], fmt, extra=extra, between=between))
    assert len(positions) == 3  # no face uses the fourth
    assert area(positions, faces).sum(0) == pytest.approx([0, 0, 0.5])


@pytest.mark.parametrize("fmt", FORMATS)
@pytest.mark.parametrize(("kind", "white"), [("uchar", 255), ("ushort", 65535), ("float", 1.0)])
def test_colours_and_normals(tmp_path, fmt, kind, white):
    more = [("float", n) for n in ("nx", "ny", "nz")] + [(kind, c) for c in ("red", "green", "blue")]
    path = ply(tmp_path, SQUARE, [(0, 1, 2, 3)], fmt, more=more, values=[(0, 3, 4, white, 0, white)] * 4)
    _, _, normals, colors = mesh(path)
    np.testing.assert_allclose(normals, np.tile([0, 0.6, 0.8], (4, 1)), atol=1e-6)
    np.testing.assert_allclose(colors, np.tile([1, 0, 1], (4, 1)), atol=1e-6)


def test_computed_normals_are_mitsubas(tmp_path):
    """Those of a bent sheet of triangles."""
    vertices = [(0, 0, 0), (2, 0, 0), (2, 1, 0.5), (0, 1, -0.2), (1, 2, 1)]
    path = ply(tmp_path, vertices, [(0, 1, 2), (0, 2, 3), (3, 2, 4)])
    theirs = mi.traverse(mi.load_dict({"type": "ply", "filename": str(path)}))["vertex_normals"].numpy()
    _, _, normals, _ = mesh(path)
    np.testing.assert_allclose(normals, theirs.reshape(-1, 3), atol=2e-3)  # its arc cosine is a polynomial


def test_what_is_far_away_is_exact_in_doubles(tmp_path):
    far = np.array(SQUARE) * 0.01 + [4e6, 0, 1e6]
    description, origin = read_ply(ply(tmp_path, far.tolist(), [(0, 1, 2, 3)], kind="double"), Notes())
    found = np.array(description["_shape-0"]["positions"]).reshape(-1, 3) + origin
    np.testing.assert_allclose(found, far, atol=1e-8)


def test_faces_that_are_none_are_left_out_and_counted(tmp_path):
    notes = Notes()
    _, faces, _, _ = mesh(ply(tmp_path, SQUARE, [(0, 1), (0, 1, 2), (0, 1, 1), ()]), notes)
    assert len(faces) == 1
    assert notes.lines() == (
        "2 face(s) of less than three corners left out",
        "1 triangle(s) without area left out",
    )


@pytest.mark.parametrize("fmt", FORMATS)
@pytest.mark.parametrize("vertex", [-1, 4, 2**31 - 1])
def test_a_corner_that_is_no_vertex(tmp_path, fmt, vertex):
    path = ply(tmp_path, SQUARE, [(0, 1, 2, 3), (0, 1, vertex)], fmt)
    with pytest.raises(SceneError, match=rf"face 2 of 2 uses vertex {vertex}, but there are 4"):
        read_ply(path, Notes())


@pytest.mark.parametrize("fmt", FORMATS)
def test_a_list_of_less_than_nothing(tmp_path, fmt):
    path = ply(tmp_path, SQUARE, [], fmt, index=("char", "int"))
    data = path.read_bytes().replace(b"face 0", b"face 1") + packed(fmt, ["char"] * 9, [-3] * 9)
    path.write_bytes(data)
    with pytest.raises(SceneError, match="face 1 of 1 has a list of -3 members"):
        read_ply(path, Notes())


def test_whole_scene_of_quads(tmp_path):
    scene = ddgi.load_scene(ply(tmp_path, SQUARE, [(0, 1, 2, 3)]), sky=[1, 1, 1])
    assert scene.triangles == 2
    assert list(scene.shapes) == ["thing"]


# Inside Mitsuba files -----------------------------------------------------------------------------------


def inside(folder):
    path = folder / "a.xml"
    path.write_text(
        '<scene version="3.0.0">\n<shape type="ply"><string name="filename" value="thing.ply"/></shape></scene>'
    )
    return ddgi.load_scene(path, sky=[1, 1, 1])


@pytest.mark.parametrize("fmt", FORMATS)
@pytest.mark.parametrize(
    ("faces", "message"),
    [
        ([(0, 1, 2), (0, 1, 2, 3)], "face 2 of 2 has 4 corners, only triangles are read here: triangulate"),
        ([(0, 1, 2), (0, 2, -3)], "face 2 of 2 uses vertex -3, but there are 4"),
    ],
)
def test_what_mitsuba_stumbles_over_has_a_line_of_its_own(tmp_path, fmt, faces, message):
    ply(tmp_path, SQUARE, faces, fmt)
    with pytest.raises(SceneError) as caught:
        inside(tmp_path)
    text = str(caught.value)
    assert "\n" not in text
    for part in ("thing.ply", "line 2", message):
        assert part in text


def test_triangles_are_mitsubas(tmp_path):
    ply(tmp_path, SQUARE, [(0, 1, 2), (0, 2, 3)])
    assert inside(tmp_path).triangles == 2
