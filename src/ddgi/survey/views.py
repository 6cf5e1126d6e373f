"""What the picture of each camera shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddgi.scene.camera import Camera
from ddgi.survey.faces import Faces
from ddgi.survey.volume import Volume


@dataclass(frozen=True)
class View:
    """A camera, and shares of its pixels in [0, 1]."""

    name: str
    size: tuple[int, int]  # (width, height) [pixels]
    empty: float  # nothing is there: the sky, or black
    behind: float  # a face from behind, whether its material has two sides or not
    black: float  # a face from behind whose material has one side
    outside: float  # a surface to be lit by probes, more than a cell outside the volume
    distance: float | None  # median to what is seen [m]; None where nothing is


def view(camera: Camera, pixels: Faces, volume: Volume) -> View:
    """What a camera sees, from what rays through its pixels met."""
    hit = pixels.hit
    return View(
        name=camera.name,
        size=camera.size,
        empty=float(1 - hit.mean()),
        behind=float((hit & pixels.behind).mean()),
        black=float((hit & pixels.black).mean()),
        outside=float((hit & pixels.matt & volume.outside(pixels.position)).mean()),
        distance=float(np.median(pixels.distance[hit])) if hit.any() else None,
    )
