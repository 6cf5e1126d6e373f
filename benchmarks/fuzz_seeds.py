"""Small valid files that the fuzzer damages: glTF with a little of everything, OBJ with MTL, PLY."""

from __future__ import annotations

import json
import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np

TESTS = Path(__file__).parents[1] / "tests"
sys.path.insert(0, str(TESTS))

from gltf_writing import CORNERS, SQUARE, SQUARE_UV, Writer, png  # noqa: E402

Document = tuple[dict[str, Any], bytes]
"""JSON, and the bytes of its first buffer."""

OBJ = b"""# a house
mtllib house.mtl
v 0 0 0 1 0.5 0.5
v 1 0 0 0.5 1 0.5
v 1 1 0 0.5 0.5 1
v 0 1 0 1 1 1
v 0.5 1.5 0 1 1 1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 1
o house
g walls
usemtl wall
f 1/1/1 2/2/1 3/3/1 4/4/1
usemtl roof
s off
f -2/4 -1/3 -3/3
f 1 3 2 4 5
l 1 2
g lamp
usemtl lamp
f 1//1 2//1 \\
 3//1
"""
MTL = b"""newmtl wall
Kd 0.8 0.7 0.6
Ks 0.1 0.1 0.1
Ns 50
map_Kd -s 2 2 1 -o 0.5 0 0 wall.png
newmtl roof
Kd 0.5 0.1 0.1
d 0.5
map_d wall.png
illum 2
newmtl lamp
Ke 5 5 4
Kd 0 0 0
illum 7
Ni 1.5
Tf 1 1 1
"""
PICTURE = png(np.arange(48).reshape(4, 4, 3) * 5)


def documents() -> list[Document]:
    """GlTF files taken apart."""
    files = sorted((TESTS / "scene" / "gltf" / "encodings").glob("*.glb"))
    return [_rich(), _still_richer(), *(taken_apart(file.read_bytes()) for file in files)]


def ply() -> tuple[bytes, bytes]:
    """The same two triangles as text and as binary."""
    head = (
        "ply\nformat {} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = [(*map(float, corner), 255, 128, 10 * n) for n, corner in enumerate(SQUARE)]
    faces = [CORNERS[:3], CORNERS[3:]]
    text = "".join(" ".join(map(str, row)) + "\n" for row in rows)
    text += "".join("3 " + " ".join(map(str, face)) + "\n" for face in faces)
    data = b"".join(struct.pack("<3f3B", *row) for row in rows)
    data += b"".join(struct.pack("<B3i", 3, *face) for face in faces)
    return (head.format("ascii") + text).encode(), head.format("binary_little_endian").encode() + data


def taken_apart(data: bytes) -> Document:
    """The two chunks of a GLB."""
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def _finished(writer: Writer) -> Document:
    writer.json["buffers"] = [{"byteLength": len(writer.data)}]
    return writer.json, bytes(writer.data)


def _rich() -> Document:
    """Materials, lights, cameras, and ways to say where triangles are."""
    writer = Writer()
    texture = writer.texture(np.full((2, 2, 4), 128), wrapS=33071, wrapT=33648, magFilter=9728)
    use = {
        "index": texture, "texCoord": 0,
        "extensions": {"KHR_texture_transform": {"offset": [0.5, 0], "rotation": 0.3, "scale": [2, 2]}},
    }  # fmt: skip
    pbr = {
        "baseColorFactor": [1, 0.5, 0.5, 0.7], "baseColorTexture": use, "metallicFactor": 0.5,
        "metallicRoughnessTexture": {"index": texture}, "roughnessFactor": 0.4,
    }  # fmt: skip
    writer.square({
        "name": "all", "pbrMetallicRoughness": pbr, "alphaMode": "BLEND", "emissiveFactor": [1, 0, 0.5],
        "normalTexture": {"index": texture, "scale": 0.5}, "emissiveTexture": {"index": texture, "texCoord": 1},
        "occlusionTexture": {"index": texture}, "doubleSided": True,
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 4}, "KHR_materials_ior": {"ior": 1.4},
            "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [1, 1, 0.5]},
        },
    }, rotation=[0, 1, 0, 0], extensions={"KHR_node_visibility": {"visible": True}})  # fmt: skip
    glass = {
        "KHR_materials_transmission": {"transmissionFactor": 0.9, "transmissionTexture": {"index": texture}},
        "KHR_materials_volume": {"thicknessFactor": 0.1},
    }
    writer.square({"alphaMode": "MASK", "alphaCutoff": 0.4, "extensions": glass}, scale=[1, -1, 1])
    writer.square({"extensions": {"KHR_materials_unlit": {}}}, uv=np.array(SQUARE_UV)[::-1])
    old = {"diffuseFactor": [0.5, 0.5, 0.5, 1], "specularFactor": [0.1, 0.1, 0.1], "glossinessFactor": 0.5}
    writer.square({"extensions": {"KHR_materials_pbrSpecularGlossiness": old}})
    for kind in ("point", "directional"):
        writer.light({"type": kind, "intensity": 3, "color": [1, 1, 0.5]}, translation=[0, 1, 0])
    writer.light({"type": "spot", "range": 5, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}})
    lens = {"yfov": 1, "znear": 1, "aspectRatio": 1.5}
    writer.node(camera=writer.add("cameras", {"type": "perspective", "perspective": lens}), name="eye")
    lens = {"xmag": 1, "ymag": 2, "znear": 0.1, "zfar": 10}
    writer.node(camera=writer.add("cameras", {"type": "orthographic", "orthographic": lens}))
    writer.use("KHR_texture_transform", "KHR_materials_unlit")
    writer.json["extensionsRequired"] = ["KHR_texture_transform"]
    return _finished(writer)


