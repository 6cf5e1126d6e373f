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
from ddgi.plural import counted, percent

if TYPE_CHECKING:
    from ddgi.survey.report import Survey
    from ddgi.survey.views import View
    from ddgi.survey.volume import Volume
    from ddgi.survey.walls import Walls

SOURCES = {
    "settings": "as grid.box says",
    "scene": "as the scene says",
    "cameras": "where the cameras' light goes",
    "bounds": "around all geometry",
}
"""Whose the volume's box is."""


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
    holds = found.contents
    instances = f", {counted(holds.instances, 'instance')}" if holds.instances else ""
    yield "geometry", f"{counted(holds.triangles, 'triangle')} in {counted(holds.shapes, 'shape')}{instances}"
    texels = f" of {holds.texels / 1e6:.2g} million texels" if holds.textures else ""
    yield "surfaces", f"{counted(holds.materials, 'material')}, {counted(holds.textures, 'texture')}{texels}"
    yield "lights", _lights(found)
    for camera in found.cameras:
        yield "camera", _camera(camera)
    moving = [(holds.animations, "animation"), (holds.skins, "skin"), (holds.morphs, "morphing shape")]
    if any(number for number, _ in moving):
        yield "moves", ", ".join(counted(number, thing) for number, thing in moving if number)
    yield "units", f"{' or '.join(found.units) or 'unclear'}, to judge by the size of the volume"
    yield "probes", _probes(found.volume)
    yield (
        "memory",
        f"{found.volume.bytes_per_probe:,} bytes per probe, {found.volume.bytes / 1e6:.3g} MB in all",
    )
    if found.walls is not None:
        yield "faces", _faces(found.walls)


def _lights(found: Survey) -> str:
    """How many of each kind, and how many are off."""
    kinds = Counter(lamp.kind for lamp in found.lights)
    off = sum(not lamp.shines for lamp in found.lights)
    return ", ".join(f"{number} {kind}" for kind, number in kinds.items()) + (
        f"; {off} without light" if off else ""
    )


def _camera(camera: View) -> str:
    from ddgi.scene.beside import shown

    width, height = camera.size
    rest = "" if camera.distance is None else f", the rest {camera.distance:.3g} away (median)"
    shares = f"{percent(camera.empty)} empty, {percent(camera.black)} black"
    return f"{shown(camera.name)}, {width}x{height}: {shares}{rest}"


def _probes(volume: Volume) -> str:
    counts, spacing = "x".join(map(str, volume.counts)), " x ".join(f"{d:.3g}" for d in volume.spacing)
    low, high = (", ".join(f"{x:.6g}" for x in corner) for corner in volume.box)
    moved = f"; {volume.moved:,} moved" if volume.moved else ""
    idle = volume.probes - volume.awake
    asleep = f"; {idle:,} light nothing, and are left out" if idle else ""
    return f"{volume.probes:,} ({counts}, {spacing} apart) from ({low}) to ({high}), {SOURCES[volume.source]}{moved}{asleep}"


def _faces(walls: Walls) -> str:
    return (
        f"that light meets: {percent(walls.behind)} seen from behind, {percent(walls.black)} black from there; "
        f"{percent(walls.sheets)} without thickness, {percent(walls.leaky)} thin with probes on both sides"
    )
