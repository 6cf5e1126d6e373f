"""Figures for scripts: JSON files that appear whole or not at all, or JSON on stdout."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from ddgi.whole_file import check_place, whole_file

STDOUT = Path("-")


def check_figures_file(path: Path) -> None:
    """See that figures can be written, before the work starts.

    Raises:
        OutputError: They cannot; says why.
    """
    if path != STDOUT:
        check_place(path)


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
