"""`ddgi render`: a scene to pictures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from ddgi.cli.figures import check_figures_file, write_figures
from ddgi.cli.options import FILE, json_option, request_options
from ddgi.cli.progress import Progress
from ddgi.cli.request import SceneRequest, SettingsRequest
from ddgi.plural import counted

if TYPE_CHECKING:
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings
    from ddgi.still import Still


@click.command()
@click.argument("scene")
@click.option(
    "-o",
    "--output",
    "outputs",
    type=FILE,
    required=True,
    multiple=True,
    metavar="FILE.png|exr",
    help="Where the picture goes; repeatable.",
)
@click.option(
    "--frames",
    type=click.IntRange(min=1),
    default=64,
    show_default=True,
    help="Frames to add up while the light converges.",
)
@json_option
@request_options
def render(
    scene: str,
    outputs: tuple[Path, ...],
    frames: int,
    json_file: Path | None,
    scene_request: SceneRequest,
    settings_request: SettingsRequest,
) -> None:
    """Render SCENE, a built-in name, a glTF (.glb, .gltf), .obj, .ply or Mitsuba .xml file, lit by probes."""
    with Progress() as progress:
        progress.phase("starting")
        figures = _render(scene, outputs, frames, json_file, scene_request, settings_request, progress)
    for line in (*_remarks(figures), _summary(figures)):
        click.echo(f"ddgi: {line}", err=True)
    if json_file is not None:
        write_figures(json_file, figures)


def _render(
    source: str,
    outputs: tuple[Path, ...],
    frames: int,
    json_file: Path | None,
    scene_request: SceneRequest,
    settings_request: SettingsRequest,
    progress: Progress,
) -> dict[str, Any]:
    """Do it all; what can be refused is refused before the first ray."""
    settings_request.start_backend()
    from ddgi.output import check_writable, save
    from ddgi.still import still

    for path in outputs:
        check_writable(path)
    if json_file is not None:
        check_figures_file(json_file)
    settings = settings_request.settings()
    if any(path.suffix.lower() == ".exr" for path in outputs):
        settings = replace(settings, picture=replace(settings.picture, layers=True))
    progress.phase(f"loading {source}")
    start = perf_counter()
    scene = scene_request.open(source)
    load_s = perf_counter() - start
    progress.phase(f"rendering {scene.name}", frames)
    done = still(scene, settings, frames, progress.step)
    progress.phase("writing")
    for path in outputs:
        save(path, done.frame, settings.tone)
    return {"outputs": [str(path) for path in outputs], "load_s": load_s} | _figures(scene, settings, done)


def _figures(scene: Scene, settings: RenderSettings, done: Still) -> dict[str, Any]:
    """What was rendered and how long it took, by name."""
    import numpy as np

    from ddgi.passes.tone import automatic_exposure

    grid, exposure = done.field.volumes[0].grid, settings.tone.exposure
    return {
        "scene": scene.name,
        "size": list(done.frame.size),
        "frames": len(done.milliseconds),
        "triangles": scene.triangles,
        "probes": done.field.probes,
        "counts": list(grid.counts),
        "spacing": [float(x) for x in np.ravel(grid.spacing)],
        "first_frame_ms": done.milliseconds[0],
        "frame_ms": done.frame_ms,
        "exposure": automatic_exposure(done.frame.numpy()) if exposure is None else exposure,
        "non_finite": {"rays": int(done.field.non_finite[0]), "pixels": done.frame.non_finite},
        "notes": list(scene.notes),
    }


def _remarks(figures: dict[str, Any]) -> list[str]:
    """What the user should know about the picture."""
    lines = [f"note: {note}" for note in figures["notes"]]
    rays, pixels = figures["non_finite"]["rays"], figures["non_finite"]["pixels"]
    if rays or pixels:
        lines.append(
            f"warning: {rays} probe rays and {pixels} pixel samples were not numbers; taken as black"
        )
    return lines


def _summary(figures: dict[str, Any]) -> str:
    counts = "x".join(map(str, figures["counts"]))
    spacing = " x ".join(f"{d:.3g}" for d in figures["spacing"])
    width, height = figures["size"]
    return (
        f"{figures['scene']}, {width}x{height}: {counted(figures['probes'], 'probe')} ({counts}, {spacing} m apart), "
        f"{counted(figures['frames'], 'frame')}, {figures['frame_ms']:.1f} ms each, exposure {figures['exposure']:+.2f} EV "
        f"-> {', '.join(figures['outputs'])}"
    )
