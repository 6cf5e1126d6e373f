"""Figures for scripts: JSON files that appear whole or not at all."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from ddgi.errors import OutputError


def check_figures_file(path: Path) -> None:
    """See that figures can be written, before the work starts.

    Raises:
        OutputError: They cannot; says why.
    """
    if path.is_dir():
        raise OutputError(f"{path} is a folder: name a file in it")
    if not path.resolve().parent.is_dir():
        raise OutputError(f"{path}: there is no folder {path.resolve().parent}")
    if not os.access(path if path.exists() else path.resolve().parent, os.W_OK):
        raise OutputError(f"{path}: no permission to write it")


def write_figures(path: Path, figures: Any) -> None:
    """Write figures as JSON.

    Raises:
        OutputError: The file cannot be written.
    """
    text = json.dumps(figures, indent=2) + "\n"
    if path.exists() and not path.is_file():  # a pipe, or /dev/stdout
        path.write_text(text)
        return
    target = path.resolve()
    beside = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        beside.write_text(text)
        os.replace(beside, target)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}") from error
    finally:
        with suppress(OSError):
            beside.unlink()
