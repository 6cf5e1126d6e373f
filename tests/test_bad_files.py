"""The command line and scene files that are bad, of every kind: one line that names the element, and code 1."""

import json
import os
import re

import numpy as np
import pytest

import fuzz_seeds
from ddgi import load_scene
from gltf_writing import CORNERS, SQUARE, Writer, glb_bytes, png

# glTF ---------------------------------------------------------------------------------------------------


def gltf(change=lambda writer: None, **square):
    """The unit square, changed."""
    writer = Writer()
    writer.square(**square)
    change(writer)
    return {"a.gltf": json.dumps(writer.document()).encode()}


def glb(change):
    """The bytes of the square's GLB, changed."""
    writer = Writer()
    writer.square()
    writer.json["buffers"] = [{"byteLength": len(writer.data)}]
    return {"a.glb": change(glb_bytes(json.dumps(writer.json).encode(), bytes(writer.data)))}


def accessor(number, **changes):
    return lambda writer: writer.json["accessors"][number].update(changes)


def geometry(positions=SQUARE, indices=CORNERS):
    def change(writer):
        writer.json["nodes"][0]["mesh"] = writer.mesh(positions=positions, indices=indices)

    return gltf(change)


def nodes(*nodes):
    def change(writer):
        writer.json["nodes"] += nodes
        writer.json["scenes"] = [{"nodes": [0, 1]}]

    return gltf(change)


def picture(data):
    def change(writer):
        image = writer.add("images", {"mimeType": "image/png", "bufferView": writer.view(data)})
        use(writer, writer.add("textures", {"source": image}))

    return gltf(change)


def use(writer, texture):
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}
    writer.json["meshes"][0]["primitives"][0]["material"] = writer.add("materials", material)


def missing_picture(writer):
    use(writer, writer.add("textures", {"source": writer.add("images", {"uri": "none.png"})}))


