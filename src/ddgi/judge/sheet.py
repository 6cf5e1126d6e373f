"""A comparison as one picture: the reference in the first row, a configuration in each further one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, zip_longest

import numpy as np

from ddgi.judge.compare import Comparison, Judged
from ddgi.judge.false_colour import BLUE_RED, INFERNO, coloured
from ddgi.judge.lettering import text_width, wrapped, written
from ddgi.judge.metrics import DARKEST, flip_exposures, flip_map
from ddgi.judge.table import doubted, reference_lines
from ddgi.luminance import LUMINANCE
from ddgi.passes import tone
from ddgi.plural import counted

CAPTION = 22
"""Height of the line of text above a picture [pixels]."""
GAP = 4
NARROWEST = 300
"""Pictures that are narrower are shown a whole number of times larger [pixels]."""
BACKGROUND, INK = 24, 230
LEGEND = (
    "FLIP error: from black, 0, through purple, red and orange to yellow, 1. "
    "Luminance: red is too bright, blue too dark; full colour at 50 %."
)


@dataclass(frozen=True)
class Tile:
    """A picture with a caption."""

    caption: str
    pixels: np.ndarray  # (H, W, 3) uint8


def sheet(found: Comparison) -> np.ndarray:
    """The whole comparison, (H, W, 3) uint8.

    Every row: picture, direct light, indirect light, FLIP error, signed relative error of luminance
    (full colour at 50 %; the dark counts less). In the reference's row the error is that between its
    halves, and the last place belongs to the rival of equal time. At the foot: what the colours mean,
    whether the reference is good enough, and what to know.

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
    return laid_out(
        [first, *(_row(found, j, shown) for j in found.judged)],
        [LEGEND, *reference_lines(found), *found.notes],
    )


def _map(shares: np.ndarray, codes: Sequence[str]) -> np.ndarray:
    return np.rint(coloured(shares, codes) * 255).astype(np.uint8)


def relative_excess(picture: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """(Y - Y_ref) / (Y_ref + mean(Y_ref) / 10), (H, W): positive where the picture is too bright."""
    ours, truth = picture @ LUMINANCE, reference @ LUMINANCE
    excess: np.ndarray = (ours - truth) / np.maximum(truth + 0.1 * truth.mean(), DARKEST)
    return excess


def _row(found: Comparison, j: Judged, shown: tone.Settings) -> list[Tile]:
    out, truth, flip = j.outcome, found.reference, j.difference.flip_mean
    excess = relative_excess(out.picture, truth.picture)
    return [
        Tile(f"{out.trial.name}, {counted(out.frames, 'frame')}", _display(out.picture, shown)),
        Tile("direct", _display(out.direct, shown)),
        Tile("indirect", _display(out.indirect, shown)),
        Tile(f"FLIP {flip:.4f}{doubted(flip, truth.noise)}", _map(j.difference.flip_map, INFERNO)),
        Tile(f"luminance {100 * j.difference.luminance_error:+.1f} %", _map(0.5 + excess, BLUE_RED)),
    ]


def _display(radiance: np.ndarray, shown: tone.Settings) -> np.ndarray:
    return np.rint(tone.tone_map(np.maximum(radiance, 0), shown) * 255).astype(np.uint8)


def laid_out(rows: list[list[Tile]], foot: Sequence[str]) -> np.ndarray:
    """Tiles in a grid, captions above, columns as wide as their widest caption; lines of text at the foot."""
    times = -(-NARROWEST // rows[0][0].pixels.shape[1])
    rows = [
        [replace(tile, pixels=tile.pixels.repeat(times, 0).repeat(times, 1)) for tile in row] for row in rows
    ]
    height, width, _ = rows[0][0].pixels.shape
    columns = [_column_width(column, width) for column in zip_longest(*rows)]
    lefts = list(accumulate((wide + GAP for wide in columns), initial=GAP))
    lines = [part for text in foot for part in wrapped(text, lefts[-1] - 2 * GAP)]
    cell = height + CAPTION + GAP
    page_size = cell * len(rows) + CAPTION * len(lines) + GAP, lefts[-1], 3
    page = np.full(page_size, BACKGROUND, np.uint8)
    captions = [(GAP + 2, cell * len(rows) + CAPTION * n + GAP + 3, line) for n, line in enumerate(lines)]
    for top, row in zip(range(GAP, cell * len(rows), cell), rows, strict=True):
        for left, tile in zip(lefts, row, strict=False):
            page[top + CAPTION : top + CAPTION + height, left : left + width] = tile.pixels
            captions.append((left + 2, top + 3, tile.caption))
    return written(page, captions, (INK, INK, INK))


def _column_width(tiles: Sequence[Tile | None], picture: int) -> int:
    """Of its pictures and captions [pixels]."""
    return max(picture, *(text_width(tile.caption) + 4 for tile in tiles if tile is not None))
