"""Figures for scripts: JSON files that appear whole or not at all, or JSON on stdout."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

import click

from ddgi.errors import OutputError

STDOUT = Path("-")


def check_figures_file(path: Path) -> None:
    """See that figures can be written, before the work starts.

    Raises:
        OutputError: They cannot; says why.
    """
    folder = path.resolve().parent
    if path == STDOUT:
        return
    if path.is_dir():
        raise OutputError(f"{path} is a folder: name a file in it")
    if not folder.is_dir():
        raise OutputError(f"{path}: there is no folder {folder}")
    if path.exists() and not path.is_file():
        raise OutputError(f"{path} is not a plain file")
    if not os.access(folder, os.W_OK | os.X_OK) or (path.exists() and not os.access(path, os.W_OK)):
        raise OutputError(f"{path}: no permission to write it")


def write_figures(path: Path, figures: Any) -> None:
    """Write figures as JSON.

    Raises:
        OutputError: The file cannot be written.
    """
    text = json.dumps(figures, indent=2, allow_nan=False)
    if path == STDOUT:
        click.echo(text)
        return
    target = path.resolve()
    beside = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        beside.write_text(text + "\n")
        os.replace(beside, target)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}") from error
    finally:
        with suppress(OSError):
            beside.unlink()
