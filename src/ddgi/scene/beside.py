"""Files that a scene names: they must lie in its own folder or below, through links too."""

from __future__ import annotations

import re
from pathlib import Path

from ddgi.errors import SceneError

SCHEME = re.compile(r"^[A-Za-z][A-Za-z0-9+.-]*:")
SHOWN = 60
"""Characters of a name that messages show."""


class MissingFileError(SceneError):
    """The file would be allowed, but there is none."""


def file_beside(
    name: str, folder: Path, owner: str, *, written: str | None = None, any_case: bool = False
) -> Path:
    """The file that a name means.

    Args:
        name: A path relative to `folder`; backslashes part folders too, as exporters on Windows write.
        folder: The folder of the scene.
        owner: Whose file it is, for messages.
        written: The name as the file has it, for messages.
        any_case: Where no file has this name, one that differs in case will do.

    Raises:
        MissingFileError: There is no such file.
        SceneError: It does not lie in `folder`.
    """
    text = shown(name if written is None else written)
    name = name.replace("\\", "/")
    outside = SceneError(f"{owner}: {text} leads out of the scene's folder, which is not allowed")
    if name.startswith("/") or SCHEME.match(name):
        raise outside
    if not name or not name.isprintable():
        raise SceneError(f"{owner}: {text!r} is not the path of a file")
    try:
        path = (folder / name).resolve()
        inside = path.is_relative_to(folder.resolve())
        found = path.is_file()
        if inside and not found and any_case:
            path = _in_any_case(folder.resolve(), path).resolve()
            inside, found = path.is_relative_to(folder.resolve()), path.is_file()
    except (OSError, RuntimeError) as error:  # names too long, links in a circle
        raise SceneError(f"{owner}: {text} cannot be found") from error
    if not inside:
        raise outside
    if not found:
        raise MissingFileError(f"{owner}: file not found: {text}")
    return path


def shown(name: str) -> str:
    """A name as messages show it."""
    text = name if name.isprintable() else repr(name)
    return text if len(text) <= SHOWN else text[:SHOWN] + "..."


def _in_any_case(folder: Path, path: Path) -> Path:
    """The path with each part as the disk has it; unchanged from where nothing fits."""
    for part in path.relative_to(folder).parts:
        exact = folder / part
        if not exact.exists() and folder.is_dir():
            fits = sorted(p for p in folder.iterdir() if p.name.lower() == part.lower())
            exact = fits[0] if fits else exact
        folder = exact
    return folder
