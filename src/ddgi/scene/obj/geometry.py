"""The geometry of an OBJ file: corners of triangles, and pieces of one group and one material."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.no_surface import no_triangle, none_has_area, only
from ddgi.scene.notes import Notes
from ddgi.scene.obj.polygons import triangulated
from ddgi.scene.obj.statements import Statement

WIDTHS = {"v": (3, 4, 6, 7), "vt": (1, 2, 3), "vn": (3,)}
KEPT = {"v": 3, "vt": 2, "vn": 3}
SILENT = ("s", "mtllib", "vp")
CUT = ", vertices alone: was it cut short?"
LARGEST = float(np.finfo(np.float32).max)
"""Number that meshes can hold."""
NONE = -1
"""Number of a corner's texture coordinates or normal where it has none."""


@dataclass
class Piece:
    """Triangles of one group and one material."""

    name: str
    material: str | None
    positions: np.ndarray  # (V, 3)
    faces: np.ndarray  # (F, 3)
    texcoords: np.ndarray | None  # (V, 2) as in the file: v = 0 at a picture's last row
    normals: np.ndarray | None  # (V, 3) unit vectors
    colors: np.ndarray | None  # (V, 3)


@dataclass
class _Polygons:
    """The polygons of a file as written."""

    lines: list[int] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)
    pieces: list[int] = field(default_factory=list)
    seen: list[tuple[int, int, int]] = field(default_factory=list)  # v, vt, vn statements before it
    corners: list[str] = field(default_factory=list)

    def add(self, path: Path, line: int, corners: list[str], piece: int, seen: tuple[int, int, int]) -> None:
        if len(corners) < 3:
            raise SceneError(f"{path}: line {line}: a face of {len(corners)} corner(s)")
        self.lines.append(line)
        self.sizes.append(len(corners))
        self.pieces.append(piece)
        self.seen.append(seen)
        self.corners.extend(corners)


def read_pieces(path: Path, statements: list[Statement], notes: Notes) -> list[Piece]:
    """The pieces of a file, in order of their first face.

    Raises:
        SceneError: A line is wrong; the message says which and how.
    """
    rows: dict[str, list[str]] = {"v": [], "vt": [], "vn": []}
    numbers: dict[str, list[int]] = {"v": [], "vt": [], "vn": []}
    polygons = _Polygons()
    keys: dict[tuple[str, str | None], int] = {}
    group, material, piece = path.stem, None, NONE
    for line, keyword, rest in statements:
        if keyword in rows:
            rows[keyword].append(rest)
            numbers[keyword].append(line)
        elif keyword == "f":
            if piece == NONE:
                piece = keys.setdefault((group, material), len(keys))
            seen = len(rows["v"]), len(rows["vt"]), len(rows["vn"])
            polygons.add(path, line, rest.split(), piece, seen)
        elif keyword in ("g", "o"):
            group, piece = rest or path.stem, NONE
        elif keyword == "usemtl":
            material, piece = rest, NONE
        elif keyword in ("l", "p"):
            notes.add("points and lines are left out")
        elif keyword not in SILENT:
            notes.add(f"lines that start with {keyword!r} are not read")
    if not polygons.sizes:
        raise SceneError(f"{path}: {_without_faces(statements)}")
    tables = {key: _table(path, key, rows[key], numbers[key]) for key in rows}
    return _pieces(path, polygons, list(keys), tables, notes)


def _without_faces(statements: list[Statement]) -> str:
    """What to say of a file that has none."""
    lines = sum(keyword == "l" for _, keyword, _ in statements)
    points = sum(len(rest.split()) for _, keyword, rest in statements if keyword == "p")
    if found := only({"line": lines, "point": points}):
        return no_triangle(found)
    return f"has no faces{CUT if any(keyword == 'v' for _, keyword, _ in statements) else ''}"


def _table(path: Path, key: str, rows: Sequence[str], lines: Sequence[int]) -> np.ndarray:
    """(N, width) the numbers of all statements of one kind; colours of vertices are columns 3 to 5."""
    if not rows:
        return np.zeros((0, KEPT[key]))
    width = len(rows[0].split())
    try:
        values = np.array([row.split() for row in rows], np.float64)
    except ValueError:  # a mistake, or lines of several lengths
        values = np.array([_row(path, key, r, n) for r, n in zip(rows, lines, strict=True)])
    if width not in WIDTHS[key] or values.shape[1] not in WIDTHS[key]:
        values = np.array([_row(path, key, r, n) for r, n in zip(rows, lines, strict=True)])
    bad = ~(np.abs(values) <= LARGEST).all(1)
    if bad.any():
        raise SceneError(f"{path}: line {lines[int(bad.argmax())]}: {key} is not finite, or too large")
    if values.shape[1] >= 6:
        return np.delete(values, 3, 1) if values.shape[1] == 7 else values
    if values.shape[1] == 1:
        return np.column_stack([values, np.zeros(len(values))])
    return values[:, : KEPT[key]]


