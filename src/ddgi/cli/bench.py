"""`ddgi bench`: how fast, against what the machine could do."""

from __future__ import annotations

import click


@click.command()
@click.argument("scenes", nargs=-1)
def bench(scenes: tuple[str, ...]) -> None:
    """Measure SCENES."""
