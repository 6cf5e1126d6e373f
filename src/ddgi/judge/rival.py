"""The rival: what a path tracer and a denoiser make of the same time.

`frame`: the time of one of our frames, against one frame of our converged field. `still`: the time
of all our frames, warm-up included, against the picture they add up to. The denoiser's time is
reported, not charged. What takes long to trace is kept beside the reference, for samples in steps, so
that the next comparison finds it.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np

from ddgi.errors import OutputError
from ddgi.judge.cache import Key, load, store
from ddgi.judge.denoiser import Guides, denoise
from ddgi.judge.metrics import Difference, difference
from ddgi.judge.path_tracer import PathTracer, Samples
from ddgi.scene.camera import Camera

TRIALS = 3
"""Renderings that are timed, after one that compiles."""
FEW, MANY = 1, 9
"""Samples per pixel of renderings that are timed: what a sample costs is their difference."""
MOST_SAMPLES = 4096
STEPS = 4
"""Numbers of samples that are kept, to a doubling."""


@dataclass(frozen=True)
class Rival:
    """A denoised path-traced picture, and how it fares."""

    picture: np.ndarray  # (H, W, 3)
    spp: int
    ms: float  # path tracing alone
    denoise_ms: float
    difference: Difference

    def figures(self) -> dict[str, Any]:
        """The numbers by name."""
        return {
            "spp": self.spp,
            "flip_mean": self.difference.flip_mean,
            "time_ms": self.ms,
            "denoise_ms": self.denoise_ms,
        }


def sample_ms(tracer: PathTracer, camera: Camera) -> float:
    """What one more sample per pixel takes [ms]: the rival is not charged for starting, which matters when small."""

    def taken(spp: int) -> float:
        tracer.render(camera, spp, 0)
        return median(tracer.render(camera, spp, trial).ms for trial in range(TRIALS))

    few, many = taken(FEW), taken(MANY)
    return max(many - few, 0.1 * many) / (MANY - FEW)


def rival(samples: Samples, guides: Guides, reference: np.ndarray) -> Rival:
    """Samples denoised, and held against the reference.

    Raises:
        DDGIError: The denoiser or FLIP is not installed.
    """
    noisy = np.maximum(np.nan_to_num(samples.picture, posinf=0.0), 0)
    clean, ms = denoise(noisy, guides)
    return Rival(clean, samples.spp, samples.ms, ms, difference(clean, reference))


def kept_samples(
    tracer: PathTracer, camera: Camera, spp: int, seed: int, sample_ms: float, key: Key
) -> Samples:
    """Samples from the cache if they are there; their time is then what they take now.

    Args:
        tracer: Makes them where they are not there.
        camera: The view.
        spp: How many a pixel.
        seed: Equal seeds give equal samples.
        sample_ms: What a sample takes [ms].
        key: Of the reference.
    """
    key = key.beside(f"rival-{spp}-{seed}")
    found = load(key, {"picture": (*key.shape, 3)})
    if found is not None:
        return Samples(found["picture"], spp, spp * sample_ms)
    samples = tracer.render(camera, spp, seed)
    with suppress(
        OutputError
    ):  # without a place for it, the next comparison takes longer, and this one does not
        if np.isfinite(samples.picture).all():
            store(key, {"picture": samples.picture})
    return samples


def samples_in(ms: float, sample_ms: float) -> int:
    """Samples per pixel that a path tracer finishes in a time: one at least."""
    return max(1, min(round(ms / sample_ms), MOST_SAMPLES))


def in_steps(spp: int) -> int:
    """The nearest of numbers of samples that lie a quarter of an octave apart: times scatter by as much."""
    return round(2 ** (round(STEPS * math.log2(spp)) / STEPS))
