"""A PLY file to the dictionary that Mitsuba's parser takes.

The format has no materials: surfaces are matt, grey or of the vertices' colours, and two-sided. Faces are smooth, by
the vertices' normals or, as Mitsuba has it, by the mean of those of the triangles around, weighted by their angles
(Thuermer and Wuethrich, "Computing Vertex Normals from Polygonal Facets", 1998).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.mesh_arrays import described
from ddgi.scene.mesh_keys import COLOR_ATTRIBUTE
from ddgi.scene.notes import Notes
from ddgi.scene.obj.polygons import triangulated
from ddgi.scene.ply.faces import Faces, read_faces, vertex_count
from ddgi.scene.ply.header import Header, read_header
from ddgi.scene.ply.tables import Table, read_tables
from ddgi.scene.recentre import origin_for

GREY = 0.5
PLACE, NORMAL = ("x", "y", "z"), ("nx", "ny", "nz")
COLORS = (("r", "g", "b"), ("red", "green", "blue"))
BRIGHTEST = {"u1": 255, "u2": 65535}
"""What stands for 1, by a property's type."""
LARGEST = float(np.finfo(np.float32).max)
"""Number that meshes can hold."""


def read_ply(path: Path, notes: Notes) -> tuple[dict[str, Any], np.ndarray]:
    """Read a .ply file.

    Args:
        path: The file.
        notes: Takes what was left out.

    Returns:
        The description, and (3,) the place in the file's coordinates that it counts from.

    Raises:
        SceneError: It cannot be used; the message names the file and the vertex or face.
    """
    try:
        return _read(path, notes)
    except SceneError as error:
        line = "".join(c if c.isprintable() else " " for c in str(error))  # what the file says is in it
        raise SceneError(f"{path}: {line}") from error


def _read(path: Path, notes: Notes) -> tuple[dict[str, Any], np.ndarray]:
    data = path.read_bytes()
    header = read_header(data)
    tables = read_tables(data, header, ("vertex", "face"))
    if not vertex_count(header):
        raise SceneError("has no vertices")
    places = _columns(tables["vertex"], PLACE)
    if places is None:
        raise SceneError("its vertices have no x, y and z")
    triangles = _triangles(read_faces(tables, len(places)), places, notes)
    used, faces = np.unique(triangles, return_inverse=True)
    faces, places = faces.reshape(-1, 3), places[used]
    origin = origin_for(places.min(0), places.max(0))
    normals, colors = _normals(tables["vertex"], used, places, faces), _colors(header, tables["vertex"])
    shape = described(
        places - origin, faces, normals=normals, texcoords=np.zeros((len(places), 2)),
        colors=None if colors is None else colors[used],
    )  # fmt: skip
    color = {"type": "rgb", "value": GREY} if colors is None else _OF_VERTICES
    bsdf = {"type": "twosided", "nested": {"type": "diffuse", "reflectance": color}}
    return {"type": "scene", "_shape-0": {"id": path.stem, **shape, "bsdf": bsdf}}, origin


def _columns(table: Table, names: tuple[str, ...]) -> np.ndarray | None:
    """(V, n) numbers of vertices; None if they have none of these names."""
    if not set(names) <= set(table.numbers):
        return None
    values = np.stack([table.numbers[name] for name in names], 1)
    bad = ~(np.abs(values) <= LARGEST).all(1)
    if bad.any():
        what = ", ".join(names)
        raise SceneError(
            f"vertex {int(bad.argmax()) + 1} of {len(bad)}: {what} not finite, or too large to be held"
        )
    return values


def _triangles(faces: Faces, places: np.ndarray, notes: Notes) -> np.ndarray:
    """(T, 3) numbers of vertices, in file order."""
    if (faces.sizes < 3).any():
        notes.add(f"{int((faces.sizes < 3).sum())} face(s) of less than three corners left out")
    starts = np.cumsum(faces.sizes) - faces.sizes
    found, owners = [np.zeros((0, 3), np.int64)], [np.zeros(0, np.int64)]
    for size in np.unique(faces.sizes[faces.sizes >= 3]):
        of_size = np.flatnonzero(faces.sizes == size)
        given = faces.corners[starts[of_size, None] + np.arange(size)]
        cut = triangulated(places[given])
        found.append(given[np.arange(len(of_size))[:, None, None], cut].reshape(-1, 3))
        owners.append(np.repeat(of_size, size - 2))
    triangles = np.concatenate(found)[np.argsort(np.concatenate(owners), kind="stable")]
    flat = (_crosses(places, triangles) == 0).all(1)
    if flat.all():
        raise SceneError(f"none of the {len(flat)} triangle(s) has an area")
    if flat.any():
        notes.add(f"{int(flat.sum())} triangle(s) without area left out")
    return triangles[~flat]


def _crosses(places: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = places[triangles].swapaxes(0, 1)
    return np.cross(b - a, c - a)


def _normals(table: Table, used: np.ndarray, places: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(V, 3) unit vectors: the file's, and where it has none those of the triangles around."""
    given = _columns(table, NORMAL)
    own = np.zeros_like(places) if given is None else given[used]
    missing = ~own.any(1)
    if missing.any():
        own[missing] = _around(places, faces)[missing]
    return own / np.linalg.norm(own, axis=1, keepdims=True)


def _around(places: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(V, 3) the normals of the triangles around each vertex, weighted by their angles there."""
    flat = _unit(_crosses(places, faces))
    total = np.zeros_like(places)
    for corner in range(3):
        here, after, before = (places[faces[:, (corner + k) % 3]] for k in range(3))
        cosine = (_unit(after - here) * _unit(before - here)).sum(1)
        weighted = np.arccos(np.clip(cosine, -1, 1))[:, None] * flat
        for axis in range(3):
            total[:, axis] += np.bincount(faces[:, corner], weighted[:, axis], len(places))
    lost = np.linalg.norm(total, axis=1) < 1e-9  # both sides of a sheet, say
    total[lost] = [0, 0, 1]
    return total


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), np.finfo(float).tiny)


def _colors(header: Header, table: Table) -> np.ndarray | None:
    """(V, 3) linear, 1 for white; None if vertices have none."""
    codes = {p.name: p.code for e in header.elements if e.name == "vertex" for p in e.properties}
    for names in COLORS:
        values = _columns(table, names)
        if values is not None:
            return values / BRIGHTEST.get(codes[names[0]], 1)
    return None


_OF_VERTICES = {"type": "mesh_attribute", "name": COLOR_ATTRIBUTE}
