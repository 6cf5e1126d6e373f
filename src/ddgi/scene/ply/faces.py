"""The faces of a PLY file: polygons whose corners are vertices that exist."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.ply.header import Header, read_header
from ddgi.scene.ply.tables import Table, read_tables

CORNERS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class Faces:
    """F polygons, in file order."""

    sizes: np.ndarray  # (F,) numbers of corners
    corners: np.ndarray  # numbers of vertices, one polygon after another


def read_faces(tables: dict[str, Table], vertices: int) -> Faces:
    """The polygons of a file with so many vertices.

    Raises:
        SceneError: There are none, or a corner is no vertex; says which face.
    """
    lists = tables["face"].lists if "face" in tables else {}
    found = next((lists[name] for name in CORNERS if name in lists), None)
    if found is None or not len(found[0]):
        raise SceneError("has no faces, which points alone do not show")
    sizes, corners = found
    bad = ~((corners >= 0) & (corners < vertices) & (corners == np.floor(corners)))
    if bad.any():
        at = int(bad.argmax())
        face = int(np.searchsorted(np.cumsum(sizes), at, side="right"))
        raise SceneError(
            f"face {face + 1} of {len(sizes)} uses vertex {corners[at]:.10g}, but there are {vertices}, counted from 0"
        )
    return Faces(sizes, corners.astype(np.int64))


def vertex_count(header: Header) -> int:
    """How many there are, as the header has it."""
    return next((element.count for element in header.elements if element.name == "vertex"), 0)


def check_triangles(path: Path) -> None:
    """Refuse faces that Mitsuba's own reader takes for something else: not triangles, or of no vertices.

    Raises:
        SceneError: There is one; says which. Of what else is wrong with a file Mitsuba complains.
    """
    data = path.read_bytes()
    try:
        header = read_header(data)
        tables = read_tables(data, header, ("face",))
    except SceneError:
        return
    if "face" not in tables or not any(len(sizes) for sizes, _ in tables["face"].lists.values()):
        return
    faces = read_faces(tables, vertex_count(header))
    other = faces.sizes != 3
    if other.any():
        face = int(other.argmax())
        raise SceneError(
            f"face {face + 1} of {len(other)} has {faces.sizes[face]} corners, only triangles are read here: "
            "triangulate the file, or load it by itself"
        )
