"""EXT_mesh_gpu_instancing: one mesh in many places."""

from __future__ import annotations

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf.accessors import Accessors
from ddgi.scene.gltf.schema import Instancing
from ddgi.scene.matrices import compose


def placements(extension: Instancing, accessors: Accessors, label: str) -> np.ndarray:
    """(N, 4, 4) from the mesh's space to the node's, one per instance.

    Raises:
        SceneError: The attributes differ in length, or a rotation is zero.
    """
    names = [name for name in ("TRANSLATION", "ROTATION", "SCALE") if name in extension.attributes]
    if not names:
        return np.eye(4)[None]
    count = accessors.spec(extension.attributes[names[0]]).count

    def read(name: str, kind: str, rest: list[float]) -> np.ndarray:
        if name not in names:
            return np.tile(np.array(rest), (count, 1))
        return accessors.floats(extension.attributes[name], (kind,), count).astype(np.float64)

    rotation = read("ROTATION", "VEC4", [0, 0, 0, 1])
    if not (np.linalg.norm(rotation, axis=1) > 0).all():
        raise SceneError(f"{label}: the rotation of an instance is zero, which is no quaternion")
    return compose(read("TRANSLATION", "VEC3", [0, 0, 0]), rotation, read("SCALE", "VEC3", [1, 1, 1]))
