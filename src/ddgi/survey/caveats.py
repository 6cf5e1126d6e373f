"""What of a scene will spoil its light: what, how much, and what to do."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ddgi.plural import counted
from ddgi.scene.notes import MATERIALS_MISSING, NO_LIGHT, PICTURE_MISSING
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
MOST_NAMES = 5


@dataclass(frozen=True)
class Caveat:
    """One thing to look at."""

    kind: str  # stable, for scripts
    text: str  # one line


def caveats(
    volume: Volume,
    walls: Walls | None,
    lights: Sequence[Lamp],
    cameras: Sequence[View],
    notes: Sequence[str],
) -> tuple[Caveat, ...]:
    """Everything that gives reason to doubt the light, the gravest first."""
    found = (
        *_dark(lights, notes),
        *_views(cameras, volume),
        *_walls(walls, volume),
        *_lights(lights),
        *_missing(notes),
    )
    return tuple(Caveat(kind, _one_line(text)) for kind, text in found)


Found = Iterator[tuple[str, str]]


def _dark(lights: Sequence[Lamp], notes: Sequence[str]) -> Found:
    if NO_LIGHT in notes:
        yield (
            "no-light",
            "the scene has no light, so a clear sky and its sun were added: choose with --sky, --sun, --env, --point or --spot",
        )
    elif not any(lamp.shines for lamp in lights):
        yield (
            "all-dark",
            f"none of {counted(len(lights), 'light')} shines: give one an intensity, or add light with --sky, --sun, --env, --point or --spot",
        )


def _views(cameras: Sequence[View], volume: Volume) -> Found:
    for camera in cameras:
        who, seen = f'camera "{camera.name}"', 1 - camera.empty
        if camera.distance is None:
            yield "sees-nothing", f"{who} sees nothing: aim it with --look, or choose another with --camera"
        elif camera.behind >= NEARLY_ALL * seen and camera.distance < min(volume.spacing):
            yield (
                "inside-wall",
                (
                    f"{who} stands inside a wall or an object, {_percent(camera.behind)} of its picture shows faces from "
                    f"behind, {camera.distance:.2g} away: move it with --look, or cut what is close away with --near"
                ),
            )
        elif camera.black >= NEARLY_ALL * seen:
            yield (
                "black-picture",
                (
                    f"{who} sees faces from behind alone, {_percent(camera.black / seen)} of what is there, and those are "
                    f"black: aim it with --look, or give their materials two sides"
                ),
            )
        if camera.outside >= MUCH_OUTSIDE:
            yield (
                "view-outside",
                (
                    f"{_percent(camera.outside)} of the picture of {who} lies outside the volume and reads its edge: "
                    "widen grid.box"
                ),
            )


def _walls(walls: Walls | None, volume: Volume) -> Found:
    if walls is None:
        return
    if walls.black >= MANY_BACKS:
        yield (
            "faces-turned-away",
            (
                f"{_percent(walls.black)} of the faces that light meets are turned away and black: turn them around, or give "
                "their materials two sides"
            ),
        )
    if walls.leaky >= LEAKY:
        advice = "give them thickness, or end the volume at them with grid.box"
        if walls.spacing_needed is not None and walls.spacing_needed >= FINEST * min(volume.spacing):
            advice = f"set grid.spacing={0.95 * walls.spacing_needed:.2g} or less, or make them thicker"
        yield (
            "thin-walls",
            (
                f"{_percent(walls.leaky)} of the faces that light meets are thinner than {THIN:g} spacings and have probes "
                f"on both sides, so light may leak ({_percent(walls.sheets)} have no thickness at all): {advice}"
            ),
        )


def _lights(lights: Sequence[Lamp]) -> Found:
    outside = [lamp.name for lamp in lights if lamp.outside and lamp.shines]
    if outside:
        yield (
            "light-outside",
            (
                f"{len(outside)} of {counted(len(lights), 'light')} outside the volume ({_listed(outside)}): what bounces off "
                "the surfaces around is not kept there; widen grid.box if it matters"
            ),
        )


def _missing(notes: Sequence[str]) -> Found:
    missing = [note for note in notes if note.startswith((PICTURE_MISSING, MATERIALS_MISSING))]
    if missing:
        names = [note.split(": ", 1)[1] for note in missing]
        yield (
            "textures-missing",
            (
                f"{counted(len(missing), 'file')} of materials or pictures not found ({_listed(names)}), their surfaces are "
                "plain: put them where the scene's file says"
            ),
        )


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _listed(names: Sequence[str]) -> str:
    more = len(names) - MOST_NAMES
    return ", ".join(names[:MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


def _one_line(text: str) -> str:
    """Names may hold anything."""
    return "".join(c if c.isprintable() else " " for c in text)
