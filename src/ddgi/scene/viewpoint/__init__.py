"""A camera for a scene that has none: in a room if there is one, else around the object."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ddgi.scene.camera import Camera, look_at
from ddgi.scene.viewpoint import around, inside
from ddgi.scene.viewpoint.outline import near_shapes, outlines, without_backdrop
from ddgi.scene.viewpoint.rooms import WALLS, candidates, far_off, survey
from ddgi.scene.viewpoint.views import View

if TYPE_CHECKING:
    from ddgi.scene.scene import Scene

SIZE = (640, 360)
SEEDS = 1024
"""Points near the shapes, from where places to stand are looked for."""
INDOORS = "in a room"
DIGITS = 3
"""Of places, beyond the first digit of how far off the target is: few enough to be typed again."""


@dataclass(frozen=True)
class Viewpoint:
    """A camera that was chosen."""

    camera: Camera
    notes: tuple[str, ...]  # which, and why, a line each


def find(scene: Scene, *, indoors: bool = False) -> Viewpoint:
    """Choose a camera. A scene gets the same one every time, and a larger copy one that is larger likewise.

    Where it can, it stands in a room with light; else it shows all of the object from outside. If nothing is
    lit there, it stands in a room after all, even one whose walls are all turned the wrong way.

    Args:
        scene: What there is.
        indoors: It is a room that is to be seen, so that even a dark one is better than a view from outside.
    """
    dark: list[tuple[str, View]] = []
    for where, view in _choices(scene):
        if view.lit or (indoors and where == INDOORS):
            break
        dark.append((where, view))
    else:
        where, view = dark[0]
    digits = DIGITS - math.floor(math.log10(np.linalg.norm(view.target - view.place)))
    there = np.array(scene.origin)  # rays count from it, users do not
    look = [round(float(x), digits) + 0.0 for x in (*(view.place + there), *(view.target + there))]
    camera = look_at(look[:3], look[3:], scene.up, fov=view.fov, size=SIZE, name="found")
    notes = [
        f"no camera in the scene: one chosen {where}, as by --look {','.join(f'{x:.15g}' for x in look)}"
    ]
    if not view.lit:
        notes.append(
            "no light comes from what the camera sees: it is black, or in the dark as in a room whose windows are solid: make their panes clear (--clear), add a lamp (--point), or look elsewhere (--look)"
        )
    return Viewpoint(camera, tuple(notes))


def _choices(scene: Scene) -> Iterator[tuple[str, View]]:
    """Views and where they are, the best first."""
    tracer, up, shapes = scene.tracer, np.array(scene.up), outlines(scene.mi_shapes)
    near = near_shapes(shapes, SEEDS)
    reach = far_off(near)
    tried = candidates(tracer, near, up, reach)
    if (view := inside.best_view(tracer, scene.lights, tried, up, reach)) is not None:
        yield INDOORS, view
    yield "around it", around.best_view(tracer, scene.lights, without_backdrop(shapes, up), up)
    if (view := inside.best_view(tracer, scene.lights, tried, up, reach, fronts=0)) is not None:
        yield INDOORS, view


def pivot(scene: Scene, target: Sequence[float] | None = None) -> np.ndarray:
    """(3,) what the scene's first camera turns around [m]: itself if there are walls around it, else the target.

    Args:
        scene: What there is.
        target: (3,) [m]; by default the middle of all that is no ground and no dome.
    """
    up, shapes = np.array(scene.up), outlines(scene.mi_shapes)
    there, position = np.array(scene.origin), np.array(scene.camera.position, np.float64).ravel()
    here = survey(scene.tracer, (position - there)[None], up, far_off(near_shapes(shapes, SEEDS)))
    if here.walls[0] >= WALLS:
        return position
    if target is not None:
        return np.array(target, np.float64)
    body = without_backdrop(shapes, up)
    return there + 0.5 * (body.min(0) + body.max(0))
