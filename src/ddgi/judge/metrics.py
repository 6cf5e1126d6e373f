"""Numbers for the difference of two pictures. Undefined ones do not exist: black pictures have an answer too."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ddgi.errors import DDGIError
from ddgi.luminance import LUMINANCE
from ddgi.passes import tone

ACES = (0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14)
"""Tone curve x (a x + b) / (x (c x + d) + e) by which HDR-FLIP chooses its exposures."""
BRIGHT = 0.85
"""What the curve gives at both ends: the brightest, and the middle pixel (Andersson et al. 2021)."""
DARKEST = 1e-6
"""Stands for the luminance of a black reference, where something is divided by it [W/(m^2 sr)]."""
MOST_EXPOSURES = 24


@dataclass(frozen=True)
class Difference:
    """How a picture differs from its reference."""

    flip_mean: float
    flip_p99: float  # 99th percentile over pixels
    luminance_error: float  # (mean Y - mean Y_ref) / mean Y_ref
    rel_mse: float  # mean of (x - r)^2 / (r^2 + 0.01 mean(r)^2)
    mff_mean: float  # MFF 4.2: |difference| of display values, summed over RGB, 0 to 3: mean over pixels
    mff_max: float
    exposures: tuple[float, float, int]  # first and last of HDR-FLIP [stops], and how many
    flip_map: np.ndarray  # (H, W) in [0, 1]

    def figures(self) -> dict[str, Any]:
        """The numbers by name."""
        names = ("flip_mean", "flip_p99", "luminance_error", "rel_mse", "mff_mean", "mff_max")
        return {name: getattr(self, name) for name in names} | {"exposures": list(self.exposures)}


def difference(picture: np.ndarray, reference: np.ndarray) -> Difference:
    """All metrics of one picture.

    Args:
        picture: (H, W, 3) linear Rec.709 radiance.
        reference: Likewise; exposures are chosen from it alone.

    Raises:
        DDGIError: The shapes differ, a value is not a number, or FLIP is not installed.
    """
    check_pictures(picture, reference)
    exposures = flip_exposures(reference)
    errors = flip_map(picture, reference, exposures)
    shown = tone.Settings(exposure=tone.automatic_exposure(reference))
    apart = np.abs(tone.tone_map(picture, shown) - tone.tone_map(reference, shown)).sum(-1)
    return Difference(
        flip_mean=float(errors.mean()),
        flip_p99=float(np.percentile(errors, 99)),
        luminance_error=luminance_error(picture, reference),
        rel_mse=rel_mse(picture.astype(np.float64) - reference, reference),
        mff_mean=float(apart.mean()),
        mff_max=float(apart.max()),
        exposures=exposures,
        flip_map=errors,
    )


def check_pictures(picture: np.ndarray, reference: np.ndarray) -> None:
    """Refuse what cannot be compared.

    Raises:
        DDGIError: The shapes differ or are no pictures, or a value is not finite or is negative.
    """
    for name, array in (("picture", picture), ("reference", reference)):
        if array.ndim != 3 or array.shape[2] != 3 or array.size == 0:
            raise DDGIError(f"the {name} must be an array (height, width, 3), not {array.shape}")
        wrong = int((~np.isfinite(array) | (array < 0)).any(-1).sum())
        if wrong:
            raise DDGIError(f"the {name} holds {wrong} pixel(s) that are negative or not a number")
    if picture.shape != reference.shape:
        raise DDGIError(f"the picture is {picture.shape}, the reference {reference.shape}")


def luminance_error(picture: np.ndarray, reference: np.ndarray) -> float:
    """(mean Y - mean Y_ref) / mean Y_ref, by luminance of Rec.709."""
    ours, truth = (float((p.astype(np.float64) @ LUMINANCE).mean()) for p in (picture, reference))
    return (ours - truth) / max(truth, DARKEST)


def rel_mse(error: np.ndarray, reference: np.ndarray) -> float:
    """Mean of error^2 / (r^2 + 0.01 mean(r)^2). error, reference: (H, W, 3)."""
    r = reference.astype(np.float64)
    scale = max(0.01 * r.mean() ** 2, DARKEST**2)
    return float((error.astype(np.float64) ** 2 / (r**2 + scale)).mean())


def flip_exposures(reference: np.ndarray) -> tuple[float, float, int]:
    """First and last exposure of HDR-FLIP [stops], and how many: 2 at least.

    From the brightest and the middle luminance of the reference (Andersson et al. 2021), of the
    pixels that are not black: a view with black around it would else be exposed for the night. With
    a single exposure flip-evaluator answers 0 to anything.
    """
    luminance = reference.astype(np.float64) @ LUMINANCE
    lit = luminance[luminance > DARKEST]
    if lit.size == 0:
        return 0.0, 1.0, 2
    a, b, c, d, e = ACES
    qa, qb, qc = a - BRIGHT * c, b - BRIGHT * d, -BRIGHT * e
    bright = (-qb + np.sqrt(qb * qb - 4 * qa * qc)) / (2 * qa)
    start = float(np.log2(bright / lit.max()))
    stop = float(np.log2(bright / np.median(lit)))
    count = int(np.clip(np.ceil(stop - start), 2, MOST_EXPOSURES))
    return start, max(stop, start + 1e-3), count


def flip_map(picture: np.ndarray, reference: np.ndarray, exposures: tuple[float, float, int]) -> np.ndarray:
    """HDR-FLIP error of each pixel, (H, W) in [0, 1], at 67 pixels per degree.

    Raises:
        DDGIError: flip-evaluator is not installed.
    """
    first, last, count = exposures
    parameters = {"startExposure": first, "stopExposure": last, "numExposures": count}
    errors, _, _ = load_flip().evaluate(
        np.ascontiguousarray(reference, np.float32),
        np.ascontiguousarray(picture, np.float32),
        "HDR",
        applyMagma=False,
        computeMeanError=False,
        parameters=parameters,
    )
    return np.asarray(errors, np.float32).reshape(picture.shape[:2])


def load_flip() -> Any:
    """The module flip-evaluator.

    Raises:
        DDGIError: It is not installed.
    """
    try:
        import flip_evaluator
    except ImportError as error:
        raise DDGIError(
            "FLIP is not installed; get it with: pip install flip-evaluator (or pip install 'ddgi[judge]')"
        ) from error
    return flip_evaluator
