"""`ddgi render`: a scene to pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ddgi.cli.options import (
    SceneRequest,
    machine_options,
    make_settings,
    open_scene,
    scene_options,
    settings_options,
    start_backend,
)
from ddgi.cli.progress import Progress

if TYPE_CHECKING:
    from ddgi.frame import Frame
    from ddgi.probes.field import IrradianceField
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings


@click.command()
@click.argument("scene")
@click.option("-o", "--output", "outputs", type=click.Path(path_type=Path), required=True, multiple=True, metavar="FILE.png|exr", help="Where the picture goes; several are allowed.")
@click.option("--frames", type=click.IntRange(min=1), default=64, show_default=True, help="Frames to add up while the light converges.")
@scene_options
@settings_options
@machine_options
def render(
    scene: str,
    outputs: tuple[Path, ...],
    frames: int,
    preset: str,
    config: Path | None,
    assignments: tuple[str, ...],
    seed: int | None,
    backend: str,
    json_file: Path | None,
    debug: bool,
    **request: Any,
) -> None:
    """Render SCENE, a built-in name or a Mitsuba .xml file, lit by probes."""
    from ddgi.cli.figures import check_figures_file, write_figures
    from ddgi.output import check_writable, save

    for path in outputs:
        check_writable(path)
    if json_file is not None:
        check_figures_file(json_file)
    settings = make_settings(preset, config, assignments, seed)
    if any(path.suffix.lower() == ".exr" for path in outputs):
        settings = replace(settings, picture=replace(settings.picture, layers=True))
    with Progress() as progress:
        progress.phase(f"loading {scene}")
        start_backend(backend, debug)
        result = _run(open_scene(scene, SceneRequest(**request)), settings, frames, progress)
        progress.phase("writing")
        for path in outputs:
            save(path, result.frame, settings.tone)
        figures = result.figures()
        if json_file is not None:
            write_figures(json_file, figures | {"outputs": [str(path) for path in outputs]})
    for line in (*result.remarks(), _summary(figures, outputs)):
        click.echo(f"ddgi: {line}", err=True)


@dataclass
class Run:
    """A finished rendering."""

    scene: Scene
    settings: RenderSettings
    field: IrradianceField
    frame: Frame
    milliseconds: list[float]  # of each frame
    load_s: float

    def figures(self) -> dict[str, Any]:
        """What it was and how long it took, by name."""
        from statistics import median

        import numpy as np

        from ddgi.passes.tone import automatic_exposure

        grid = self.field.volumes[0].grid
        exposure = self.settings.tone.exposure
        return {
            "scene": self.scene.name,
            "size": list(self.frame.size),
            "frames": len(self.milliseconds),
            "triangles": self.scene.triangles,
            "probes": self.field.probes,
            "counts": list(grid.counts),
            "spacing": [float(x) for x in np.array(grid.spacing).ravel()],
            "load_s": self.load_s,
            "first_frame_ms": self.milliseconds[0],
            "frame_ms": median(self.milliseconds[len(self.milliseconds) // 2 :]),
            "exposure": automatic_exposure(self.frame.numpy()) if exposure is None else exposure,
            "non_finite": {"rays": int(self.field.non_finite[0]), "pixels": self.frame.non_finite},
            "notes": list(self.scene.notes),
        }

    def remarks(self) -> list[str]:
        """What the user should know about the picture."""
        rays, pixels = int(self.field.non_finite[0]), self.frame.non_finite
        lines = [f"note: {note}" for note in self.scene.notes]
        if rays or pixels:
            lines.append(f"warning: {rays} probe rays and {pixels} pixel samples were not numbers; taken as black")
        return lines


def _run(scene: Scene, settings: RenderSettings, frames: int, progress: Progress, loaded: float = 0.0) -> Run:
    """Render all frames."""
    from time import perf_counter

    import drjit as dr

    from ddgi.frame import render_frame
    from ddgi.probes.field import IrradianceField

    field, frame = IrradianceField.fit(scene, settings), None
    progress.phase(f"rendering {scene.name}", frames)
    milliseconds = []
    for tick in range(frames):
        start = perf_counter()
        field, frame = render_frame(scene, field, scene.camera, tick, settings, frame)
        dr.sync_thread()
        milliseconds.append((perf_counter() - start) * 1e3)
        progress.step()
    assert frame is not None
    return Run(scene, settings, field, frame, milliseconds, loaded)


def _summary(figures: dict[str, Any], outputs: tuple[Path, ...]) -> str:
    counts = "x".join(map(str, figures["counts"]))
    spacing = " x ".join(f"{d:.3g}" for d in figures["spacing"])
    width, height = figures["size"]
    return (
        f"{figures['scene']}, {width}x{height}: {figures['probes']:,} probes ({counts}, {spacing} m apart), "
        f"{figures['frames']} frames, {figures['frame_ms']:.1f} ms each, exposure {figures['exposure']:+.2f} EV "
        f"-> {', '.join(map(str, outputs))}"
    )
