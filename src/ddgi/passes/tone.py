"""From radiance to a display: exposure, a filmic curve, sRGB."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from annotated_types import Interval
from typing_extensions import Doc

from ddgi.luminance import LUMINANCE
from ddgi.settings_group import settings_group

MIDDLE_GREY = 0.18
METERED = (50, 95)
MOST_STOPS = 14.0
"""Of automatic exposure: a night under the full moon needs 12 or so, and what needs more is black but for leaks and noise."""


@settings_group("tone")
class Settings:
    """How radiance becomes a picture for a display."""

    exposure: Annotated[
        Annotated[float, Interval(ge=-64, le=64)] | None,
        Doc(
            "fixed exposure in stops: radiance times 2^exposure; none: automatic, the log-mean becomes middle grey"
        ),
    ] = None
    curve: Annotated[
        Literal["filmic", "linear"], Doc("filmic rolls highlights off (Narkowicz 2015); linear clips them")
    ] = "filmic"


def automatic_exposure(radiance: np.ndarray) -> float:
    """Stops that bring the log-mean luminance of a picture to middle grey. radiance: (H, W, 3).

    Only the pixels between `METERED` percentiles count: neither black corners nor lamps and sunlit
    patches should decide how bright the rest is. `MOST_STOPS` at most.
    """
    luminance = np.nan_to_num(radiance @ LUMINANCE, posinf=0).ravel()
    low, high = np.percentile(luminance, METERED)
    seen = luminance[(luminance >= low) & (luminance <= high) & (luminance > 0)]
    if seen.size == 0:
        return 0.0
    return float(np.clip(np.log2(MIDDLE_GREY) - np.mean(np.log2(seen)), -64, MOST_STOPS))


def tone_map(radiance: np.ndarray, s: Settings) -> np.ndarray:
    """Display values in [0, 1], sRGB-encoded. radiance: (H, W, 3) linear Rec.709."""
    stops = automatic_exposure(radiance) if s.exposure is None else s.exposure
    x = np.maximum(np.nan_to_num(radiance * np.float32(2.0**stops), posinf=1e30), 0)
    if s.curve == "filmic":
        x = np.minimum(x, 1e4)
        x = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
    x = np.clip(x, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
