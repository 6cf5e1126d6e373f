"""A comparison as one picture: the reference in the first row, a configuration in each further one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ddgi.errors import DDGIError
from ddgi.judge.compare import Comparison, Judged
from ddgi.judge.false_colour import BLUE_RED, INFERNO, coloured
from ddgi.judge.metrics import DARKEST, flip_exposures, flip_map
from ddgi.luminance import LUMINANCE
from ddgi.passes import tone

CAPTION = 22
"""Height of the line of text above a picture [pixels]."""
GAP = 4
BACKGROUND, INK = 24, 230


@dataclass(frozen=True)
class Tile:
    """A picture with a caption."""

    caption: str
    pixels: np.ndarray  # (H, W, 3) uint8


def sheet(found: Comparison) -> np.ndarray:
    """The whole comparison, (H, W, 3) uint8.

    Every row: picture, direct light, indirect light, FLIP error, signed relative error of luminance
    (full colour at 50 %; the dark counts less). In the reference's row the error is that between its
    halves, and the last place belongs to the rival of equal time.

    Raises:
        DDGIError: Pillow is not installed.
    """
    truth = found.reference
    shown = tone.Settings(exposure=tone.automatic_exposure(truth.picture))
    noise = flip_map(truth.halves[0], truth.halves[1], flip_exposures(truth.picture))
    first = [
        Tile(f"reference, {truth.spp} spp", _display(truth.picture, shown)),
        Tile("direct", _display(truth.direct, shown)),
        Tile("indirect", _display(truth.indirect, shown)),
        Tile(f"FLIP of its halves {truth.noise:.4f}", _map(noise, INFERNO)),
    ]
    if "frame" in found.rivals:
        frame = found.rivals["frame"]
        caption = f"rival, {frame.spp} spp denoised: {frame.difference.flip_mean:.4f}"
        first.append(Tile(caption, _display(frame.picture, shown)))
    return _laid_out([first, *(_row(found, j, shown) for j in found.judged)])


def _map(shares: np.ndarray, codes: Sequence[str]) -> np.ndarray:
    return np.rint(coloured(shares, codes) * 255).astype(np.uint8)


def relative_excess(picture: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """(Y - Y_ref) / (Y_ref + mean(Y_ref) / 10), (H, W): positive where the picture is too bright."""
    ours, truth = picture @ LUMINANCE, reference @ LUMINANCE
    excess: np.ndarray = (ours - truth) / np.maximum(truth + 0.1 * truth.mean(), DARKEST)
    return excess


def _row(found: Comparison, j: Judged, shown: tone.Settings) -> list[Tile]:
    out, truth = j.outcome, found.reference
    excess = relative_excess(out.picture, truth.picture)
    return [
        Tile(f"{out.trial.name}, {out.frames} frames", _display(out.picture, shown)),
        Tile("direct", _display(out.direct, shown)),
        Tile("indirect", _display(out.indirect, shown)),
        Tile(f"FLIP {j.difference.flip_mean:.4f}", _map(j.difference.flip_map, INFERNO)),
        Tile(f"luminance {100 * j.difference.luminance_error:+.1f} %", _map(0.5 + excess, BLUE_RED)),
    ]


def _display(radiance: np.ndarray, shown: tone.Settings) -> np.ndarray:
    return np.rint(tone.tone_map(np.maximum(radiance, 0), shown) * 255).astype(np.uint8)


def _laid_out(rows: list[list[Tile]]) -> np.ndarray:
    """Tiles of one size in a grid, captions above."""
    height, width, _ = rows[0][0].pixels.shape
    cell_h, cell_w = height + CAPTION + GAP, width + GAP
    columns = max(map(len, rows))
    page = np.full((cell_h * len(rows) + GAP, cell_w * columns + GAP, 3), BACKGROUND, np.uint8)
    captions = []
    for y, row in enumerate(rows):
        for x, tile in enumerate(row):
            top, left = y * cell_h + GAP, x * cell_w + GAP
            page[top + CAPTION : top + CAPTION + height, left : left + width] = tile.pixels
            captions.append((left + 2, top + 3, tile.caption))
    return _written(page, captions)


def _written(page: np.ndarray, captions: list[tuple[int, int, str]]) -> np.ndarray:
    try:
        from PIL import Image, ImageDraw, ImageFont
    except ImportError as error:
        raise DDGIError(
            "Pillow is not installed; get it with: pip install pillow (or pip install 'ddgi[judge]')"
        ) from error
    image = Image.fromarray(page)
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(size=13)
    for left, top, text in captions:
        draw.text((left, top), text, fill=(INK, INK, INK), font=font)
    drawn: Any = np.asarray(image)
    return np.array(drawn)
