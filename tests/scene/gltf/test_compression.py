"""Packed files show what plain ones do."""

from pathlib import Path

import numpy as np
import pytest

from ddgi.errors import SceneError
from ddgi.scene.gltf import extras
from gltf_writing import CORNERS, SQUARE, Writer, shapes_of, triangles

SHARED = Path(__file__).resolve().parents[3].parent / "shared" / "scenes"
NORMALS = np.array([[0, 0, 1], [0, 0.6, 0.8], [0.6, 0, 0.8], [0, 0, 1]], "<f4")


def library(name):
    return pytest.importorskip(name, reason=f"{name} is not installed: pip install 'ddgi[gltf]'")


def packed_view(writer, data, count, stride, mode, length, filter_name="NONE"):
    """A view whose bytes are packed, over a fallback buffer without any."""
    start = len(writer.data) + -len(writer.data) % 4
    writer.data.extend(b"\0" * (start - len(writer.data)))
    writer.data.extend(data)
    compressed = {
        "buffer": 0, "byteOffset": start, "byteLength": len(data), "byteStride": stride, "count": count, "mode": mode,
        "filter": filter_name,
    }  # fmt: skip
    view = {"buffer": 1, "byteLength": length, "extensions": {"EXT_meshopt_compression": compressed}}
    return writer.add("bufferViews", view)


def finished(writer, folder):
    fallback = {"byteLength": 4096, "extensions": {"EXT_meshopt_compression": {"fallback": True}}}
    writer.json["buffers"] = [{"byteLength": len(writer.data)}, fallback]
    writer.json["extensionsRequired"] = ["EXT_meshopt_compression"]
    return writer.glb(folder)


def meshopt_square(library):
    writer = Writer()
    positions = np.array(SQUARE, "<f4")
    view = packed_view(writer, bytes(library.encode_vertex_buffer(positions, 4, 12)), 4, 12, "ATTRIBUTES", 48)
    position = writer.add(
        "accessors", {"bufferView": view, "componentType": 5126, "count": 4, "type": "VEC3"}
    )
    corners = np.array(CORNERS, "<u4")
    view = packed_view(writer, bytes(library.encode_index_buffer(corners, 6, 4)), 6, 4, "TRIANGLES", 24)
    index = writer.add("accessors", {"bufferView": view, "componentType": 5125, "count": 6, "type": "SCALAR"})
    writer.node(
        name="square", mesh=writer.mesh(indices=None, primitive={"indices": index}, POSITION=position)
    )
    return writer


def sorted_triangles(shape):
    """Triangles without regard to their order, or to which corner is first."""
    corners = triangles(shape)
    first = [int(np.lexsort(c.T).argmin()) for c in np.round(corners, 4)]
    turned = np.stack([np.roll(c, -int(np.lexsort(c.T)[0]), 0) for c in np.round(corners, 4)])
    assert len(first) == len(turned)
    return turned[np.lexsort(turned.reshape(len(turned), -1).T)]


def plain(folder):
    writer = Writer()
    writer.square()
    return shapes_of(writer.gltf(folder, "plain.gltf"))["square"]


def test_meshopt_equals_plain(tmp_path):
    found = shapes_of(finished(meshopt_square(library("meshoptimizer")), tmp_path))["square"]
    np.testing.assert_array_equal(sorted_triangles(found), sorted_triangles(plain(tmp_path)))


def test_meshopt_filters(tmp_path):
    """Octahedral normals in 8 bits: x and y of the unit vector on |x| + |y| + |z| = 1, 127 for one."""
    meshopt = library("meshoptimizer")
    writer = meshopt_square(meshopt)
    flat = NORMALS / np.abs(NORMALS).sum(1, keepdims=True)
    stored = np.zeros((4, 4), np.int8)
    stored[:, :2], stored[:, 2] = np.round(flat[:, :2] * 127), 127
    data = bytes(meshopt.encode_vertex_buffer(stored.view("<f4"), 4, 4))
    view = packed_view(writer, data, 4, 4, "ATTRIBUTES", 16, "OCTAHEDRAL")
    writer.json["bufferViews"][view]["byteStride"] = 4
    spec = {"bufferView": view, "componentType": 5120, "normalized": True, "count": 4, "type": "VEC3"}
    writer.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = writer.add("accessors", spec)
    found = shapes_of(finished(writer, tmp_path))["square"]
    np.testing.assert_allclose(found["normals"], NORMALS, atol=0.02)


def test_broken_meshopt_data(tmp_path):
    writer = meshopt_square(library("meshoptimizer"))
    view = writer.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]
    view["byteLength"] -= 5
    with pytest.raises(SceneError, match=r"bufferViews\[0\]: its meshopt data cannot be decoded"):
        shapes_of(finished(writer, tmp_path))
    view["byteStride"] = 10
    with pytest.raises(SceneError, match="not what EXT_meshopt_compression allows"):
        shapes_of(finished(writer, tmp_path))


