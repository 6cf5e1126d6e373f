"""Numbers out of buffers: every way the specification lets them be stored."""

import numpy as np
import pytest

from ddgi.errors import SceneError
from ddgi.scene.gltf.accessors import Accessors
from ddgi.scene.gltf.buffers import Views
from ddgi.scene.gltf.document import read_container
from gltf_writing import COMPONENTS, SQUARE, Writer, shapes_of, triangles

POINTS = np.array([[1, 2, 3], [4, 5, 6], [7, 8, 10]], "<f4")


def accessors(writer, folder):
    container = read_container(writer.glb(folder))
    return Accessors(container.document, Views(container))


def refused(writer, folder, *parts):
    with pytest.raises(SceneError) as caught:
        accessors(writer, folder).raw(0)
    for part in parts:
        assert part in str(caught.value), caught.value


@pytest.mark.parametrize("kind", COMPONENTS)
def test_component_types(tmp_path, kind):
    writer = Writer()
    writer.accessor([[1, 2], [3, 100]], kind)
    assert accessors(writer, tmp_path).raw(0).tolist() == [[1, 2], [3, 100]]


def test_normalised_integers(tmp_path):
    """Section 3.11: c / 255, c / 65535, max(c / 127, -1), max(c / 32767, -1)."""
    writer = Writer()
    for kind, values in {
        "u1": [0, 51, 255],
        "u2": [0, 13107, 65535],
        "i1": [-128, -127, 127],
        "i2": [-32768, 0, 32767],
    }.items():
        writer.accessor(values, kind, normalized=True)
    read = accessors(writer, tmp_path)
    expected = [[0, 0.2, 1], [0, 0.2, 1], [-1, -1, 1], [-1, 0, 1]]
    for index, values in enumerate(expected):
        np.testing.assert_allclose(read.floats(index, ("SCALAR",))[:, 0], values, rtol=1e-6)


def test_strides_and_offsets(tmp_path):
    """Positions in a table of 20 bytes a row, behind a row of something else."""
    table = np.full((4, 5), 99, "<f4")
    table[1:, 1:4] = POINTS
    writer = Writer()
    view = writer.view(table.tobytes(), byteStride=20)
    writer.add(
        "accessors", {"bufferView": view, "byteOffset": 24, "componentType": 5126, "count": 3, "type": "VEC3"}
    )
    assert accessors(writer, tmp_path).raw(0).tolist() == POINTS.tolist()


def test_matrices_of_bytes_have_padded_columns(tmp_path):
    writer = Writer()
    view = writer.view(bytes([1, 2, 0, 0, 3, 4, 0, 0]))
    writer.add("accessors", {"bufferView": view, "componentType": 5121, "count": 1, "type": "MAT2"})
    assert accessors(writer, tmp_path).raw(0).tolist() == [[1, 2, 3, 4]]


@pytest.mark.parametrize("based", [True, False])
def test_sparse(tmp_path, based):
    writer = Writer()
    spec = {"componentType": 5126, "count": 3, "type": "VEC3"}
    if based:
        spec["bufferView"] = writer.view(POINTS.tobytes())
    spec["sparse"] = {
        "count": 2,
        "indices": {"bufferView": writer.view(np.array([0, 2], "<u2").tobytes()), "componentType": 5123},
        "values": {"bufferView": writer.view(np.array([[9, 9, 9], [8, 8, 8]], "<f4").tobytes())},
    }
    writer.add("accessors", spec)
    middle = [4, 5, 6] if based else [0, 0, 0]
    assert accessors(writer, tmp_path).raw(0).tolist() == [[9, 9, 9], middle, [8, 8, 8]]


def test_without_a_view_it_is_zero(tmp_path):
    writer = Writer()
    writer.add("accessors", {"componentType": 5123, "count": 2, "type": "SCALAR"})
    assert accessors(writer, tmp_path).raw(0).tolist() == [[0], [0]]


def test_what_lies_outside_is_refused(tmp_path):
    writer = Writer()
    writer.accessor(POINTS, name="corners")
    writer.json["accessors"][0]["count"] = 4
    refused(writer, tmp_path, 'accessors[0] "corners"', "reaches to byte 48", "36 bytes")
    writer.json["accessors"][0].update(count=3, byteOffset=4)
    refused(writer, tmp_path, "accessors[0]", "byte 40")
    writer.json["accessors"][0]["byteOffset"] = 0
    writer.json["bufferViews"][0]["byteLength"] = 10**9
    refused(writer, tmp_path, "bufferViews[0]", "outside buffers[0]")


def test_traps_are_refused(tmp_path):
    writer = Writer()
    writer.add("accessors", {"componentType": 5126, "count": 2**40, "type": "MAT4"})
    refused(writer, tmp_path, "elements without data")
    writer = Writer()
    writer.accessor(POINTS)
    writer.json["bufferViews"][0]["byteStride"] = 4
    refused(writer, tmp_path, "overlap")


@pytest.mark.parametrize(
    ("places", "message"), [([1, 1], "must rise"), ([2, 1], "must rise"), ([1, 3], "below its count")]
)
def test_sparse_indices_must_make_sense(tmp_path, places, message):
    writer = Writer()
    writer.accessor(POINTS, sparse={
        "count": 2,
        "indices": {"bufferView": 1, "componentType": 5121},
        "values": {"bufferView": 2},
    })  # fmt: skip
    writer.view(bytes(places))
    writer.view(POINTS[:2].tobytes())
    refused(writer, tmp_path, message)


def test_values_that_are_no_numbers(tmp_path):
    writer = Writer()
    writer.accessor([[np.nan, 0, 0]])
    with pytest.raises(SceneError, match=r"accessors\[0\]: a value is not finite"):
        accessors(writer, tmp_path).floats(0, ("VEC3",))


def test_quantised_positions_stand_where_plain_ones_do(tmp_path):
    """KHR_mesh_quantization: 16 bits, undone by the node's transform."""
    plain, packed = Writer(), Writer()
    plain.square()
    values = np.round(np.array(SQUARE) * 1000).astype("<i2")
    padded = np.zeros((4, 4), "<i2")
    padded[:, :3] = values
    view = packed.view(padded.tobytes(), byteStride=8)
    position = packed.add(
        "accessors", {"bufferView": view, "componentType": 5122, "count": 4, "type": "VEC3"}
    )
    packed.node(name="square", mesh=packed.mesh(POSITION=position), scale=[1e-3] * 3)
    packed.json["extensionsRequired"] = ["KHR_mesh_quantization"]
    a = triangles(shapes_of(plain.gltf(tmp_path, "plain.gltf"))["square"])
    b = triangles(shapes_of(packed.glb(tmp_path))["square"])
    np.testing.assert_allclose(a, b, atol=1e-6)
