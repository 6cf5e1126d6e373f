"""A mesh plugin whose vertices are arrays: how geometry that is no file gets into a Mitsuba description.

In a description: {"type": "ddgi_mesh", "positions": mi.Float, "faces": mi.UInt32, ...}, flat, with
`normals`, `texcoords`, `colors` (RGB) and `alphas` if there are any, and a BSDF and an emitter as
for other shapes. Unlike a mesh that is handed over as an object it can be built afresh, with another
material if need be.
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.scene.mesh_keys import ALPHA_ATTRIBUTE, COLOR_ATTRIBUTE, make_mesh

PLUGIN = "ddgi_mesh"


def register_mesh_arrays() -> None:
    """Make the plugin known to Mitsuba's variant in use; once more does no harm."""
    mi.register_shape(PLUGIN, _build)


def described(
    positions: np.ndarray,
    faces: np.ndarray,
    *,
    normals: np.ndarray | None = None,
    texcoords: np.ndarray | None = None,
    colors: np.ndarray | None = None,
    alphas: np.ndarray | None = None,
) -> dict[str, Any]:
    """A description of the plugin, to which BSDF and emitter are added.

    Args:
        positions: (V, 3) [m].
        faces: (F, 3) counter-clockwise from the front.
        normals: (V, 3) unit vectors for smooth shading; without them faces are flat.
        texcoords: (V, 2); v = 0 at a picture's first row.
        colors: (V, 3) the mesh attribute `COLOR_ATTRIBUTE`.
        alphas: (V, 1) the mesh attribute `ALPHA_ATTRIBUTE`.
    """
    out: dict[str, Any] = {
        "type": PLUGIN,
        "faces": mi.UInt32(np.ascontiguousarray(faces, np.uint32).ravel()),
        "face_normals": normals is None,
    }
    given = {"positions": positions, "normals": normals, "texcoords": texcoords}
    for key, values in (given | {"colors": colors, "alphas": alphas}).items():
        if values is not None:
            out[key] = mi.Float(np.ascontiguousarray(values, np.float32).ravel())
    return out


def _build(properties: Any) -> mi.Mesh:
    def table(key: str, width: int) -> np.ndarray | None:
        return np.array(properties[key]).reshape(-1, width) if key in properties else None

    positions, faces = table("positions", 3), table("faces", 3)
    assert positions is not None
    assert faces is not None
    return make_mesh(
        properties.id(), positions, faces, properties, normals=table("normals", 3),
        texcoords=table("texcoords", 2),
        attributes={COLOR_ATTRIBUTE: table("colors", 3), ALPHA_ATTRIBUTE: table("alphas", 1)},
    )  # fmt: skip
