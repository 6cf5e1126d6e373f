"""The steps of an explanation as a picture: a bar of light for each, in its colour, beside the true one."""

from __future__ import annotations

import numpy as np

from ddgi.judge.explain import Explanation, luminance
from ddgi.judge.lettering import text_width, written

BAR, GAP, LONGEST = 22, 8, 420
"""Height of a bar, the space around it, and the length of the longest [pixels]."""
PAPER, INK, TRUTH = (24, 24, 24), (230, 230, 230), (255, 255, 255)


def bars(found: Explanation) -> np.ndarray:
    """Luminance of the irradiance, step by step, (H, W, 3) uint8; a line marks the reference."""
    steps = {name: (luminance(light), light) for name, light in found.steps.items()}
    truth = steps["path traced"][0]
    longest = max(max(y for y, _ in steps.values()), 1e-12)
    texts = [f"{name}: {y:.4g}{_apart(found.errors[name])}" for name, (y, _) in steps.items()]
    side = max(map(text_width, texts)) + 2 * GAP
    title = f"pixel {found.pixel[0]},{found.pixel[1]}: indirect irradiance [W/m^2]"
    top = BAR + 2 * GAP
    width = max(side + LONGEST + GAP, text_width(title) + 2 * GAP)
    picture = np.full((top + len(steps) * (BAR + GAP), width, 3), PAPER, np.uint8)
    for row, (y, light) in enumerate(steps.values()):
        start = top + row * (BAR + GAP)
        colour = np.clip(np.array(light) / max(*light, 1e-12), 0, 1) ** (1 / 2.2)
        picture[start : start + BAR, side : side + max(1, round(LONGEST * y / longest))] = colour * 220
    mark = side + min(round(LONGEST * truth / longest), LONGEST - 1)
    picture[top - GAP // 2 :, mark] = TRUTH
    lines = [(GAP, top + row * (BAR + GAP) + 4, text) for row, text in enumerate(texts)]
    return written(picture, [(GAP, GAP, title), *lines], INK)


def _apart(error: float | None) -> str:
    return "" if error is None else f" ({100 * error:+.1f} %)"
