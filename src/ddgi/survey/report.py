"""A survey: what a scene holds, the volume it would have, and what will spoil its light."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from ddgi.scene.scene import Scene
from ddgi.settings import RenderSettings
from ddgi.survey.caveats import Caveat, caveats
from ddgi.survey.contents import Contents, contents
from ddgi.survey.faces import joined, met
from ddgi.survey.lamps import Lamp, lamps
from ddgi.survey.units import plausible_units
from ddgi.survey.views import View, view
from ddgi.survey.volume import Volume, fitted
from ddgi.survey.walls import Walls, walls


@dataclass(frozen=True)
class Survey:
    """What to know of a scene before it is rendered. Lengths are in metres, shares in [0, 1]."""

    scene: str
    contents: Contents
    lights: tuple[Lamp, ...]
    cameras: tuple[View, ...]
    units: tuple[str, ...]  # those in which the volume has a usual size, the likeliest first; a guess
    volume: Volume
    walls: Walls | None  # None where the cameras see nothing
    warnings: tuple[Caveat, ...]
    notes: tuple[str, ...]  # what the import changed or left out

    def figures(self) -> dict[str, Any]:
        """All of it as plain dictionaries, lists and numbers: docs/info.md explains each."""
        return asdict(self)


def survey(scene: Scene, settings: RenderSettings) -> Survey:
    """Look a scene over. The same scene and settings give the same survey.

    Raises:
        SettingsError: The volume is impossible, lies outside the scene or is too large.
    """
    pixels, *rest = met(scene)
    volume = fitted(scene, settings, blind=not (pixels.hit & ~pixels.black).any())
    cameras = tuple(view(camera, pixels.of_camera(n), volume) for n, camera in enumerate(scene.cameras))
    judged = walls(joined([pixels, *rest]), volume)
    lights = lamps(scene, volume)
    low, high = volume.box
    return Survey(
        scene=scene.name,
        contents=contents(scene),
        lights=lights,
        cameras=cameras,
        units=plausible_units(max(b - a for a, b in zip(low, high, strict=True))),
        volume=volume,
        walls=judged,
        warnings=caveats(volume, judged, lights, cameras[0], scene.notes),
        notes=scene.notes,
    )
