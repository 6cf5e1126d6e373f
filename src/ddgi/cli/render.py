"""`ddgi render`: a scene to pictures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from ddgi.cli.animation import FRAMES, Asked, animate, check
from ddgi.cli.figures import check_figures_file, write_figures
from ddgi.cli.options import FILE, json_option, request_options
from ddgi.cli.progress import Progress
from ddgi.cli.request import SceneRequest, SettingsRequest
from ddgi.cli.values import Finite
from ddgi.plural import counted

if TYPE_CHECKING:
    from ddgi.passes import tone as tones
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings
    from ddgi.still import Still

STILL_FRAMES = 64
"""Added up to a still, if nothing else is asked for."""


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
    help="Where the picture goes; repeatable. An animation may go to FILE.mp4.",
)
@click.option(
    "--frames",
    type=click.IntRange(min=1),
    help="Frames to add up while the light converges; 64 by default, 8 for each picture of an animation.",
)
@click.option(
    "--turntable",
    type=click.IntRange(min=2, max=9999),
    metavar="N",
    help="N pictures all around, FILE-000 and on: around the object, or on the spot inside a room.",
)
@click.option(
    "--animation",
    is_flag=False,
    flag_value="",
    metavar="[NAME]",
    help="Play an animation of the file, the first or that of a name or number: FILE-0000 and on, or FILE.mp4.",
)
@click.option(
    "--fps", type=Finite(min=0.01, max=1000), default=30.0, show_default=True, help="Pictures a second."
)
@click.option("--start", type=Finite(min=0), default=0.0, show_default=True, help="Where to begin [s].")
@click.option("--duration", type=Finite(min=0), help="How long [s]; by default to the animation's end.")
@json_option
@request_options
def render(
    scene: str,
    outputs: tuple[Path, ...],
    frames: int | None,
    turntable: int | None,
    animation: str | None,
    fps: float,
    start: float,
    duration: float | None,
    json_file: Path | None,
    scene_request: SceneRequest,
    settings_request: SettingsRequest,
) -> None:
    """Render SCENE, a built-in name, a glTF (.glb, .gltf), .obj, .ply or Mitsuba .xml file, lit by probes."""
    if animation is not None:
        if turntable is not None:
            raise click.UsageError("--turntable or --animation, not both")
        if scene_request.time is not None or scene_request.clip is not None:
            raise click.UsageError(
                "--animation plays moments itself: --start instead of --time, and its name after --animation"
            )
        if len(outputs) > 1:
            raise click.UsageError("an animation goes to one --output")
        asked = Asked(animation or None, fps, start, duration, frames or FRAMES)
        _animate(scene, outputs[0], asked, json_file, scene_request, settings_request)
        return
    frames = frames or STILL_FRAMES
    with Progress() as progress:
        progress.phase("starting")
        files = _numbered(outputs, turntable)
        figures = _render(scene, files, frames, json_file, scene_request, settings_request, progress)
    for line in (*_remarks(figures), _summary(figures)):
        click.echo(f"ddgi: {line}", err=True)
    if json_file is not None:
        write_figures(json_file, figures)


def _animate(
    source: str,
    output: Path,
    asked: Asked,
    json_file: Path | None,
    scene_request: SceneRequest,
    settings_request: SettingsRequest,
) -> None:
    """Moments of an animation, to pictures or a video."""
    with Progress() as progress:
        progress.phase("starting")
        settings_request.start_backend()
        check(output)
        if json_file is not None:
            check_figures_file(json_file, output)
        settings = settings_request.settings()
        progress.phase(f"loading {source}")
        scene = scene_request.open(source)
        changed = Path(source).stat().st_mtime_ns if Path(source).is_file() else 0
        described = {"scene": source, "changed": changed, "options": scene_request.arguments()}
        say = lambda line: click.echo(f"ddgi: {line}", err=True)  # noqa: E731
        figures = animate(scene, settings, asked, output, described, progress, say)
    for line in (
        *(f"note: {note}" for note in figures["notes"]),
        f"{scene.name}: {counted(figures['pictures'], 'picture')} -> {_files(figures['outputs'])}",
    ):
        click.echo(f"ddgi: {line}", err=True)
    if json_file is not None:
        write_figures(json_file, {"scene": scene.name} | figures)


def _render(
    source: str,
    files: list[tuple[Path, ...]],
    frames: int,
    json_file: Path | None,
    scene_request: SceneRequest,
    settings_request: SettingsRequest,
    progress: Progress,
) -> dict[str, Any]:
    """Do it all; what can be refused is refused before the first ray. files: those of each view."""
    settings_request.start_backend()
    from ddgi.output import check_writable
    from ddgi.turntable import turntable, views

    outputs = [path for group in files for path in group]
    for path in outputs:
        check_writable(path)
    if json_file is not None:
        check_figures_file(json_file, *outputs)
    settings = settings_request.settings()
    if any(path.suffix.lower() == ".exr" for path in outputs):
        settings = replace(settings, picture=replace(settings.picture, layers=True))
    progress.phase(f"loading {source}")
    start = perf_counter()
    scene = scene_request.open(source)
    load_s = perf_counter() - start
    cameras = views(scene, len(files), scene_request.look) if len(files) > 1 else [scene.camera]
    progress.phase(f"rendering {scene.name}", frames * len(cameras))
    first = _save(turntable(scene, settings, frames, cameras, progress.step), files, settings.tone)
    return {"outputs": [str(path) for path in outputs], "load_s": load_s} | _figures(scene, settings, first)


def _save(stills: Iterator[Still], files: list[tuple[Path, ...]], tone: tones.Settings) -> Still:
    """Write the pictures of each view, all of them or none, exposed like the first; returns that."""
    from ddgi.output import save
    from ddgi.whole_file import whole_files

    first = None
    with whole_files([path for group in files for path in group]) as places:
        for number, done in enumerate(stills):
            if first is None:
                first, tone = done, replace(tone, exposure=_exposure(done, tone))
            for place in places[number * len(files[0]) : (number + 1) * len(files[0])]:
                save(place, done.frame, tone)
    assert first is not None  # there is one view at least
    return first


def _exposure(done: Still, tone: tones.Settings) -> float:
    """Of a picture [stops]."""
    from ddgi.passes.tone import automatic_exposure

    return automatic_exposure(done.frame.numpy()) if tone.exposure is None else tone.exposure


def _numbered(outputs: tuple[Path, ...], count: int | None) -> list[tuple[Path, ...]]:
    """The files of each view: numbered ones, or without a count those of the only one."""
    if count is None or not all(p.name for p in outputs):  # a folder is refused later
        return [outputs]
    return [tuple(p.with_name(f"{p.stem}-{n:03d}{p.suffix}") for p in outputs) for n in range(count)]


def _figures(scene: Scene, settings: RenderSettings, done: Still) -> dict[str, Any]:
    """What was rendered and how long it took, by name."""
    import numpy as np

    from ddgi.survey.reach import remark

    grid, black = done.field.volumes[0].grid, not done.frame.numpy().any()
    without = None if black else remark(scene, done.field, settings)
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
        "exposure": _exposure(done, settings.tone),
        "black": black,
        "non_finite": {"rays": int(done.field.non_finite[0]), "pixels": done.frame.non_finite},
        "notes": [*scene.notes, *([] if without is None else [without])],
    }


def _remarks(figures: dict[str, Any]) -> list[str]:
    """What the user should know about the picture."""
    from ddgi.passes.tone import MOST_STOPS

    lines = [f"note: {note}" for note in figures["notes"]]
    rays, pixels = figures["non_finite"]["rays"], figures["non_finite"]["pixels"]
    if rays or pixels:
        lines.append(
            f"warning: {rays} probe rays and {pixels} pixel samples were not numbers; taken as black"
        )
    if figures["black"]:
        lines.append(
            "warning: the picture is black: no light comes to what the camera sees, or it stands inside something; "
            "`ddgi info` tells, --look and --point help"
        )
    elif figures["exposure"] >= MOST_STOPS:
        lines.append(
            f"warning: hardly any light: the picture stays dark although it is brightened by {figures['exposure']:.0f} stops; "
            "add a light (--sky, --point), or set tone.exposure"
        )
    return lines


def _summary(figures: dict[str, Any]) -> str:
    counts = "x".join(map(str, figures["counts"]))
    spacing = " x ".join(f"{d:.3g}" for d in figures["spacing"])
    width, height = figures["size"]
    return (
        f"{figures['scene']}, {width}x{height}: {counted(figures['probes'], 'probe')} ({counts}, {spacing} apart), "
        f"{counted(figures['frames'], 'frame')}, {figures['frame_ms']:.1f} ms each, exposure {figures['exposure']:+.2f} EV "
        f"-> {_files(figures['outputs'])}"
    )


def _files(names: list[str]) -> str:
    """All of a few, and the first and the last of many."""
    return ", ".join(names) if len(names) <= 4 else f"{names[0]} ... {names[-1]} ({len(names)} files)"
