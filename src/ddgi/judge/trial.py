"""One configuration put to the test: rendered until its light is steady, with the time it took."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ddgi.frame import Frame, render_frame
from ddgi.judge.leak import leaked
from ddgi.judge.watch import NOBODY, Watch
from ddgi.probes.volume import bytes_per_probe
from ddgi.scene.scene import Scene
from ddgi.settings import RenderSettings
from ddgi.still import still
from ddgi.survey.reach import remark


@dataclass(frozen=True)
class Trial:
    """A configuration and its name."""

    name: str
    settings: RenderSettings


@dataclass(frozen=True)
class Outcome:
    """What a trial rendered. Pictures are (H, W, 3) radiance [W/(m^2 sr)]."""

    trial: Trial
    picture: np.ndarray  # the mean of all frames
    direct: np.ndarray  # its part from emission and direct light
    indirect: np.ndarray  # its part from the field
    single: np.ndarray  # one frame of the converged field by itself
    leaked: np.ndarray  # (H, W) irradiance that pixels take from probes hidden from them [W/m^2]
    frames: int
    frame_ms: float  # median of the second half
    probes: int
    non_finite: int  # rays and pixel values that were not numbers
    remark: str | None = None  # that probes light next to nothing, if so

    def figures(self) -> dict[str, Any]:
        """Cost by name."""
        per_probe = bytes_per_probe(self.trial.settings.volume)
        return {
            "frames": self.frames,
            "frame_ms": self.frame_ms,
            "probes": self.probes,
            "bytes_per_probe": per_probe,
            "field_mb": self.probes * per_probe / 1e6,
            "non_finite": self.non_finite,
        }


def run(scene: Scene, trial: Trial, frames: int, watch: Watch = NOBODY) -> Outcome:
    """Render `frames` frames of the scene's camera, then one more that nothing is averaged with.

    Args:
        scene: What there is.
        trial: The configuration.
        frames: At least one.
        watch: Told of every frame.

    Raises:
        SettingsError: The configuration's volume is impossible.
    """
    settings = replace(trial.settings, picture=replace(trial.settings.picture, layers=False))
    done = still(scene, settings, frames, watch.step)
    field, frame = done.field, done.frame
    _, alone = render_frame(scene, field, scene.camera, frames, settings)
    return Outcome(
        trial,
        frame.numpy(),
        _array(frame, frame.picture.immediate),
        np.maximum(_array(frame, frame.picture.indirect), 0),
        alone.numpy(),
        leaked(scene, field, settings),
        frames,
        done.frame_ms,
        field.probes,
        int(field.non_finite[0]) + frame.non_finite,
        remark(scene, field, settings),
    )


def _array(frame: Frame, lanes: Any) -> np.ndarray:
    width, height = frame.size
    return np.array(lanes, np.float32).T.reshape(height, width, 3)
