"""An OBJ file to the dictionary that Mitsuba's parser takes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.beside import MissingFileError, file_beside
from ddgi.scene.gltf.names import Names
from ddgi.scene.mesh_arrays import described
from ddgi.scene.notes import MATERIALS_MISSING, Notes
from ddgi.scene.obj.geometry import Piece, read_pieces
from ddgi.scene.obj.materials import Materials
from ddgi.scene.obj.mtl import Material, read_materials
from ddgi.scene.obj.statements import Statement, read_statements
from ddgi.scene.recentre import origin_for


def read_obj(path: Path, notes: Notes) -> tuple[dict[str, Any], np.ndarray]:
    """Read an .obj file and the .mtl files that it names.

    Args:
        path: The file; others that it names must lie in its folder.
        notes: Takes what was changed or left out.

    Returns:
        The description, and (3,) the place in the file's coordinates that it counts from.

    Raises:
        SceneError: It cannot be used; the message names the file and the line.
    """
    try:
        statements = read_statements(path)
        pieces = read_pieces(path, statements, notes)
        places = np.concatenate([piece.positions for piece in pieces])
        origin = origin_for(places.min(0), places.max(0))
        for piece in pieces:
            piece.positions = piece.positions - origin
        return _described(pieces, _materials(path, statements, notes), notes), origin
    except SceneError as error:  # what the file says is in it
        raise SceneError("".join(c if c.isprintable() else " " for c in str(error))) from error


def _materials(path: Path, statements: list[Statement], notes: Notes) -> dict[str, Material]:
    out: dict[str, Material] = {}
    for line, keyword, rest in statements:
        if keyword == "mtllib":
            for name in _libraries(rest, path.parent):
                owner = f"{path}: line {line}: mtllib"
                try:
                    found = file_beside(name, path.parent, owner, any_case=True)
                except MissingFileError:
                    notes.add(f"{MATERIALS_MISSING}: {name}")
                    continue
                out.update(read_materials(found, notes))
    return out


def _libraries(rest: str, folder: Path) -> list[str]:
    """The files of an mtllib; one name with spaces in it, if there is such a file."""
    try:
        one = (folder / rest.replace("\\", "/")).is_file()
    except OSError:  # too long for the name of a file
        one = False
    return [rest] if one else rest.split()


def _described(pieces: list[Piece], known: dict[str, Material], notes: Notes) -> dict[str, Any]:
    made, names = Materials(notes), Names()
    plugins: dict[str, Any] = {"type": "scene"}
    keys: dict[tuple[str | None, bool], str] = {}
    for piece in pieces:
        material = _material(piece, known, notes)
        key = piece.material, piece.colors is not None
        if key not in keys:
            keys[key] = f"_material-{len(keys)}"
            plugins[keys[key]] = made.bsdf(material, piece.colors is not None)
        shape = _shape(piece, material, names)
        shape["bsdf"] = {"type": "ref", "id": keys[key]}
        radiance = made.radiance(material)
        if radiance is not None:
            shape["emitter"] = {"type": "area", "radiance": radiance}
        plugins[f"_shape-{len(plugins)}"] = shape
    return plugins


def _material(piece: Piece, known: dict[str, Material], notes: Notes) -> Material:
    if piece.material is None:
        return Material("", diffuse=np.ones(3)) if piece.colors is not None else Material("")
    if piece.material not in known:
        notes.add(f"no material {piece.material!r}: grey instead")
        return Material(piece.material)
    return known[piece.material]


def _shape(piece: Piece, material: Material, names: Names) -> dict[str, Any]:
    texcoords = np.zeros((len(piece.positions), 2)) if piece.texcoords is None else piece.texcoords
    colors = piece.colors
    if colors is not None:
        tint = np.ones(3) if material.diffuse is None else material.diffuse
        colors = np.clip(colors * tint, 0, 1)
    shape = described(
        piece.positions, piece.faces, normals=piece.normals,
        texcoords=texcoords * [1, -1] + [0, 1],  # ours run down from a picture's first row
        colors=colors,
    )  # fmt: skip
    return {"id": names.unique(piece.name), **shape}
