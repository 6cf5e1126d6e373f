"""`ddgi explain`: what lights a pixel, probe by probe, and where the error comes from."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ddgi.cli.figures import STDOUT, check_figures_file, write_figures
from ddgi.cli.options import FILE, json_option, request_options
from ddgi.cli.progress import Progress
from ddgi.cli.request import SceneRequest, SettingsRequest
from ddgi.cli.values import Finite, Pixel

if TYPE_CHECKING:
    from ddgi.judge.explain import Explanation, ProbeShare

COLUMNS = (
    "probe",
    "at",
    "moved",
    "state",
    "trilinear",
    "wrap",
    "visible",
    "crushed",
    "believed",
    "a ray sees",
    "share",
    "E alone",
    "E by rays",
)


@click.command()
@click.argument("scene")
@click.option("--pixel", type=Pixel(), required=True, help="Column and row, from 0,0 at the top left.")
@click.option("-o", "--output", type=FILE, metavar="FILE.png", help="The steps of the error as a picture.")
@click.option(
    "--frames", type=click.IntRange(min=1), default=48, show_default=True, help="Updates of the field."
)
@click.option(
    "--seconds",
    type=Finite(min=0),
    default=10.0,
    show_default=True,
    help="Time for path tracing the pixel, about.",
)
@json_option
@request_options
def explain(
    scene: str,
    pixel: tuple[int, int],
    output: Path | None,
    frames: int,
    seconds: float,
    json_file: Path | None,
    scene_request: SceneRequest,
    settings_request: SettingsRequest,
) -> None:
    """Explain the indirect light of a pixel of SCENE: its eight probes and their weights, beside a path tracer."""
    settings_request.start_backend()
    from ddgi.judge.explain import explain as find
    from ddgi.output import check_display, save_display

    if output is not None:
        check_display(output)
    if json_file is not None:
        check_figures_file(json_file, output)
    settings = settings_request.settings()
    with Progress() as progress:
        progress.phase(f"loading {scene}")
        opened = scene_request.open(scene)
        found = find(opened, settings, pixel, frames=frames, seconds=seconds, watch=progress)
    if output is not None:
        from ddgi.judge.bars import bars

        save_display(output, bars(found))
    if json_file != STDOUT:
        click.echo("\n".join(_lines(found)))
    if json_file is not None:
        write_figures(json_file, {"scene": opened.name, "camera": opened.camera.name} | found.figures())


def _lines(found: Explanation) -> Iterator[str]:
    from ddgi.judge.explain import luminance

    errors, noises = found.errors, found.noises
    yield f"pixel {found.pixel[0]},{found.pixel[1]} shows {_three(found.position)}, normal {_three(found.normal)}, albedo {_three(found.albedo)}"
    rows = [COLUMNS, *map(_row, found.probes)]
    widths = [max(len(row[i]) for row in rows) + 2 for i in range(len(COLUMNS))]
    for row in rows:
        yield "".join(f"{cell:>{width}}" for cell, width in zip(row, widths, strict=True))
    yield "E [W/m^2]: the light alone that the probe would give, by its map and by rays from it; believed: the weight after query.sight, of which share is the part"
    yield ""
    for name, light in found.steps.items():
        error = errors[name]
        apart = "" if error is None else f"{100 * error:+.1f} %"
        exact = f" +- {noises[name]:.1g}" if noises[name] else ""
        yield f"{name:<18}E {luminance(light):.4g}{exact}  ({_three(light)})  {apart}"
    yield "+-: standard error, by rays that are drawn; %: of the light that the surface sends on, E times albedo"
    yield found.largest_step
    yield from (f"note: {note}" for note in found.notes)


def _row(p: ProbeShare) -> tuple[str, ...]:
    return (
        f"{p.number}: {','.join(map(str, p.coordinates))}", _three(p.position),
        _three(p.moved) if any(p.moved) else "-", p.state, _factor(p.trilinear), _factor(p.wrap), _factor(p.visible),
        _factor(p.crushed, "2g"), _factor(p.believed, "2g"), "yes" if p.sees else "no", f"{100 * p.share:.1f} %", _three(p.irradiance), _three(p.exact),
    )  # fmt: skip


def _factor(value: float | None, digits: str = "3f") -> str:
    return "-" if value is None else f"{value:.{digits}}"


def _three(values: tuple[float, float, float]) -> str:
    return ", ".join(f"{v:.3g}" for v in values)
