"""glTF files written by tests: a few lines that give a small valid file, and its parts to change."""

from __future__ import annotations

import base64
import copy
import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

COMPONENTS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
"""Faces +z when its corners are taken 0 1 2, 0 2 3."""
CORNERS = [0, 1, 2, 0, 2, 3]
SQUARE_UV = [[0, 1], [1, 1], [1, 0], [0, 0]]
"""A picture upright on the square: v runs down."""


class Writer:
    """Collects a document and the bytes it speaks of."""

    def __init__(self) -> None:
        self.json: dict[str, Any] = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}
        self.data = bytearray()

    def add(self, collection: str, element: dict[str, Any]) -> int:
        """Append to a list of the document; its number there."""
        self.json.setdefault(collection, []).append(element)
        return len(self.json[collection]) - 1

    def view(self, data: bytes, **more: Any) -> int:
        self.data.extend(b"\0" * (-len(self.data) % 4))
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **more}
        self.data.extend(data)
        return self.add("bufferViews", view)

    def accessor(self, values: Any, kind: str = "f4", **more: Any) -> int:
        """An accessor with a tightly packed view of its own."""
        array = np.asarray(values, "<" + kind)
        array = array.reshape(len(array), -1)
        return self.add("accessors", {
            "bufferView": self.view(array.tobytes()), "componentType": COMPONENTS[kind],
            "count": len(array), "type": TYPES[array.shape[1]], **more,
        })  # fmt: skip

    def mesh(
        self, positions: Any = SQUARE, indices: Any = CORNERS, primitive: Any = None, **attributes: int
    ) -> int:
        """A mesh of one primitive; attributes are accessors."""
        made: dict[str, Any] = {"attributes": {**attributes}}
        if "POSITION" not in attributes:
            made["attributes"]["POSITION"] = self.accessor(positions)
        if indices is not None:
            made["indices"] = self.accessor(indices, "u2")
        return self.add("meshes", {"primitives": [made | (primitive or {})]})

    def node(self, *, root: bool = True, **node: Any) -> int:
        index = self.add("nodes", node)
        if root:
            self.json["scenes"][0]["nodes"].append(index)
        return index

    def square(self, material: dict[str, Any] | None = None, uv: Any = SQUARE_UV, **node: Any) -> int:
        """A node with the unit square, of a material."""
        primitive = {} if material is None else {"material": self.add("materials", material)}
        mesh = self.mesh(primitive=primitive, TEXCOORD_0=self.accessor(uv))
        return self.node(**({"name": "square", "mesh": mesh} | node))

    def texture(self, texels: Any, **sampler: Any) -> int:
        """A texture of an embedded PNG."""
        image = self.add("images", {"bufferView": self.view(png(texels)), "mimeType": "image/png"})
        return self.add("textures", {"source": image, "sampler": self.add("samplers", sampler)})

    def use(self, *names: str) -> None:
        self.json.setdefault("extensionsUsed", []).extend(names)

    def light(self, light: dict[str, Any], **node: Any) -> None:
        lights = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})
        lights["lights"].append(light)
        number = len(lights["lights"]) - 1
        self.node(**node, extensions={"KHR_lights_punctual": {"light": number}})

    def document(self) -> dict[str, Any]:
        """The JSON with its data in a data URI."""
        document = copy.deepcopy(self.json)
        if self.data:
            uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
            document.setdefault("buffers", [{"byteLength": len(self.data), "uri": uri}])
        return document

    def gltf(self, folder: Path, name: str = "thing.gltf") -> Path:
        path = folder / name
        path.write_text(json.dumps(self.document()))
        return path

    def glb(self, folder: Path, name: str = "thing.glb") -> Path:
        document = copy.deepcopy(self.json)
        if self.data:
            document.setdefault("buffers", [{"byteLength": len(self.data)}])
        path = folder / name
        path.write_bytes(glb_bytes(json.dumps(document).encode(), bytes(self.data)))
        return path


def glb_bytes(text: bytes, data: bytes) -> bytes:
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if data:
        chunks += struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def png(texels: Any) -> bytes:
    """A PNG of (H, W, 1 to 4) bytes."""
    from PIL import Image

    array = np.asarray(texels, np.uint8)
    out = io.BytesIO()
    Image.fromarray(array[..., 0] if array.shape[-1] == 1 else array).save(out, "PNG")
    return out.getvalue()


def shapes_of(path: Path) -> dict[str, dict[str, np.ndarray]]:
    """The arrays of every mesh that a file describes, by name; and its notes, under "".

    Positions are in the file's coordinates.
    """
    from ddgi.scene.gltf.description import read_gltf
    from ddgi.scene.notes import Notes

    widths = {"positions": 3, "normals": 3, "texcoords": 2, "faces": 3, "colors": 3, "alphas": 1}
    notes = Notes()
    read = read_gltf(path, notes)
    found: dict[str, Any] = {
        part["id"]: {key: np.array(part[key]).reshape(-1, widths[key]) for key in widths if key in part}
        for part in read.description.values()
        if isinstance(part, dict) and part["type"] == "ddgi_mesh"
    }
    for shape in found.values():
        shape["positions"] = (shape["positions"] + read.origin).astype(np.float32)
    found[""] = notes.lines()
    return found


def triangles(shape: dict[str, np.ndarray]) -> np.ndarray:
    """(F, 3, 3) corner positions."""
    return shape["positions"][shape["faces"]]