def _still_richer() -> Document:
    """Strips, fans, points, instances, sparse accessors, colours, skins, morphs, animations."""
    writer = Writer()
    colors = writer.accessor(np.arange(16) * 15, "u1", normalized=True)
    writer.json["accessors"][colors].update(count=4, type="VEC4")
    position = writer.accessor(SQUARE, min=[0, 0, 0], max=[1, 1, 0])
    rows = np.column_stack([SQUARE, np.tile([0, 0, 1], (4, 1))]).astype("<f4")
    view = writer.view(rows.tobytes(), byteStride=24, target=34962)
    shared = {"bufferView": view, "componentType": 5126, "count": 4, "type": "VEC3"}
    strided = {
        "POSITION": writer.add("accessors", dict(shared)),
        "NORMAL": writer.add("accessors", shared | {"byteOffset": 12}),
        "COLOR_0": colors,
    }
    for mode, mesh in enumerate((5, 6, 0), 1):
        writer.node(
            mesh=writer.mesh(indices=[0, 1, 3, 2], primitive={"mode": mesh}, **strided),
            translation=[mode, 0, 0],
        )
    moved = writer.accessor([[0, 0, 0], [2, 0, 0], [4, 0, 0]])
    turned = writer.accessor([[0, 0, 0, 1], [0, 127, 0, 0], [0, 0, 127, 0]], "i1", normalized=True)
    instancing = {"TRANSLATION": moved, "ROTATION": turned, "SCALE": writer.accessor(np.ones((3, 3)))}
    writer.node(
        mesh=writer.mesh(POSITION=position),
        extensions={"EXT_mesh_gpu_instancing": {"attributes": instancing}},
    )
    sparse = {
        "count": 2,
        "indices": {"bufferView": writer.view(np.array([1, 3], "<u2").tobytes()), "componentType": 5123},
        "values": {"bufferView": writer.view(np.ones((2, 3), "<f4").tobytes())},
    }
    target = writer.add("accessors", {"componentType": 5126, "count": 4, "type": "VEC3", "sparse": sparse})
    skinned = {
        "POSITION": position, "NORMAL": strided["NORMAL"], "TEXCOORD_1": writer.accessor(SQUARE_UV),
        "JOINTS_0": writer.accessor([[0, 1, 0, 0]] * 4, "u1"), "WEIGHTS_0": writer.accessor([[0.5, 0.5, 0, 0]] * 4),
    }  # fmt: skip
    bent = writer.mesh(primitive={"targets": [{"POSITION": target}, {"NORMAL": target}]}, **skinned)
    writer.json["meshes"][bent]["weights"] = [0.5, 0.25]
    inverse = writer.accessor(np.tile(np.eye(4).ravel(), (2, 1)))
    hand = writer.node(root=False, name="hand", translation=[0, 1, 0])
    arm = writer.node(name="arm", children=[hand])
    skin = writer.add("skins", {"joints": [arm, hand], "inverseBindMatrices": inverse, "skeleton": arm})
    writer.node(mesh=bent, skin=skin, name="skinned")
    writer.node(mesh=bent, matrix=np.eye(4).ravel().tolist(), weights=[1, 0])
    times = writer.accessor([0, 0.5, 1], min=[0], max=[1])
    samplers = [
        {"input": times, "output": moved},
        {"input": times, "output": writer.accessor(np.zeros(18)), "interpolation": "CUBICSPLINE"},
        {"input": times, "output": turned, "interpolation": "STEP"},
    ]
    channels = [
        {"sampler": 0, "target": {"node": hand, "path": "translation"}},
        {"sampler": 1, "target": {"node": arm + 1, "path": "weights"}},
        {"sampler": 2, "target": {"node": arm, "path": "rotation"}},
    ]
    writer.add("animations", {"name": "wave", "samplers": samplers, "channels": channels})
    quantized = writer.accessor(np.array(SQUARE) * 32767, "i2", normalized=True, byteOffset=0)
    writer.node(mesh=writer.mesh(POSITION=quantized))
    return _finished(writer)
