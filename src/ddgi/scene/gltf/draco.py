"""KHR_draco_mesh_compression: the vertices and triangles of a primitive, packed by Draco."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf.buffers import Views
from ddgi.scene.gltf.extras import require
from ddgi.scene.gltf.schema import DracoPrimitive


@dataclass(frozen=True)
class Packed:
    """What came out of one Draco mesh."""

    vertices: int
    faces: np.ndarray  # (F, 3)
    attributes: dict[str, np.ndarray]  # (V, components), by the name of the attribute


def decode(extension: DracoPrimitive, views: Views, label: str) -> Packed:
    """Unpack a primitive.

    Raises:
        SceneError: The library is missing or refuses the data, or an attribute is not in it.
    """
    library = require("DracoPy", "KHR_draco_mesh_compression")
    data = bytes(views.content(extension.buffer_view))
    try:
        mesh = library.decode(data)
        vertices = len(mesh.points)
        faces = np.asarray(mesh.faces).reshape(-1, 3)
        found = {
            entry["unique_id"]: np.asarray(entry["data"]).reshape(vertices, -1) for entry in mesh.attributes
        }
    except Exception as error:  # the library raises its own kinds, and hands out parts that are missing
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise SceneError(f"{label}: its Draco data cannot be decoded: {reason}") from error
    missing = [f"{number} for {name}" for name, number in extension.attributes.items() if number not in found]
    if missing:
        raise SceneError(f"{label}: its Draco data has no attribute {missing[0]}")
    return Packed(vertices, faces, {name: found[number] for name, number in extension.attributes.items()})
