"""`ddgi bench`: how fast, against what the machine could do."""

from __future__ import annotations

import platform
import signal
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click

from ddgi.cli.figures import STDOUT, check_figures_file, write_figures
from ddgi.cli.options import json_option, request_options
from ddgi.cli.progress import Progress
from ddgi.cli.request import SceneRequest, SettingsRequest
from ddgi.errors import DDGIError

DEFAULT_SCENES = ("cornell-point", "cornell", "courtyard")
DEFAULT_SIZE = (640, 360)


@dataclass(frozen=True)
class Job:
    """One scene to measure; travels to the process that does it."""

    source: str
    scene: SceneRequest
    settings: SettingsRequest


@click.command()
@click.argument("scenes", nargs=-1)
@click.option(
    "--starts/--no-starts",
    default=True,
    show_default=True,
    help="Time the cold and the warm start too, 64 frames each.",
)
@json_option
@request_options
def bench(
    scenes: tuple[str, ...],
    starts: bool,
    json_file: Path | None,
    scene_request: SceneRequest,
    settings_request: SettingsRequest,
) -> None:
    """Measure SCENES: time per stage, kernel launches, memory, the limit, cold and warm start.

    Each scene runs in a process of its own, pictures at 640x360 unless --size says otherwise.
    """
    if json_file is not None:
        check_figures_file(json_file)
    settings_request.start_backend()
    settings_request.settings()  # refuse bad settings before the first process starts
    if scene_request.size is None:
        scene_request = replace(scene_request, size=DEFAULT_SIZE)
    jobs = [Job(source, scene_request, settings_request) for source in scenes or DEFAULT_SCENES]
    with Progress() as progress:
        results = {job.source: _figures(job, starts, progress) for job in jobs}
    if json_file != STDOUT:
        from ddgi.bench.table import table

        click.echo(table(results))
    if json_file is not None:
        write_figures(json_file, {"machine": _machine(), "scenes": results})


def _figures(job: Job, starts: bool, progress: Progress) -> dict[str, Any]:
    """All figures of one scene."""
    progress.phase(f"measuring {job.source}")
    figures = _in_own_process(job)
    if starts:
        from ddgi.bench.starts import start_seconds

        progress.phase(f"starting cold and warm with {job.source}")
        arguments = [job.source, *job.scene.arguments(), *job.settings.arguments()]
        figures["cold_start_s"], figures["warm_start_s"] = start_seconds(arguments)
    return figures


def _in_own_process(job: Job) -> dict[str, Any]:
    """Measure in a fresh process: its memory is the scene's, and one scene's kernels are no other's."""
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    # Ctrl-C reaches both processes: the child dies without a word, and only we report it.
    quiet: dict[str, Any] = {"initializer": signal.signal, "initargs": (signal.SIGINT, signal.SIG_DFL)}
    with ProcessPoolExecutor(1, mp_context=get_context("spawn"), **quiet) as pool:
        try:
            return pool.submit(_measure, job).result()
        except BrokenProcessPool as error:
            raise DDGIError(f"{job.source}: the measuring process crashed") from error


def _measure(job: Job) -> dict[str, Any]:
    from ddgi.bench.measure import measure

    backend = job.settings.start_backend()
    return {"backend": backend} | measure(job.scene.open(job.source), job.settings.settings())


def _machine() -> dict[str, Any]:
    import os
    from importlib.metadata import version

    packages = {name: version(name) for name in ("mitsuba", "drjit", "numpy")}
    return {
        "processor": platform.machine(),
        "cpus": os.cpu_count(),
        "python": platform.python_version(),
    } | packages
