"""`ddgi info`: what a scene holds, where its probes would stand, and what will spoil the light."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ddgi.cli.figures import STDOUT, check_figures_file, write_figures
from ddgi.cli.options import json_option, request_options
from ddgi.cli.progress import Progress
from ddgi.cli.request import SceneRequest, SettingsRequest
from ddgi.plural import counted

if TYPE_CHECKING:
    from ddgi.survey.report import Survey
    from ddgi.survey.views import View


@click.command()
@click.argument("scene")
@json_option
@request_options
def info(
    scene: str, json_file: Path | None, scene_request: SceneRequest, settings_request: SettingsRequest
) -> None:
    """Look SCENE over: what it holds, the probes it would get and their memory, and what will spoil the light."""
    settings_request.start_backend()
    from ddgi.survey.report import survey

    if json_file is not None:
        check_figures_file(json_file)
    settings = settings_request.settings()
    with Progress() as progress:
        progress.phase(f"loading {scene}")
        opened = scene_request.open(scene)
        progress.phase(f"looking {opened.name} over")
        found = survey(opened, settings)
    if json_file != STDOUT:
        click.echo("\n".join(_lines(found)))
    if json_file is not None:
        write_figures(json_file, found.figures())


def _lines(found: Survey) -> Iterator[str]:
    yield found.scene
    for title, text in _rows(found):
        yield f"  {title:<9}{text}"
    yield from (f"note: {note}" for note in found.notes)
    yield from (f"warning: {warning.text}" for warning in found.warnings)


def _rows(found: Survey) -> Iterator[tuple[str, str]]:
    holds, volume, walls = found.contents, found.volume, found.walls
    instances = f", {counted(holds.instances, 'instance')}" if holds.instances else ""
    yield "geometry", f"{counted(holds.triangles, 'triangle')} in {counted(holds.shapes, 'shape')}{instances}"
    texels = f" of {holds.texels / 1e6:.2g} million texels" if holds.textures else ""
    yield "surfaces", f"{counted(holds.materials, 'material')}, {counted(holds.textures, 'texture')}{texels}"
    yield "lights", _lights(found)
    for camera in found.cameras:
        yield "camera", _camera(camera)
    if holds.animations or holds.skins or holds.morphs:
        yield (
            "moves",
            (
                f"{counted(holds.animations, 'animation')}, {counted(holds.skins, 'skin')}, "
                f"{counted(holds.morphs, 'shape')} with morph targets"
            ),
        )
    yield "units", f"{' or '.join(found.units) or 'unclear'}, to judge by the size of the volume"
    counts, spacing = "x".join(map(str, volume.counts)), " x ".join(f"{d:.3g}" for d in volume.spacing)
    low, high = (", ".join(f"{x:.4g}" for x in corner) for corner in volume.box)
    yield (
        "probes",
        f"{volume.probes:,} ({counts}, {spacing} apart) from ({low}) to ({high}), {SOURCES[volume.source]}",
    )
    yield "memory", f"{volume.bytes_per_probe:,} bytes per probe, {volume.bytes / 1e6:.3g} MB in all"
    if walls is not None:
        yield (
            "faces",
            (
                f"that light meets: {_percent(walls.behind)} seen from behind, {_percent(walls.black)} black from there; "
                f"{_percent(walls.sheets)} without thickness, {_percent(walls.leaky)} thin and with probes on both sides"
            ),
        )


SOURCES = {
    "settings": "as grid.box says",
    "scene": "as the scene says",
    "cameras": "where the cameras' light goes",
    "bounds": "around all geometry",
}


def _lights(found: Survey) -> str:
    """How many of each kind, and which are off."""
    kinds = Counter(lamp.kind for lamp in found.lights)
    off = [lamp.name for lamp in found.lights if not lamp.shines]
    text = ", ".join(f"{number} {kind}" for kind, number in kinds.items())
    return text + (f"; {len(off)} give none" if off else "")


def _camera(camera: View) -> str:
    width, height = camera.size
    rest = "" if camera.distance is None else f", the rest {camera.distance:.3g} away (median)"
    return f'"{camera.name}", {width}x{height}: {_percent(camera.empty)} empty{rest}'


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"
