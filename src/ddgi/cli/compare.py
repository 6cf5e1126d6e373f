"""`ddgi compare`: how wrong the light is, against a path-traced reference."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from ddgi.cli.figures import STDOUT, check_figures_file, write_figures
from ddgi.cli.options import FILE, json_option, request_options
from ddgi.cli.progress import Progress
from ddgi.cli.request import SceneRequest, SettingsRequest
from ddgi.cli.values import Finite
from ddgi.errors import SettingsError

if TYPE_CHECKING:
    from ddgi.judge.compare import Comparison
    from ddgi.judge.trial import Trial


@click.command()
@click.argument("scene")
@click.option("-o", "--output", type=FILE, metavar="FILE.png", help="Everything in one picture.")
@click.option("--frames", type=click.IntRange(min=1), default=64, show_default=True, help="Frames to add up.")
@click.option("--presets", metavar="A,B,...", help="Compare several presets, in place of --preset.")
@click.option(
    "--sweep",
    multiple=True,
    metavar="STAGE.FIELD=V1,V2,...",
    help="Compare several values of a setting; repeatable: one is changed at a time.",
)
@click.option(
    "--target",
    type=Finite(min=0, min_open=True),
    default=0.05,
    show_default=True,
    help="Mean FLIP that the reference must be able to tell from its noise.",
)
@click.option(
    "--seconds",
    type=Finite(min=0),
    default=120.0,
    show_default=True,
    help="Most time for refining the reference; rendering and rivals take theirs on top.",
)
@click.option(
    "--rivals/--no-rivals", default=True, show_default=True, help="Path trace and denoise in equal time."
)
@json_option
@request_options
def compare(
    scene: str,
    output: Path | None,
    frames: int,
    presets: str | None,
    sweep: tuple[str, ...],
    target: float,
    seconds: float,
    rivals: bool,
    json_file: Path | None,
    scene_request: SceneRequest,
    settings_request: SettingsRequest,
) -> None:
    """Compare SCENE, lit by probes, with a path-traced reference of the same view.

    The reference is kept, and refined when asked for more ($DDGI_CACHE_DIR, or the user's cache folder).
    """
    _check_presets(presets)
    with Progress() as progress:
        progress.phase("starting")
        settings_request.start_backend()
        from ddgi.judge.compare import compare as judge
        from ddgi.output import check_display

        if output is not None:
            check_display(output)
        if json_file is not None:
            check_figures_file(json_file, output)
        trials = list(_trials(settings_request, presets, sweep))
        progress.phase(f"loading {scene}")
        loaded = scene_request.open(scene)
        found = judge(
            loaded, trials, frames=frames, target=target, most_seconds=seconds, rivals=rivals,
            watch=progress,
        )  # fmt: skip
        if output is not None:
            progress.phase("writing")
            _write_sheet(output, found)
    for note in found.notes:
        click.echo(f"ddgi: note: {note}", err=True)
    if json_file != STDOUT:
        from ddgi.judge.table import table

        click.echo(table(found))
    if json_file is not None:
        write_figures(json_file, found.figures() | {"command": sys.argv[1:]})


def _check_presets(presets: str | None) -> None:
    """Refuse a --preset beside --presets, which would not count.

    Raises:
        click.UsageError: Both were given.
    """
    context = click.get_current_context()
    asked = context.get_parameter_source("preset") not in (None, ParameterSource.DEFAULT)
    if presets is not None and asked:
        raise click.UsageError("give --preset or --presets, not both", context)


def _write_sheet(path: Path, found: Comparison) -> None:
    from ddgi.judge.sheet import sheet
    from ddgi.output import save_display

    save_display(path, sheet(found))


def _trials(request: SettingsRequest, presets: str | None, sweep: tuple[str, ...]) -> Iterator[Trial]:
    """The configurations asked for, each once: every preset as it is, then with every value swept."""
    from ddgi.judge.trial import Trial

    seen = set()
    names = [request.preset] if presets is None else [name.strip() for name in presets.split(",")]
    changes = ["", *itertools.chain.from_iterable(map(_assignments, sweep))]
    for name, change in itertools.product(names, changes):
        asked = replace(request, preset=name, set=(*request.set, *([change] if change else [])))
        label = f"{name} {change}".strip() if presets is not None else change or name
        if label not in seen:
            seen.add(label)
            yield Trial(label, asked.settings())


def _assignments(text: str) -> list[str]:
    """`stage.field=v1,v2` as one assignment a value; commas inside brackets do not part values.

    Raises:
        SettingsError: There is no "=" or no value.
    """
    name, equals, values = text.partition("=")
    parts, depth = [""], 0
    for letter in values:
        depth += (letter in "[(") - (letter in ")]")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    if not equals or not name.strip() or not all(part.strip() for part in parts):
        raise SettingsError(f"{text!r} does not read stage.field=value,value,...")
    return [f"{name.strip()}={part.strip()}" for part in parts]
