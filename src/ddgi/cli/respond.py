"""`ddgi respond`: how soon indirect light follows a light that is switched."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ddgi.cli.figures import STDOUT, check_figures_file, write_figures
from ddgi.cli.options import json_option, request_options
from ddgi.cli.progress import Progress
from ddgi.cli.request import SceneRequest, SettingsRequest


@click.command()
@click.argument("scene")
@click.option("--light", metavar="NAME|INDEX", help="Which light to switch; by default all of them.")
@json_option
@request_options
def respond(
    scene: str,
    light: str | None,
    json_file: Path | None,
    scene_request: SceneRequest,
    settings_request: SettingsRequest,
) -> None:
    """Count the frames until SCENE's indirect light has covered 90 % of a step, a light switched off and on."""
    settings_request.start_backend()
    from ddgi.judge.respond import LIMIT
    from ddgi.judge.respond import respond as measure

    if json_file is not None:
        check_figures_file(json_file)
    settings = settings_request.settings()
    with Progress() as progress:
        progress.phase(f"loading {scene}")
        opened = scene_request.open(scene)
        result = measure(opened, settings, light, watch=progress)
    figures = {"scene": opened.name, "size": list(opened.camera.size), "limit": LIMIT} | result.figures()
    if json_file != STDOUT:
        click.echo("\n".join(_lines(figures)))
    if json_file is not None:
        write_figures(json_file, figures)


def _lines(figures: dict[str, Any]) -> list[str]:
    width, height = figures["size"]
    what = "all lights" if figures["light"] is None else f"light {figures['light']}"
    return [
        f"{figures['scene']}, {width}x{height}, {what}: frames until 90 % of the step in indirect light",
        *(f"{way:<4} {_frames(figures[f'{way}_frames'], figures['limit'])}" for way in ("off", "on")),
        f"the steady level's spread is {100 * figures['noise']:.2g} % of the step",
    ]


def _frames(frames: int | None, limit: int) -> str:
    return f"not within {limit}" if frames is None else str(frames)
