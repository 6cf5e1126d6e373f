"""Path-traced pictures on disk, found by what they show: a reference per view, and the rivals of it.

Files of another version of this package's format, of Mitsuba, or cut short, are ignored.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ddgi.errors import OutputError
from ddgi.scene.camera import Camera
from ddgi.scene.fingerprint import fingerprint
from ddgi.scene.scene import Scene
from ddgi.whole_file import check_place, whole_file

FORMAT = 2
"""Of the files, and of how references are made."""


@dataclass(frozen=True)
class Key:
    """What a picture shows, and where it is kept."""

    text: str
    path: Path
    shape: tuple[int, int]  # (height, width) [pixels]

    @classmethod
    def of(cls, scene: Scene, camera: Camera, folder: Path | None = None) -> Key:
        """Key of a view of a scene."""
        view = camera.fingerprint(scene.origin)
        text = f"ddgi {FORMAT}, mitsuba {version('mitsuba')}, {fingerprint(scene)}, {view}"
        name = f"{scene.name}-{hashlib.sha256(text.encode()).hexdigest()[:20]}.npz"
        width, height = camera.size
        return cls(text, (folder or default_folder()) / name, (height, width))

    def beside(self, what: str) -> Key:
        """Key of another picture of the same view. what: letters, digits and dashes."""
        return replace(
            self, text=f"{self.text}, {what}", path=self.path.with_name(f"{self.path.stem}-{what}.npz")
        )


def default_folder() -> Path:
    """`$DDGI_CACHE_DIR`, else `ddgi` in the user's folder for caches."""
    if own := os.environ.get("DDGI_CACHE_DIR"):
        return Path(own)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "ddgi" / "references"


def load(key: Key, shapes: dict[str, tuple[int, ...]]) -> dict[str, Any] | None:
    """What was stored under a key; None if there is nothing usable.

    Args:
        key: As it was stored.
        shapes: Of the pictures among it, which must be finite.
    """
    try:
        with open(key.path, "rb") as stream, np.load(stream, allow_pickle=False) as file:
            if str(file["key"]) != key.text:
                return None
            values = {name: file[name] for name in file.files if name != "key"}
    except Exception:  # missing, cut short, another format: numpy and zipfile raise many kinds
        return None
    pictures = [(values.get(name), shape) for name, shape in shapes.items()]
    if any(p is None or p.shape != shape or not np.isfinite(p).all() for p, shape in pictures):
        return None
    return {name: value if value.ndim else value.item() for name, value in values.items()}


def make_folder(key: Key) -> None:
    """See that references can be kept.

    Raises:
        OutputError: They cannot; says what to do.
    """
    advice = "set DDGI_CACHE_DIR to another folder for references"
    try:
        key.path.parent.mkdir(parents=True, exist_ok=True)
        check_place(key.path)
    except OSError as error:
        raise OutputError(f"{key.path.parent}: cannot be made ({error.strerror}): {advice}") from error
    except OutputError as error:
        raise OutputError(f"{error}: {advice}") from error


def store(key: Key, values: dict[str, Any]) -> None:
    """Keep values under a key; a file appears whole or not at all.

    Raises:
        OutputError: The folder cannot be written.
    """
    with whole_file(key.path) as path, open(path, "wb") as file:
        np.savez_compressed(file, key=key.text, **values)
