"""A still picture: frames of one view added up, and how long each took."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import perf_counter

import drjit as dr

from ddgi.frame import Frame, render_frame
from ddgi.probes.field import IrradianceField
from ddgi.scene.scene import Scene
from ddgi.settings import RenderSettings


@dataclass(frozen=True)
class Still:
    """What some frames came to."""

    field: IrradianceField
    frame: Frame  # the mean of all
    milliseconds: list[float]  # of each frame

    @property
    def frame_ms(self) -> float:
        """Median time of the second half of the frames: the first ones compile [ms]."""
        return median(self.milliseconds[len(self.milliseconds) // 2 :])


def still(
    scene: Scene,
    s: RenderSettings,
    frames: int,
    step: Callable[[], object],
    field: IrradianceField | None = None,
) -> Still:
    """Render frames of a scene's first camera, with a field that starts from nothing.

    Args:
        scene: What there is.
        s: All settings.
        frames: At least one.
        step: Called after each.
        field: Where to start instead.

    Raises:
        SettingsError: The field cannot be laid out.
    """
    field = IrradianceField.fit(scene, s) if field is None else field
    frame = Frame.empty(scene.camera, s)
    milliseconds = []
    for tick in range(frames):
        start = perf_counter()
        field, frame = render_frame(scene, field, scene.camera, tick, s, frame)
        dr.sync_thread()
        milliseconds.append((perf_counter() - start) * 1e3)
        step()
    return Still(field, frame, milliseconds)
