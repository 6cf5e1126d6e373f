"""Make the five encodings of one asset that lie beside this file: see README.md.

    python make.py PATH/TO/gltf-transform

gltf-transform: `npm install @gltf-transform/cli@4.5.1`, then node_modules/.bin/gltf-transform.
"""

from __future__ import annotations

import copy
import subprocess
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[2]))  # tests/, where gltf_writing.py is

from gltf_writing import Writer  # noqa: E402

STEPS = 8
"""Squares along each side of the sheet."""
PACKED = {"quantized": "quantize", "draco": "draco", "meshopt": "meshopt"}
"""Encodings and the commands of gltf-transform that make them."""


def sheet() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A bent sheet, alike in no two directions: positions, normals, texture coordinates, triangles."""
    u, v = (c.ravel() for c in np.meshgrid(*[np.linspace(0, 1, STEPS + 1)] * 2))
    height = 0.3 * np.sin(3 * u) + 0.2 * u * v
    along_u = np.stack([np.ones_like(u), 0.9 * np.cos(3 * u) + 0.2 * v, np.zeros_like(u)], 1)
    along_v = np.stack([np.zeros_like(u), 0.2 * u, -np.ones_like(u)], 1)
    normals = np.cross(along_u, along_v)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    corner = np.arange((STEPS + 1) ** 2).reshape(STEPS + 1, -1)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    faces = np.stack([a, b, c, a, c, d], -1).reshape(-1, 3)
    return np.stack([u, height, -v], 1), normals, np.stack([u, v], 1), faces


def asset() -> Writer:
    """The asset in plain floats."""
    writer = Writer()
    writer.json["asset"]["generator"] = "ddgi tests"
    positions, normals, texcoords, faces = sheet()
    bounds = {"min": positions.min(0).tolist(), "max": positions.max(0).tolist()}
    attributes = {
        "POSITION": writer.accessor(positions, **bounds),
        "NORMAL": writer.accessor(normals),
        "TEXCOORD_0": writer.accessor(texcoords),
    }
    row, column = np.indices((8, 8))
    texels = np.stack([255 * ((row + column) % 2), np.full_like(row, 140), 30 * row], -1)
    picture = writer.texture(texels, magFilter=9728, minFilter=9728, wrapS=33071, wrapT=33071)
    textured = {"baseColorTexture": {"index": picture}, "metallicFactor": 0, "roughnessFactor": 0.8}
    plain = {"baseColorFactor": [0.9, 0.35, 0.1, 1], "metallicFactor": 0, "roughnessFactor": 0.5}
    indices = writer.accessor(faces.reshape(-1, 1), "u2")
    meshes = []
    for pbr in (textured, plain):
        material = writer.add("materials", {"pbrMetallicRoughness": pbr, "doubleSided": True})
        primitive = {"indices": indices, "material": material}
        meshes.append(writer.mesh(indices=None, primitive=primitive, **attributes))
    turned = np.eye(4)
    turned[:3] = [[0, -1.2, 0, -0.3], [1, 0, 0, 0.2], [0, 0, 0.8, 0.4]]  # scaled, a quarter turn, moved
    writer.node(name="floor", mesh=meshes[0], scale=[3, 0.5, 3], translation=[-1.5, -0.6, 1.5])
    parent = writer.node(name="parent", rotation=[0, np.sin(0.2), 0, np.cos(0.2)])
    children = [
        writer.node(
            root=False, name="mirrored", mesh=meshes[1], scale=[-1, 1.5, 1], translation=[1.2, 0.1, 0.2]
        ),
        writer.node(root=False, name="turned", mesh=meshes[0], matrix=turned.T.ravel().tolist()),
    ]
    writer.json["nodes"][parent]["children"] = children
    writer.use("KHR_lights_punctual")
    writer.light(
        {"type": "point", "intensity": 6.0, "color": [1, 0.9, 0.8]}, name="bulb", translation=[0.4, 1.4, 0.9]
    )
    lens = {"yfov": 0.8, "znear": 0.05, "aspectRatio": 16 / 9}
    camera = writer.add("cameras", {"type": "perspective", "perspective": lens})
    writer.node(
        name="view", camera=camera, translation=[0, 0.9, 3.2], rotation=[-np.sin(0.1), 0, 0, np.cos(0.1)]
    )
    return writer


def sparse(plain: Writer) -> Writer:
    """The same numbers: sparse values replace rubbish, and zeros in texture coordinates, which have no view."""
    writer = copy.deepcopy(plain)
    positions, normals, texcoords = writer.json["accessors"][:3]
    for accessor in (positions, normals, texcoords):
        view = writer.json["bufferViews"][accessor["bufferView"]]
        part = slice(view["byteOffset"], view["byteOffset"] + view["byteLength"])
        rows = np.frombuffer(writer.data[part], "<f4").reshape(accessor["count"], -1)
        if accessor is texcoords:
            places = np.flatnonzero(rows.any(1))
            del accessor["bufferView"]
        else:
            places = np.arange(0, len(rows), 3)
            spoiled = rows.copy()
            spoiled[places] = 77
            writer.data[part] = spoiled.tobytes()
        accessor["sparse"] = {
            "count": len(places),
            "indices": {"bufferView": writer.view(places.astype("<u1").tobytes()), "componentType": 5121},
            "values": {"bufferView": writer.view(rows[places].tobytes())},
        }
    return writer


def main() -> None:
    """Write all five."""
    plain = asset()
    plain.glb(HERE, "plain.glb")
    sparse(plain).glb(HERE, "sparse.glb")
    for name, command in PACKED.items():
        subprocess.run([sys.argv[1], command, HERE / "plain.glb", HERE / f"{name}.glb"], check=True)


if __name__ == "__main__":
    main()
