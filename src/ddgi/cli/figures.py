"""Figures for scripts: JSON files that appear whole or not at all, or JSON on stdout."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from ddgi.errors import OutputError
from ddgi.whole_file import check_place, whole_file

STDOUT = Path("-")


def check_figures_file(path: Path, *pictures: Path | None) -> None:
    """See that figures can be written, before the work starts.

    Args:
        path: Where to.
        pictures: Where the command's pictures go, if it writes any.

    Raises:
        OutputError: They cannot; says why.
    """
    if path == STDOUT:
        return
    check_place(path)
    if path.resolve() in (picture.resolve() for picture in pictures if picture is not None):
        raise OutputError(f"{path}: the picture and the figures cannot go to one file")


def write_figures(path: Path, figures: Any) -> None:
    """Write figures as JSON.

    Raises:
        OutputError: The file cannot be written.
    """
    text = json.dumps(figures, indent=2, allow_nan=False)
    if path == STDOUT:
        click.echo(text)
        return
    with whole_file(path) as file:
        file.write_text(text + "\n")
