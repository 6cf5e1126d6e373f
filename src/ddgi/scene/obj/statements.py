"""The lines of OBJ and MTL files: comments gone, continued lines joined, each with its number."""

from __future__ import annotations

from pathlib import Path

from ddgi.errors import SceneError

Statement = tuple[int, str, str]
"""Number of the line, keyword, and the rest of the line."""


def read_statements(path: Path) -> list[Statement]:
    """All statements of a file.

    Raises:
        SceneError: It cannot be read, or is not text.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise SceneError(f"{path}: cannot be read: {error.strerror}") from error
    if b"\0" in data:
        raise SceneError(f"{path}: is not a text file")
    lines = data.decode("utf-8-sig", errors="replace").splitlines()
    out: list[Statement] = []
    begun, start = "", 0
    for number, line in enumerate(lines, 1):
        if line.endswith("\\"):
            begun, start = begun + line[:-1] + " ", start or number
            continue
        if begun:
            line, number, begun, start = begun + line, start, "", 0
        parts = line.split("#", 1)[0].split(None, 1)
        if parts:
            out.append((number, parts[0], parts[1].strip() if len(parts) > 1 else ""))
    if begun.strip():
        keyword, _, rest = begun.strip().partition(" ")
        out.append((start, keyword, rest.strip()))
    return out
