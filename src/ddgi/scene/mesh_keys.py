"""The one file that knows how Mitsuba names mesh parameters (they change in Mitsuba 3.10)."""

from __future__ import annotations

from collections.abc import Mapping

import mitsuba as mi
import numpy as np

POSITIONS, NORMALS, TEXCOORDS, FACES = "vertex_positions", "vertex_normals", "vertex_texcoords", "faces"
COLOR_ATTRIBUTE, ALPHA_ATTRIBUTE = "vertex_color", "vertex_alpha"
"""Mesh attributes that hold colour and opacity of vertices."""


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
    return make_mesh(name, positions, faces, props, normals=normals, texcoords=texcoords)


def make_mesh(
    name: str,
    positions: np.ndarray,
    faces: np.ndarray,
    props: mi.Properties,
    *,
    normals: np.ndarray | None = None,
    texcoords: np.ndarray | None = None,
    attributes: Mapping[str, np.ndarray | None] | None = None,
) -> mi.Mesh:
    """Build a Mitsuba mesh from arrays, with BSDF, emitter and `face_normals` in `props`.

    Args:
        name: The shape's id.
        positions: (V, 3) metres.
        faces: (F, 3) vertex numbers, counter-clockwise seen from the front.
        props: The shape's properties.
        normals: (V, 3) unit vectors.
        texcoords: (V, 2).
        attributes: (V, width) each, by name; None for those that there are not.
    """
    out = mi.Mesh(
        name,
        len(positions),
        len(faces),
        has_vertex_normals=normals is not None,
        has_vertex_texcoords=texcoords is not None,
        props=props,
    )
    for key, values in (attributes or {}).items():
        if values is not None:
            out.add_attribute(key, values.shape[1], np.ascontiguousarray(values, np.float32).ravel())
    params = mi.traverse(out)
    arrays = {POSITIONS: positions, NORMALS: normals, TEXCOORDS: texcoords}
    for key, value in arrays.items():
        if value is not None:
            params[key] = mi.Float(np.ascontiguousarray(value, np.float32).ravel())
    params[FACES] = mi.UInt32(np.ascontiguousarray(faces, np.uint32).ravel())
    params.update()
    return out


def vertex_attribute(shape: mi.Shape, name: str) -> tuple[np.ndarray, np.ndarray] | None:
    """Faces (F, 3) and values (V, C) of an attribute of vertices; None if the shape has none by that name."""
    if not shape.is_mesh() or not name.startswith("vertex_"):
        return None
    parameters = mi.traverse(shape)
    if name not in parameters or FACES not in parameters:
        return None
    values = parameters[name].numpy().reshape(shape.vertex_count(), -1)
    return parameters[FACES].numpy().reshape(-1, 3), values


def mesh_attribute_mean(shape: mi.Shape, name: str) -> np.ndarray | None:
    """(C,) mean of a mesh attribute such as "vertex_color"; None if the shape has none by that name."""
    parameters = mi.traverse(shape)
    if not shape.is_mesh() or name not in parameters:
        return None
    count = shape.vertex_count() if name.startswith("vertex_") else shape.face_count()
    return parameters[name].numpy().reshape(count, -1).mean(0, dtype=np.float64)
