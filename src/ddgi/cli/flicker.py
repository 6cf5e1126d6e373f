"""`ddgi flicker`: how much a still picture changes from frame to frame."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ddgi.cli.figures import STDOUT, check_figures_file, write_figures
from ddgi.cli.options import FILE, json_option, request_options
from ddgi.cli.progress import Progress
from ddgi.cli.request import SceneRequest, SettingsRequest

if TYPE_CHECKING:
    from ddgi.judge.flicker import Flicker


@click.command()
@click.argument("scene")
@click.option(
    "-o",
    "--output",
    "map_file",
    type=FILE,
    metavar="FILE.png|exr",
    help="Where it flickers: a picture in false colours, or the numbers themselves.",
)
@json_option
@request_options
def flicker(
    scene: str,
    map_file: Path | None,
    json_file: Path | None,
    scene_request: SceneRequest,
    settings_request: SettingsRequest,
) -> None:
    """Measure how SCENE flickers: 50 frames after 200 of warm-up, direct light held still."""
    settings_request.start_backend()
    from ddgi.judge.flicker import flicker as measure
    from ddgi.output import check_writable

    if map_file is not None:
        check_writable(map_file)
    if json_file is not None:
        check_figures_file(json_file, map_file)
    settings = settings_request.settings()
    with Progress() as progress:
        progress.phase(f"loading {scene}")
        opened = scene_request.open(scene)
        result = measure(opened, settings, watch=progress)
    colours = None if map_file is None else _save_map(map_file, result)
    figures = {"scene": opened.name, "size": list(opened.camera.size)} | result.figures()
    if json_file != STDOUT:
        click.echo("\n".join(_lines(figures)))
        if colours is not None:
            click.echo(f"{map_file}: {colours}")
    if json_file is not None:
        write_figures(json_file, figures)


def _save_map(path: Path, result: Flicker) -> str:
    """Write the map; what its colours say."""
    import numpy as np

    from ddgi.judge.false_colour import false_colour, scale_top
    from ddgi.output import save
    from ddgi.passes import tone

    if path.suffix.lower() == ".exr":
        save(path, np.repeat(result.change[..., None], 3, axis=2))
        return "mean change of each pixel"
    top = scale_top(result.change)
    save(path, false_colour(result.change, top), tone.Settings(exposure=0.0, curve="linear"))
    return f"black is no change, the brightest yellow {top:g} or more; the scale is at the bottom"


def _lines(figures: dict[str, Any]) -> list[str]:
    width, height = figures["size"]
    return [
        f"{figures['scene']}, {width}x{height}, hysteresis {figures['hysteresis']:g}: change of a pixel from frame "
        f"to frame, channels summed, over {figures['frames']} frames after {figures['warm_up']}",
        f"mean         {figures['flicker_mean']:.5f}",
        f"worst pixel  {figures['flicker_max']:.5f}",
        *(
            []
            if figures["flicker_max"]
            else ["nothing changes at all: is the picture black? `ddgi info` tells what lights there are"]
        ),
    ]