NAN, INF = float("nan"), float("inf")
BROKEN = [*SQUARE[:3], [NAN, 0, 0]], [*SQUARE[:3], [0, INF, 0]]
TURNED = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
GLTF = {
    "empty": ({"a.gltf": b""}, "the file is empty"),
    "empty binary": ({"a.glb": b""}, "the file is empty"),
    "cut short": (glb(lambda data: data[:-40]), "cut short"),
    "cut in its header": (glb(lambda data: data[:10]), "not a GLB"),
    "JSON cut short": ({"a.gltf": gltf()["a.gltf"][:200]}, "not valid JSON"),
    "not JSON": ({"a.gltf": b"<scene/>"}, "not valid JSON: Expecting value at line 1"),
    "XML": ({"a.glb": b"<scene version='3.0.0'/>"}, "not a GLB"),
    "PNG": ({"a.gltf": png(np.zeros((2, 2, 3)))}, "not a glTF file"),
    "buffer too short": (gltf(lambda w: w.json.update(buffers=[{"byteLength": 8, "uri": "data:,12345678"}])), "buffers[0]"),
    "view too long": (gltf(lambda w: w.json["bufferViews"][0].update(byteLength=10**6)), "bufferViews[0]"),
    "accessor too long": (gltf(accessor(0, count=10**6)), "accessors[0]"),
    "count beyond 64 bits": (gltf(accessor(0, count=2**63)), "accessors[0].count"),
    "count that overflows": (gltf(accessor(0, count=2**53)), "accessors[0]"),
    "count without data": (gltf(accessor(0, bufferView=None, count=2**40)), "accessors[0]"),
    "sparse count": (
        gltf(accessor(0, sparse={
            "count": 2**50, "indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0},
        })), "accessors[0]",
    ),
    "offset that overflows": (gltf(lambda w: w.json["bufferViews"][0].update(byteOffset=2**53)), "bufferViews[0]"),
    "vertex out of range": (geometry(indices=[0, 1, 9]), "accessors[4] names vertex 9, but there are 4"),
    "mesh out of range": (gltf(mesh=7), "nodes[0].mesh names number 7"),
    "node out of range": (nodes({"children": [7]}), "nodes[1].children[0] names number 7"),
    "negative number": (gltf(mesh=-1), "nodes[0].mesh"),
    "nodes in a circle": (nodes({"children": [2]}, {"children": [1]}), "nodes[1] is its own ancestor"),
    "nodes in a circle outside": (nodes({}, {"children": [3]}, {"children": [2]}), "nodes[2] is its own ancestor"),
    "its own child": (nodes({}, {"children": [2]}), "nodes[2] is its own ancestor"),
    "two parents": (nodes({"children": [2]}, {}, {"children": [2]}), "nodes[2] is a child of both nodes[1] and [3]"),
    "NaN vertex": (geometry(positions=BROKEN[0]), "accessors[3]: a value is not finite"),
    "infinite vertex": (geometry(positions=BROKEN[1]), "accessors[3]: a value is not finite"),
    "NaN matrix": (nodes({"matrix": [NAN, *TURNED[1:]]}), "nodes[1].matrix[0]"),
    "infinite matrix": (nodes({"matrix": [INF, *TURNED[1:]]}), "nodes[1].matrix[0]"),
    "projection": (nodes({"matrix": [*TURNED[:3], 1, *TURNED[4:]]}), "nodes[1]: its matrix is no placement"),
    "far away": (gltf(scale=[1e300, 1, 1]), "nodes[0]: a vertex lies too far away"),
    "further than squares can tell": (gltf(scale=[1e30, 1, 1]), "reaches beyond 1e+15 m"),
    "scales that overflow": (nodes({"scale": [1e300] * 3, "children": [2]}, {"scale": [1e300] * 3}), "nodes[2]: its place"),
    "no triangles": (gltf(lambda w: w.json.pop("nodes") and w.json.pop("scenes") and w.json.pop("scene")), "no geometry"),
    "points": (gltf(lambda w: w.json["meshes"][0]["primitives"][0].update(mode=0)), "there is no triangle, only 1 point primitive: export"),
    "two corners": (geometry(indices=[0, 1]), "no geometry"),
    "triangles without area": (geometry(positions=[[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]), "none of the 2 triangles has an area: export"),
    "missing picture": (gltf(missing_picture), "images[0]: file not found: none.png"),
    "broken picture": (picture(png(np.zeros((8, 8, 3)))[:50]), "images[0]"),
    "picture of another kind": (picture(b"GIF89a........"), "images[0] is a GIF picture"),
    "picture of nothing": (picture(bytes(64)), "images[0] is neither PNG nor JPEG"),
}  # fmt: skip

# OBJ and PLY --------------------------------------------------------------------------------------------

VERTICES = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
PICTURED = VERTICES + "mtllib a.mtl\nusemtl m\nf 1 2 3\n"


def obj(text, **beside):
    return {"a.obj": text.encode()} | {name.replace("_", "."): data for name, data in beside.items()}


OBJ = {
    "empty": (obj(""), "the file is empty"),
    "blank": (obj("\n\n"), "has no faces"),
    "binary": ({"a.obj": png(np.zeros((2, 2, 3)))}, "is not a text file"),
    "XML": (obj("<scene version='3.0.0'/>"), "has no faces"),
    "cut in a face": (obj(VERTICES + "f 1 2"), "line 4: a face of 2 corner(s)"),
    "cut in a vertex": (obj(VERTICES[:-3] + "\nf 1 2 3"), "line 3: v has 2 number(s)"),
    "vertex out of range": (obj(VERTICES + "f 1 2 9"), "line 4: a face asks for v 9 of 3"),
    "vertex zero": (obj(VERTICES + "f 0 1 2"), "line 4: a face asks for v 0 of 3"),
    "too far back": (obj(VERTICES + "f -1 -2 -9"), "line 4: a face asks for v -9 of 3"),
    "no such normal": (obj(VERTICES + "f 1//1 2//1 3//1"), "line 4: a face asks for vn 1 of 0"),
    "number that overflows": (obj(VERTICES + "f 1 2 99999999999999999999999"), "line 4"),
    "endless number": (obj(VERTICES + "f 1 2 " + "9" * 5000), "line 4"),
    "NaN vertex": (obj("v nan 0 0\n" + VERTICES + "f 2 3 4"), "line 1: v is not finite"),
    "infinite vertex": (obj("v 0 1e999 0\n" + VERTICES + "f 2 3 4"), "line 1: v is not finite"),
    "beyond single precision": (obj("v 0 1e300 0\n" + VERTICES + "f 1 2 3"), "line 1: v is not finite, or too large"),
    "words": (obj("v one two three\nf 1 1 1"), "line 1: v 'one two three' is not made of numbers"),
    "no triangles": (obj(VERTICES + "l 1 2\nl 2 3\np 1\n"), "a.obj: there is no triangle, only 2 lines and 1 point: export"),
    "cut before the faces": (obj(VERTICES), "has no faces, vertices alone: was it cut short?"),
    "triangles without area": (obj(VERTICES + "f 1 1 2\nf 2 2 2\n"), "a.obj: none of the 2 triangles has an area: export"),
    "one triangle without area": (obj("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), "its only triangle has no area"),
    "broken picture": (obj(PICTURED, a_mtl=b"newmtl m\nmap_Kd b.png\n", b_png=b"no picture"), "b.png cannot be decoded"),
    "picture cut short": (obj(PICTURED, a_mtl=b"newmtl m\nmap_Kd b.png\n", b_png=png(np.zeros((8, 8, 3)))[:50]), "b.png"),
    "broken material": (obj(PICTURED, a_mtl=b"newmtl m\nKd red\n"), "a.mtl: line 2: Kd 'red'"),
    "binary materials": (obj(PICTURED, a_mtl=bytes(40)), "a.mtl: is not a text file"),
}  # fmt: skip

TEXT, BINARY = fuzz_seeds.ply()
NO_FACES = TEXT.replace(b"face 2", b"face 0").partition(b"\n3 ")[0] + b"\n"
NAN_PLY = BINARY.replace(np.float32(1).tobytes(), np.float32(np.nan).tobytes(), 1)


def ply(old="", new="", data=TEXT):
    assert old.encode() in data
    return {"a.ply": data.replace(old.encode(), new.encode(), 1)}


PLY = {
    "empty": ({"a.ply": b""}, "the file is empty"),
    "another kind": ({"a.ply": b"solid thing\n"}, "is not a PLY file"),
    "only a header": ({"a.ply": TEXT[: TEXT.index(b"end_header")]}, "is not a PLY file"),
    "cut in its vertices": ({"a.ply": TEXT[: TEXT.index(b"end_header") + 40]}, "vertex 2 of 4: the file is cut short"),
    "binary cut short": ({"a.ply": BINARY[:-8]}, "face 2 of 2: the file is cut short"),
    "binary cut in its vertices": ({"a.ply": BINARY[: BINARY.index(b"end_header") + 30]}, "vertex 2 of 4: the file is cut short"),
    "vertex out of range": (ply("3 0 1 2\n", "3 0 1 9\n"), "face 1 of 2 uses vertex 9, but there are 4"),
    "negative vertex": (ply("3 0 1 2\n", "3 0 1 -2\n"), "face 1 of 2 uses vertex -2, but there are 4"),
    "half a vertex": (ply("3 0 1 2\n", "3 0 1 1.5\n"), "face 1 of 2 uses vertex 1.5, but there are 4"),
    "count that overflows": (ply("vertex 4", "vertex 99999999999999999999"), "whose count is none"),
    "count too large": (ply("vertex 4", "vertex 4000000000"), "the file is cut short"),
    "faces too many": (ply("face 2", "face 4000000000", BINARY), "face 3 of 4000000000: the file is cut short"),
    "NaN vertex": ({"a.ply": NAN_PLY}, "vertex 2 of 4: x, y, z not finite"),
    "NaN vertex in words": (ply("0.0 0.0 0.0", "nan 0.0 0.0"), "vertex 1 of 4: x, y, z not finite"),
    "word for a number": (ply("0.0 0.0 0.0", "zero 0.0 0.0"), "'zero' is not a number"),
    "endless number": (ply("0.0 0.0 0.0", "9" * 5000 + " 0.0 0.0"), "is not a number"),
    "infinite list": (ply("3 0 1 2\n", "inf 0 1 2\n"), "face 1 of 2 has a list of inf members"),
    "no triangles": ({"a.ply": NO_FACES}, "has no faces"),
    "triangles in one point": ({"a.ply": re.sub(rb"[01]\.0 [01]\.0 0", b"0.0 0.0 0", TEXT)}, "none of the 2 triangle(s) has an area"),
    "no vertices": (ply("vertex 4", "vertex 0"), "a.ply"),
    "unknown type": (ply("property float x", "property quaternion x"), "a property of an unknown type: 'property quaternion x'"),
    "no places": (ply("property float x", "property float w"), "its vertices have no x, y and z"),
    "one name twice": (ply("property float y", "property float x"), "two properties 'x'"),
    "unknown format": (ply("ascii", "utf8"), "its format is none of ascii"),
}  # fmt: skip

# Mitsuba XML --------------------------------------------------------------------------------------------


def xml(content, **beside):
    text = f'<scene version="3.0.0">\n{content}\n</scene>'
    return {"a.xml": text.encode()} | {name.replace("_", "."): data for name, data in beside.items()}


def mesh(kind, **beside):
    return xml(f'<shape type="{kind}"><string name="filename" value="b.{kind}"/></shape>', **beside)


TEXTURED = """<shape type="sphere"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
<string name="filename" value="b.png"/></texture></bsdf></shape>"""
PLACED = '<shape type="sphere"><transform name="to_world"><matrix value="{} 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"/></transform></shape>'
XML = {
    "empty": ({"a.xml": b""}, "the file is empty"),
    "cut short": ({"a.xml": xml(TEXTURED)["a.xml"][:80]}, "a.xml"),
    "not XML": ({"a.xml": b"{}"}, "a.xml"),
    "PNG": ({"a.xml": png(np.zeros((2, 2, 3)))}, "a.xml"),
    "another document": ({"a.xml": b"<html><body/></html>"}, "a.xml"),
    "no shapes": (xml(""), "no geometry"),
    "no such reference": (xml('<shape type="sphere"><ref id="none"/></shape>'), "none"),
    "missing mesh": (mesh("ply"), "b.ply"),
    "empty mesh": (mesh("obj", b_obj=b""), "b.obj"),
    "mesh without triangles": (mesh("ply", b_ply=NO_FACES), "no geometry"),
    "mesh cut short": (mesh("ply", b_ply=BINARY[:-8]), "line 2"),
    "vertex out of range": (mesh("ply", b_ply=ply("3 0 1 2\n", "3 0 1 9\n")["a.ply"]), "vertex 9"),
    "vertex out of range, OBJ": (mesh("obj", b_obj=(VERTICES + "f 1 2 9").encode()), "b.obj"),
    "NaN vertex": (mesh("ply", b_ply=NAN_PLY), "invalid vertex position"),
    "NaN vertex, OBJ": (mesh("obj", b_obj=(VERTICES + "v nan 0 0\nf 1 2 4").encode()), "b.obj"),
    "NaN matrix": (xml(PLACED.format("nan")), "sphere"),
    "infinite matrix": (xml(PLACED.format("inf")), "sphere"),
    "flat matrix": (xml(PLACED.format("0")), "all of it lies in one point"),
    "words for a matrix": (xml(PLACED.format("one")), "line 2"),
    "missing picture": (xml(TEXTURED), "b.png"),
    "broken picture": (xml(TEXTURED, b_png=b"no picture"), "b.png"),
    "picture cut short": (xml(TEXTURED, b_png=png(np.zeros((8, 8, 3)))[:50]), "b.png"),
    "itself included": (xml('<include filename="a.xml"/>'), "a.xml"),
}  # fmt: skip

CASES = [
    pytest.param(files, message, id=f"{kind}, {name}")
    for kind, cases in (("glTF", GLTF), ("OBJ", OBJ), ("PLY", PLY), ("XML", XML))
    for name, (files, message) in cases.items()
]


QUICK = ("--size", "32x18", "--frames", "1")


@pytest.mark.parametrize(("files", "message"), CASES)
def test_one_line_that_names_the_element(refused, tmp_path, files, message):
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    text = refused("render", next(iter(files)), "-o", "picture.png", *QUICK)
    assert message in text
    assert any(name in text for name in files)
    assert len(text) < 400
    assert not re.search(r"Traceback|unexpected|\.cpp:|\.py", text)


@pytest.mark.parametrize("name", ["a.gltf", "a.glb", "a.obj", "a.ply", "a.xml"])
def test_what_may_not_be_read(refused, monkeypatch, tmp_path, name):
    """Whoever runs the tests may be allowed everything."""
    (tmp_path / name).write_text("{}")
    monkeypatch.setattr(os, "access", lambda path, mode: not str(path).endswith(name))
    text = refused("render", name, "-o", "picture.png", *QUICK)
    assert text.endswith(f" {name}: cannot be read: permission denied")


@pytest.mark.parametrize("name", ["a.gltf", "a.glb", "a.obj", "a.ply", "a.xml"])
def test_folders_and_files_that_are_not_there(refused, tmp_path, name):
    (tmp_path / name).mkdir()
    assert f"{name} is a folder" in refused("render", name, "-o", "picture.png", *QUICK)
    assert f"none/{name}: file not found" in refused("render", f"none/{name}", "-o", "picture.png", *QUICK)


def test_deep_chains_load(tmp_path):
    """Of nodes, thousands one below the other, each a millimetre on."""
    writer = Writer()
    first = writer.square(translation=[0, 0, 0])
    count = 5000
    for number in range(first, first + count):
        writer.json["nodes"][number]["children"] = [number + 1]
        writer.node(root=False, translation=[0.001, 0, 0])
    writer.json["nodes"][-1]["mesh"] = 0
    scene = load_scene(writer.gltf(tmp_path), sky=[1, 1, 1])
    assert scene.triangles == 4
    np.testing.assert_allclose(scene.mi_scene.bbox().max.x, 1 + 0.001 * count, rtol=1e-5)


@pytest.mark.parametrize("kind", ["gltf", "obj"])
def test_triangles_without_area_are_dropped_and_counted(tmp_path, kind):
    """Two good ones beside one of a point, one of a line and one of two corners."""
    flat = [*CORNERS, 0, 0, 0, 0, 1, 1, 2, 2, 1]
    files = geometry(indices=flat) if kind == "gltf" else obj(
        "".join(f"v {x} {y} {z}\n" for x, y, z in SQUARE)
        + "".join("f {} {} {}\n".format(*(1 + c for c in flat[k : k + 3])) for k in range(0, len(flat), 3))
    )  # fmt: skip
    name, data = next(iter(files.items()))
    (tmp_path / name).write_bytes(data)
    scene = load_scene(tmp_path / name, sky=[1, 1, 1])
    assert scene.triangles == 2
    assert "3 triangle(s) without area left out" in scene.notes
