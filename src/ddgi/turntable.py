"""Pictures all around: a still scene seen by a camera that turns, lit by a field that converges once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from ddgi.frame import Frame, render_view
from ddgi.probes.field import IrradianceField
from ddgi.scene.camera import Camera, turned
from ddgi.scene.scene import Scene
from ddgi.scene.viewpoint import pivot
from ddgi.settings import RenderSettings
from ddgi.still import Still, still

FITTED = 8
"""Views, spread over all, that the probes are laid out for."""


def views(scene: Scene, count: int, look: Sequence[float] | None = None) -> list[Camera]:
    """Cameras on a circle around the scene's up, the first of them the scene's own, anticlockwise from above.

    Args:
        scene: What there is.
        count: How many.
        look: From and to, six numbers [m], where that is how the scene's camera came about.

    A camera with walls around it turns on the spot; another one goes around what `look` looks at, else
    around the middle of the object.
    """
    center = pivot(scene, None if look is None else look[3:])
    turn = 360 / count
    return [scene.camera, *(turned(scene.camera, center, scene.up, turn * n) for n in range(1, count))]


def turntable(
    scene: Scene, s: RenderSettings, frames: int, cameras: Sequence[Camera], step: Callable[[], object]
) -> Iterator[Still]:
    """Render a scene through one camera after another.

    The field converges during the frames of the first, which is the scene's own, and then stays.

    Args:
        scene: What there is.
        s: All settings.
        frames: Of each camera, at least one.
        cameras: At least one.
        step: Called after each frame.

    Raises:
        SettingsError: The field cannot be laid out.
    """
    around = cameras[1 :: max(len(cameras) // FITTED, 1)]
    field = IrradianceField.fit(replace(scene, cameras=(*scene.cameras, *around)), s)
    first = still(scene, s, frames, step, field)
    yield first
    for camera in cameras[1:]:
        frame = Frame.empty(camera, s)
        for tick in range(frames):
            frame = render_view(scene, first.field, camera, tick, s, frame)
            step()
        yield replace(first, frame=frame)