def _row(path: Path, key: str, row: str, line: int) -> list[float]:
    """The numbers of one statement without what only some lines have."""
    parts = row.split()
    try:
        numbers = [float(x) for x in parts]
    except ValueError as error:
        raise SceneError(f"{path}: line {line}: {key} {row[:40]!r} is not made of numbers") from error
    if len(numbers) not in WIDTHS[key]:
        raise SceneError(f"{path}: line {line}: {key} has {len(numbers)} number(s)")
    return [*numbers, 0.0][: KEPT[key]]


def _indices(path: Path, polygons: _Polygons, tables: dict[str, np.ndarray]) -> np.ndarray:
    """(C, 3) rows of v, vt, vn of all corners of polygons; NONE where there is none."""
    sizes = np.array(polygons.sizes)
    owner = np.repeat(np.arange(len(sizes)), sizes)
    parts = [(corner + "//").split("/")[:3] for corner in polygons.corners]
    out = np.full((len(parts), 3), NONE)
    for column, key in enumerate(("v", "vt", "vn")):
        try:
            given = np.array([int(p[column] or 0) for p in parts])
        except ValueError as error:
            at = next(i for i, p in enumerate(parts) if p[column] and not _whole(p[column]))
            line = polygons.lines[owner[at]]
            raise SceneError(f"{path}: line {line}: a face's {polygons.corners[at][:40]!r}") from error
        before = np.array(polygons.seen)[owner, column]
        rows = np.where(given > 0, given - 1, np.where(given < 0, before + given, NONE))
        bad = (rows >= len(tables[key])) | ((given != 0) & (rows < 0))
        if column == 0:
            bad |= given == 0
        if bad.any():
            at = int(bad.argmax())
            line = polygons.lines[owner[at]]
            raise SceneError(f"{path}: line {line}: a face asks for {key} {given[at]} of {len(tables[key])}")
        out[:, column] = rows
    return out


def _whole(text: str) -> bool:
    try:
        int(text)
    except ValueError:
        return False
    return True


def _pieces(
    path: Path,
    polygons: _Polygons,
    keys: list[tuple[str, str | None]],
    tables: dict[str, np.ndarray],
    notes: Notes,
) -> list[Piece]:
    corners = _indices(path, polygons, tables)
    triangles, owner = _triangles(polygons, corners, tables["v"][:, :3])
    area = np.linalg.norm(_normals(triangles, tables["v"][:, :3]), axis=1)
    if not area.any():
        raise SceneError(f"{path}: {none_has_area(len(area))}")
    if (area == 0).any():
        notes.add(f"{int((area == 0).sum())} triangle(s) without area left out")
        triangles, owner = triangles[area > 0], owner[area > 0]
    lengths = np.append(np.linalg.norm(tables["vn"], axis=1), 0.0)  # the last is that of NONE
    smooth = (lengths[triangles[..., 2]] > 0).all(1)
    piece = np.array(polygons.pieces)[owner]
    out = []
    for index, (name, material) in enumerate(keys):
        for part in (True, False):
            chosen = triangles[(piece == index) & (smooth == part)]
            if len(chosen):
                out.append(_piece(name, material, chosen, tables, part))
    return out


def _triangles(polygons: _Polygons, corners: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(T, 3, 3) v, vt, vn of the corners of triangles, and (T,) the polygon each is of; in file order."""
    sizes = np.array(polygons.sizes)
    starts = np.cumsum(sizes) - sizes
    found, owners = [], []
    for size in np.unique(sizes):
        of_size = np.flatnonzero(sizes == size)
        given = corners[starts[of_size, None] + np.arange(size)]
        cut = triangulated(places[given[..., 0]])
        rows = np.arange(len(of_size))[:, None, None]
        found.append(given[rows, cut].reshape(-1, 3, 3))
        owners.append(np.repeat(of_size, size - 2))
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(found)[order], owner[order]


def _normals(triangles: np.ndarray, places: np.ndarray) -> np.ndarray:
    a, b, c = (places[triangles[:, k, 0]] for k in range(3))
    return np.cross(b - a, c - a)


def _piece(
    name: str, material: str | None, triangles: np.ndarray, tables: dict[str, np.ndarray], smooth: bool
) -> Piece:
    corners = triangles.reshape(-1, 3).copy()
    if not smooth:
        corners[:, 2] = NONE
    spans = [len(tables[key]) + 1 for key in ("v", "vt", "vn")]
    key = ((corners[:, 0] + 1) * spans[1] + corners[:, 1] + 1) * spans[2] + corners[:, 2] + 1
    _, first, faces = np.unique(key, return_index=True, return_inverse=True)
    v, vt, vn = corners[first].T
    normals = tables["vn"][vn] if smooth else None
    if normals is not None:
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    texcoords = None
    if (vt != NONE).any():
        texcoords = np.vstack([tables["vt"], np.zeros(2)])[vt]  # NONE is the last row
    colors = tables["v"][v, 3:6] if tables["v"].shape[1] == 6 else None
    return Piece(name, material, tables["v"][v, :3], faces.reshape(-1, 3), texcoords, normals, colors)
