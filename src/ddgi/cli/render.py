"""`ddgi render`: a scene to pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from ddgi.cli.figures import check_figures_file, write_figures
from ddgi.cli.options import FILE, json_option, request_options
from ddgi.cli.progress import Progress
from ddgi.cli.request import SceneRequest, SettingsRequest

if TYPE_CHECKING:
    from ddgi.frame import Frame
    from ddgi.probes.field import IrradianceField
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings


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
    """Render SCENE, a built-in name, a glTF file (.glb, .gltf) or a Mitsuba .xml file, lit by probes."""
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
    result = _run(scene, settings, frames, progress)
    progress.phase("writing")
    for path in outputs:
        save(path, result.frame, settings.tone)
    return {"outputs": [str(path) for path in outputs], "load_s": load_s} | result.figures()


@dataclass
class Run:
    """A finished rendering."""

    scene: Scene
    settings: RenderSettings
    field: IrradianceField
    frame: Frame
    milliseconds: list[float]  # of each frame

    def figures(self) -> dict[str, Any]:
        """What it was and how long it took, by name."""
        import numpy as np

        from ddgi.passes.tone import automatic_exposure

        grid, exposure = self.field.volumes[0].grid, self.settings.tone.exposure
        return {
            "scene": self.scene.name,
            "size": list(self.frame.size),
            "frames": len(self.milliseconds),
            "triangles": self.scene.triangles,
            "probes": self.field.probes,
            "counts": list(grid.counts),
            "spacing": [float(x) for x in np.ravel(grid.spacing)],
            "first_frame_ms": self.milliseconds[0],
            "frame_ms": median(self.milliseconds[len(self.milliseconds) // 2 :]),
            "exposure": automatic_exposure(self.frame.numpy()) if exposure is None else exposure,
            "non_finite": {"rays": int(self.field.non_finite[0]), "pixels": self.frame.non_finite},
            "notes": list(self.scene.notes),
        }


def _run(scene: Scene, settings: RenderSettings, frames: int, progress: Progress) -> Run:
    """Render all frames."""
    import drjit as dr

    from ddgi.frame import render_frame
    from ddgi.probes.field import IrradianceField

    progress.phase(f"rendering {scene.name}", frames)
    field = IrradianceField.fit(scene, settings)
    frame: Frame | None = None
    milliseconds = []
    for tick in range(frames):
        start = perf_counter()
        field, frame = render_frame(scene, field, scene.camera, tick, settings, frame)
        dr.sync_thread()
        milliseconds.append((perf_counter() - start) * 1e3)
        progress.step()
    assert frame is not None  # frames >= 1
    return Run(scene, settings, field, frame, milliseconds)


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
        f"{figures['scene']}, {width}x{height}: {figures['probes']:,} probes ({counts}, {spacing} m apart), "
        f"{figures['frames']} frames, {figures['frame_ms']:.1f} ms each, exposure {figures['exposure']:+.2f} EV "
        f"-> {', '.join(figures['outputs'])}"
    )
