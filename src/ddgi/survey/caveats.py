"""What of a scene will spoil its light: what, how much, and what to do."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ddgi.plural import counted, percent
from ddgi.scene.beside import shown
from ddgi.scene.notes import LIGHT_OPTIONS, MATERIALS_MISSING, NO_LIGHT, PICTURE_MISSING
from ddgi.survey.lamps import Lamp
from ddgi.survey.views import View
from ddgi.survey.volume import Volume
from ddgi.survey.walls import LEAKY, THIN, Walls

NEARLY_ALL = 0.95
"""Of a picture: the rest are slivers between shapes."""
MUCH_OUTSIDE = 0.2
"""Of a picture: more than what shows through a window."""
MANY_BACKS = 0.5
FINEST = 0.5
"""Of the spacing: a finer one needs more than eight times the probes, and is no advice."""
ROUNDING = 0.9
"""Of the spacing needed: planes come in whole numbers."""
MOST_NAMES = 5


@dataclass(frozen=True)
class Caveat:
    """One thing to look at."""

    kind: str  # stable, for scripts
    text: str  # one line: what, how much, what to do


def caveats(
    volume: Volume,
    walls: Walls | None,
    lights: Sequence[Lamp],
    camera: View,
    notes: Sequence[str],
) -> tuple[Caveat, ...]:
    """Everything that gives reason to doubt the light, the gravest first.

    Args:
        volume: Where the probes stand.
        walls: What light meets; None for nothing.
        lights: All of them.
        camera: The one that a picture is taken with.
        notes: Of the import.
    """
    blind = _blind(camera, volume)
    found = [_dark(lights, notes), blind, _outside(camera)]
    if walls is not None and blind is None:  # what a blind camera meets says nothing about the rest
        found += [_turned_away(walls), _thin(walls, volume)]
    found += [_lights_outside(lights), _missing(notes)]
    return tuple(caveat for caveat in found if caveat is not None)


def _dark(lights: Sequence[Lamp], notes: Sequence[str]) -> Caveat | None:
    if NO_LIGHT in notes:
        text = f"the scene has no light, a clear sky and its sun were added: choose with {LIGHT_OPTIONS}"
        return Caveat("no-light", text)
    if any(lamp.shines for lamp in lights):
        return None
    names = _listed([lamp.name for lamp in lights])
    text = f"no light shines ({len(lights)} there: {names}): give one an intensity, or add some with {LIGHT_OPTIONS}"
    return Caveat("all-dark", text)


def _blind(camera: View, volume: Volume) -> Caveat | None:
    """Why a camera shows nothing that is lit."""
    who, seen = _named(camera), 1 - camera.empty
    if camera.distance is None:
        text = f"{who} sees nothing: aim it with --look, or choose another with --camera"
        return Caveat("sees-nothing", text)
    if camera.behind >= NEARLY_ALL * seen and camera.distance < min(volume.spacing):
        text = f"{who} stands inside a wall or an object, {percent(camera.behind)} of its picture shows faces from behind, {camera.distance:.2g} away: move it with --look, or cut them away with --near"
        return Caveat("inside-wall", text)
    if camera.black >= NEARLY_ALL * seen:
        text = f"{who} sees faces from behind alone, {percent(camera.black / seen)} of what is there, and black: move it with --look, or give their materials two sides"
        return Caveat("black-picture", text)
    return None


def _outside(camera: View) -> Caveat | None:
    if camera.outside < MUCH_OUTSIDE:
        return None
    text = f"{percent(camera.outside)} of the picture of {_named(camera)} lies outside the volume, and reads its edge: name a larger grid.box"
    return Caveat("view-outside", text)


def _turned_away(walls: Walls) -> Caveat | None:
    if walls.black < MANY_BACKS:
        return None
    text = f"{percent(walls.black)} of the faces that light meets are turned away and black: turn them around, or give their materials two sides"
    return Caveat("faces-turned-away", text)


def _thin(walls: Walls, volume: Volume) -> Caveat | None:
    if walls.leaky < LEAKY:
        return None
    advice = "give them thickness, or end the volume at them with grid.box"
    if walls.spacing_needed is not None and walls.spacing_needed >= FINEST * min(volume.spacing):
        spacing = ROUNDING * walls.spacing_needed
        probes = math.ceil(volume.probes * math.prod(volume.spacing) / spacing**3)
        advice = f"make them thicker, or set grid.budget={probes}, for a spacing of {spacing:.2g}"
    text = f"{percent(walls.leaky)} of the faces that light meets are thinner than {THIN:g} spacings with probes on both sides ({percent(walls.sheets)} have no thickness at all): few probes light each side, and presets without query.sight leak: {advice}"
    return Caveat("thin-walls", text)


def _lights_outside(lights: Sequence[Lamp]) -> Caveat | None:
    outside = [lamp.name for lamp in lights if lamp.outside and lamp.shines]
    if not outside:
        return None
    text = f"{len(outside)} of {counted(len(lights), 'light')} outside the volume ({_listed(outside)}): light that bounces there is not kept, name a larger grid.box if it matters"
    return Caveat("light-outside", text)


def _missing(notes: Sequence[str]) -> Caveat | None:
    missing = [
        note.split(": ", 1)[1] for note in notes if note.startswith((PICTURE_MISSING, MATERIALS_MISSING))
    ]
    if not missing:
        return None
    text = f"{counted(len(missing), 'file')} of pictures or materials not found ({_listed(missing)}), their surfaces are plain: put them where the scene's file says"
    return Caveat("textures-missing", text)


def _named(camera: View) -> str:
    return f'camera "{shown(camera.name)}"'


def _listed(names: Sequence[str]) -> str:
    more = len(names) - MOST_NAMES
    return ", ".join(map(shown, names[:MOST_NAMES])) + (f" and {more} more" if more > 0 else "")
