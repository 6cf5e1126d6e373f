"""Flicker: how much a still picture changes from frame to frame (MFF 4.6).

Nothing moves, neither does the sample within a pixel, and direct light is held at its mean; so all
that changes is the field's light. Of the display's values, tone-mapped with one exposure, the absolute
change between consecutive frames is summed over the three channels.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ddgi.frame import Frame, render_frame
from ddgi.judge.watch import NOBODY, Watch
from ddgi.passes import tone
from ddgi.probes.field import IrradianceField

if TYPE_CHECKING:
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings

WARM_UP, FRAMES = 200, 50
"""Frames before anything counts, and frames whose changes count (MFF: "fifty frames")."""


@dataclass(frozen=True)
class Flicker:
    """How a still picture flickers. Display values are in [0, 1], so a change is at most 3."""

    change: np.ndarray  # (H, W) mean over time of the absolute change, channels summed
    exposure: float  # of all frames [stops]
    hysteresis: float  # of the settings it was measured with; 0.97 in MFF's definition
    frames: int
    warm_up: int

    @property
    def mean(self) -> float:
        """Mean over pixels and pairs of frames."""
        return float(self.change.mean())

    @property
    def worst(self) -> float:
        """The mean over time where it is largest."""
        return float(self.change.max())

    def figures(self) -> dict[str, Any]:
        """By name, as `docs/results.md` explains them."""
        return {
            "flicker_mean": self.mean,
            "flicker_max": self.worst,
            "frames": self.frames,
            "warm_up": self.warm_up,
            "hysteresis": self.hysteresis,
            "exposure": self.exposure,
        }


def flicker(
    scene: Scene, s: RenderSettings, *, warm_up: int = WARM_UP, frames: int = FRAMES, watch: Watch = NOBODY
) -> Flicker:
    """Measure how the picture of a scene's first camera flickers.

    Args:
        scene: What to look at.
        s: Settings of the field, hysteresis included: 0.97 in every preset. Jitter is switched off.
            `tone.exposure` None: the exposure of the mean picture of the warm-up.
        warm_up: Frames before, 1 or more; direct light is held at their mean.
        frames: Frames to compare, 2 or more.
        watch: Told how far it is.

    Raises:
        SettingsError: The field cannot be laid out.
    """
    s = replace(s, gbuffer=replace(s.gbuffer, antialias=False))
    watch.phase(f"flicker of {scene.name}", warm_up + frames)
    field, settled = _settled(scene, s, warm_up, watch)
    shown = settled.numpy()
    exposure = tone.automatic_exposure(shown) if s.tone.exposure is None else s.tone.exposure
    fixed = replace(s.tone, exposure=exposure)
    direct = _pixels(settled, settled.picture.immediate)

    def displayed() -> Iterator[np.ndarray]:
        now = field
        for tick in range(warm_up, warm_up + frames):
            now, frame = render_frame(scene, now, scene.camera, tick, s)
            watch.step()
            yield tone.tone_map(direct + _pixels(frame, frame.picture.indirect), fixed)

    return Flicker(mean_change(displayed()), exposure, s.blend.hysteresis, frames, warm_up)


def mean_change(pictures: Iterable[np.ndarray]) -> np.ndarray:
    """Mean over consecutive pictures of the absolute change, channels summed.

    Args:
        pictures: At least two, (H, W, 3) each, display values in [0, 1].

    Returns:
        (H, W), 0 to 3.
    """
    changes = [np.abs(after - before).sum(axis=2) for before, after in pairwise(pictures)]
    return np.asarray(np.mean(changes, axis=0, dtype=np.float64))


def _settled(scene: Scene, s: RenderSettings, frames: int, watch: Watch) -> tuple[IrradianceField, Frame]:
    """The field after the warm-up, and the mean picture of it."""
    field, frame = render_frame(scene, IrradianceField.fit(scene, s), scene.camera, 0, s)
    watch.step()
    for tick in range(1, frames):
        field, frame = render_frame(scene, field, scene.camera, tick, s, frame)
        watch.step()
    return field, frame


def _pixels(frame: Frame, light: Any) -> np.ndarray:
    """(H, W, 3) of light by pixel."""
    width, height = frame.size
    return np.array(light).T.reshape(height, width, 3)