def draco_square(draco):
    data = draco.encode(
        np.array(SQUARE, np.float32), np.array(CORNERS, np.uint32).reshape(-1, 3), quantization_bits=14
    )
    number = draco.decode(data).attributes[0]["unique_id"]
    writer = Writer()
    extension = {"bufferView": writer.view(data), "attributes": {"POSITION": number}}
    position = writer.add("accessors", {"componentType": 5126, "count": 4, "type": "VEC3"})
    index = writer.add("accessors", {"componentType": 5125, "count": 6, "type": "SCALAR"})
    primitive = {"indices": index, "extensions": {"KHR_draco_mesh_compression": extension}}
    writer.node(name="square", mesh=writer.mesh(indices=None, primitive=primitive, POSITION=position))
    writer.json["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    return writer


def test_draco_equals_plain(tmp_path):
    found = shapes_of(draco_square(library("DracoPy")).glb(tmp_path))["square"]
    np.testing.assert_allclose(sorted_triangles(found), sorted_triangles(plain(tmp_path)), atol=1e-3)


def draco_skinned(draco, joints):
    """The square on one joint, a metre up; JOINTS_0 and WEIGHTS_0 are attributes 7 and 9 of the Draco mesh."""
    weights = np.tile(np.float32([1, 0, 0, 0]), (4, 1))
    data = draco.encode(
        np.array(SQUARE, np.float32), np.array(CORNERS, np.uint32).reshape(-1, 3),
        generic_attributes={7: joints, 9: weights},
    )  # fmt: skip
    position = draco.decode(data).attributes[-1]["unique_id"]
    writer = Writer()
    names = {"POSITION": position, "JOINTS_0": 7, "WEIGHTS_0": 9}
    types = {"POSITION": (5126, "VEC3"), "JOINTS_0": (5121, "VEC4"), "WEIGHTS_0": (5126, "VEC4")}
    accessors = {
        name: writer.add("accessors", {"componentType": component, "count": 4, "type": kind})
        for name, (component, kind) in types.items()
    }
    primitive = {
        "extensions": {"KHR_draco_mesh_compression": {"bufferView": writer.view(data), "attributes": names}}
    }
    mesh = writer.mesh(indices=None, primitive=primitive, **accessors)
    skin = writer.add("skins", {"joints": [writer.node(translation=[0, 0, 1])]})
    writer.node(name="square", mesh=mesh, skin=skin)
    return writer


def test_draco_skins(tmp_path):
    draco = library("DracoPy")
    found = shapes_of(draco_skinned(draco, np.zeros((4, 4), np.uint16)).glb(tmp_path))["square"]
    raised = sorted_triangles(plain(tmp_path)) + np.array([0, 0, 1])
    np.testing.assert_allclose(sorted_triangles(found), raised, atol=1e-3)
    with pytest.raises(SceneError, match="no whole numbers for JOINTS_0"):
        shapes_of(draco_skinned(draco, np.zeros((4, 4), np.float32)).glb(tmp_path))


def test_broken_draco_data(tmp_path):
    writer = draco_square(library("DracoPy"))
    extension = writer.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
    extension["attributes"]["NORMAL"] = 77
    with pytest.raises(SceneError, match="no attribute 77 for NORMAL"):
        shapes_of(writer.glb(tmp_path))
    del extension["attributes"]["NORMAL"]
    texcoords = writer.add("accessors", {"componentType": 5126, "count": 4, "type": "VEC2"})
    writer.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = texcoords
    extension["attributes"]["TEXCOORD_0"] = extension["attributes"]["POSITION"]
    with pytest.raises(SceneError, match="3 numbers for TEXCOORD_0, not 2"):
        shapes_of(writer.glb(tmp_path))
    del extension["attributes"]["TEXCOORD_0"]
    writer.data[5:40] = bytes(35)
    with pytest.raises(SceneError, match="Draco data cannot be decoded"):
        shapes_of(writer.glb(tmp_path))


@pytest.mark.parametrize("module", ["DracoPy", "meshoptimizer"])
def test_a_missing_library_is_named(monkeypatch, module):
    import sys

    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(SceneError, match=rf"EXT_x needs the library {module}: pip install 'ddgi\[gltf\]'"):
        extras.require(module, "EXT_x")


@pytest.mark.scenes
def test_a_real_flat_is_the_same_packed_and_unpacked():
    """Quantised positions lie within 1e-3 of the bounds."""
    library("meshoptimizer")
    folder = SHARED / "dream-apartment"
    if not folder.is_dir():
        pytest.skip(f"shared scenes are not at {SHARED}")
    packed, unpacked = (shapes_of(folder / name) for name in ("dream-apartment.glb", "decoded.glb"))
    assert len(packed) == len(unpacked)

    def corners(found):
        return np.concatenate([triangles(shape).reshape(-1, 3) for name, shape in found.items() if name])

    a, b = corners(packed), corners(unpacked)
    assert a.shape == b.shape
    size = np.ptp(b, axis=0).max()
    for moment in (lambda c: c.min(0), lambda c: c.max(0), lambda c: c.mean(0), lambda c: c.std(0)):
        np.testing.assert_allclose(moment(a), moment(b), atol=1e-3 * size)
