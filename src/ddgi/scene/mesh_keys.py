"""The one file that knows how Mitsuba names mesh parameters (they change in Mitsuba 3.10)."""

from __future__ import annotations

import mitsuba as mi
import numpy as np

POSITIONS, NORMALS, TEXCOORDS, FACES = "vertex_positions", "vertex_normals", "vertex_texcoords", "faces"


def mesh(
    name: str,
    positions: np.ndarray,
    faces: np.ndarray,
    *,
    bsdf: object,
    emitter: object | None = None,
    normals: np.ndarray | None = None,
    texcoords: np.ndarray | None = None,
) -> mi.Mesh:
    """Build a Mitsuba mesh from arrays.

    Args:
        name: The shape's id.
        positions: (V, 3) metres.
        faces: (F, 3) vertex numbers, counter-clockwise seen from the front.
        bsdf: A Mitsuba BSDF, or a dictionary that describes one.
        emitter: An area emitter, or a dictionary that describes one.
        normals: (V, 3) unit vectors for smooth shading; without them faces are flat.
        texcoords: (V, 2).
    """
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(bsdf) if isinstance(bsdf, dict) else bsdf
    if emitter is not None:
        props["emitter"] = mi.load_dict(emitter) if isinstance(emitter, dict) else emitter
    props["face_normals"] = normals is None
    out = mi.Mesh(
        name,
        len(positions),
        len(faces),
        has_vertex_normals=normals is not None,
        has_vertex_texcoords=texcoords is not None,
        props=props,
    )
    params = mi.traverse(out)
    arrays = {POSITIONS: positions, NORMALS: normals, TEXCOORDS: texcoords}
    for key, value in arrays.items():
        if value is not None:
            params[key] = mi.Float(np.ascontiguousarray(value, np.float32).ravel())
    params[FACES] = mi.UInt32(np.ascontiguousarray(faces, np.uint32).ravel())
    params.update()
    return out


def mesh_attribute_mean(shape: mi.Shape, name: str) -> np.ndarray | None:
    """(C,) mean of a mesh attribute such as "vertex_color"; None if the shape has none by that name."""
    parameters = mi.traverse(shape)
    if not shape.is_mesh() or name not in parameters:
        return None
    count = shape.vertex_count() if name.startswith("vertex_") else shape.face_count()
    return parameters[name].numpy().reshape(count, -1).mean(0, dtype=np.float64)
