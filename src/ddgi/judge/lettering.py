"""Text in pictures. Needs Pillow, an optional package."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from ddgi.errors import DDGIError

SIZE = 13
"""Of letters [pixels]."""


def written(
    picture: np.ndarray, texts: Iterable[tuple[int, int, str]], ink: tuple[int, int, int]
) -> np.ndarray:
    """The picture with texts in it.

    Args:
        picture: (H, W, 3) uint8.
        texts: Left and top edge [pixels], and the text.
        ink: Its colour.

    Raises:
        DDGIError: Pillow is not installed.
    """
    pillow = _pillow()
    image = pillow.Image.fromarray(picture)
    draw, font = pillow.ImageDraw.Draw(image), pillow.ImageFont.load_default(size=SIZE)
    for left, top, text in texts:
        draw.text((left, top), text, fill=ink, font=font)
    drawn: Any = np.asarray(image)
    return np.array(drawn)


def text_width(text: str) -> int:
    """Of a line [pixels].

    Raises:
        DDGIError: Pillow is not installed.
    """
    return int(np.ceil(_pillow().ImageFont.load_default(size=SIZE).getlength(text)))


def wrapped(text: str, width: int) -> Iterator[str]:
    """Lines of whole words no wider than `width` [pixels], but for a single word that is.

    Raises:
        DDGIError: Pillow is not installed.
    """
    line = ""
    for word in text.split():
        longer = f"{line} {word}".strip()
        if line and text_width(longer) > width:
            yield line
            line = word
        else:
            line = longer
    yield line


def _pillow() -> Any:
    try:
        import PIL.Image
        import PIL.ImageDraw
        import PIL.ImageFont
    except ImportError as error:
        raise DDGIError(
            "Pillow is not installed; get it with: pip install pillow (or pip install 'ddgi[judge]')"
        ) from error
    return PIL
