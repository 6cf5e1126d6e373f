"""Open Image Denoise, the rival's best friend. An optional package."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from ddgi.errors import DDGIError

MISSING = (
    "the denoiser is not installed; get it with: pip install mitsuba-oidn (or pip install 'ddgi[judge]')"
)


@dataclass(frozen=True)
class Guides:
    """Noise-free pictures that show where edges are."""

    albedo: np.ndarray  # (H, W, 3) in [0, 1]
    normal: np.ndarray  # (H, W, 3) unit vectors, world space


def installed() -> bool:
    """Whether there is a denoiser."""
    try:
        import mitsuba_oidn  # noqa: F401
    except ImportError:
        return False
    return True


def denoise(picture: np.ndarray, guides: Guides) -> tuple[np.ndarray, float]:
    """The denoised picture (H, W, 3), and the time it took [ms].

    Raises:
        DDGIError: The denoiser is not installed.
    """
    try:
        import mitsuba_oidn
    except ImportError as error:
        raise DDGIError(MISSING) from error
    color, albedo, normal = (
        np.ascontiguousarray(x, np.float32) for x in (picture, guides.albedo, guides.normal)
    )
    start = perf_counter()
    clean = mitsuba_oidn.denoise(color, albedo=albedo, normal=normal, hdr=True, clean_aux=True)
    ms = (perf_counter() - start) * 1e3
    return np.maximum(np.nan_to_num(np.asarray(clean)), 0), ms
