"""What a camera looks at: guides for a denoiser, and whether the view makes sense at all."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.judge.denoiser import Guides
from ddgi.passes import gbuffer
from ddgi.sampling import clock
from ddgi.scene.scene import Scene

SAMPLES = 16
"""Samples per pixel of the guides."""


@dataclass(frozen=True)
class View:
    """A camera's view of a scene."""

    guides: Guides
    behind: float  # share of the pixels that see a surface from behind
    empty: float  # share that see nothing


def look(scene: Scene) -> View:
    """What the scene's camera sees."""
    width, height = scene.camera.size
    albedo, normal = np.zeros((3, width * height)), np.zeros((3, width * height))
    behind = empty = 0.0
    for tick in range(SAMPLES):
        seen = gbuffer.gbuffer(scene.tracer, scene.camera, clock(0, tick), gbuffer.Settings())
        albedo += np.array(dr.select(seen.valid, mi.Color3f(seen.albedo), mi.Color3f(1)))
        normal += np.array(dr.select(seen.valid, mi.Vector3f(seen.normal), mi.Vector3f(0)))
        behind += float(dr.mean(dr.select(seen.back, 1.0, 0.0))[0])
        empty += float(dr.mean(dr.select(seen.valid, 0.0, 1.0))[0])
    picture = lambda lanes: (lanes / SAMPLES).T.reshape(height, width, 3).astype(np.float32)  # noqa: E731
    return View(Guides(picture(albedo), picture(normal)), behind / SAMPLES, empty / SAMPLES)


def remarks(view: View) -> list[str]:
    """What is odd about a view, a line each."""
    lines = []
    if view.behind > 0.25:
        lines.append(
            f"{100 * view.behind:.0f} % of the picture shows surfaces from behind: "
            "does the camera stand inside a wall?"
        )
    if view.empty == 1:
        lines.append("the camera sees nothing of the scene")
    elif view.empty > 0.1:
        lines.append(
            f"{100 * view.empty:.0f} % of the picture is empty and hardly ever wrong: mean FLIP is the lower for it"
        )
    return lines
