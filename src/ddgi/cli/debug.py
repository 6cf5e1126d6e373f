"""`ddgi debug`: pictures of what the field does."""

from __future__ import annotations

from pathlib import Path

import click

from ddgi.cli.options import FILE, request_options
from ddgi.cli.progress import Progress
from ddgi.cli.request import SceneRequest, SettingsRequest

VIEWS = ("probes", "offsets", "states", "weights", "leak", "irradiance-atlas", "distance-atlas")
"""As `ddgi.debug.views` has them, which takes long to load."""


@click.command()
@click.argument("scene")
@click.option("--view", type=click.Choice(VIEWS), required=True, help="What to show: docs/debug.md.")
@click.option("-o", "--output", type=FILE, metavar="FILE.png", required=True, help="The picture.")
@click.option(
    "--frames", type=click.IntRange(min=1), default=32, show_default=True, help="Updates of the field before."
)
@request_options
def debug(
    scene: str,
    view: str,
    output: Path,
    frames: int,
    scene_request: SceneRequest,
    settings_request: SettingsRequest,
) -> None:
    """Show what the field of SCENE does: its probes, where they were moved, their weights, leaks, maps."""
    settings_request.start_backend()
    from ddgi.debug.views import VIEWS as DRAWN
    from ddgi.debug.views import look
    from ddgi.output import check_display, save_display

    check_display(output)
    settings = settings_request.settings()
    with Progress() as progress:
        progress.phase(f"loading {scene}")
        opened = scene_request.open(scene)
        progress.phase("rendering", frames)
        seen = look(opened, settings, frames, progress)
        progress.phase("drawing")
        picture = DRAWN[view](seen)
        save_display(output, picture)
    click.echo(f"wrote {output}: {view}; docs/debug.md says what the colours mean")
