"""The picture of docs/debug.md: every debugging view of `house`.

python benchmarks/debug_montage.py      # into docs/pictures/debug-house.png; a minute on two cores
"""

from __future__ import annotations

import numpy as np

from ddgi import load_scene  # isort: skip  # before Dr.Jit: it loads LLVM once

from ddgi.backend import use_backend
from ddgi.config import load_settings
from ddgi.debug.views import VIEWS, look
from ddgi.judge.lettering import written
from ddgi.output import save_display
from studies import PICTURES

SIZE, ROOM = (400, 225), (400, 310)
"""Of the pictures, and room for one with its legend."""
CAPTION, GAP = 20, 8
"""Height of a caption, and the space around pictures [pixels]."""


def fitted(picture: np.ndarray) -> np.ndarray:
    """As much of a picture, smaller by a whole factor, as there is room for."""
    width, height = ROOM
    times = max(1, -(-picture.shape[0] // height), -(-picture.shape[1] // width))
    rows, columns = (n // times * times for n in picture.shape[:2])
    small = picture[:rows, :columns].reshape(rows // times, times, columns // times, times, 3).mean((1, 3))
    out = np.zeros((height, width, 3), np.uint8)
    out[: small.shape[0], : small.shape[1]] = small[:height, :width]
    return out


def main() -> None:
    """Draw and write."""
    use_backend()
    scene = load_scene("house", camera="open", size=SIZE)
    seen = look(scene, load_settings("default", None, []), 32)
    width, height = ROOM[0] + GAP, ROOM[1] + GAP + CAPTION
    rows = -(-len(VIEWS) // 2)
    page = np.full((rows * height + GAP, 2 * width + GAP, 3), 24, np.uint8)
    captions = []
    for number, (name, view) in enumerate(VIEWS.items()):
        top, left = GAP + number // 2 * height, GAP + number % 2 * width
        captions.append((left, top, name))
        page[top + CAPTION : top + CAPTION + ROOM[1], left : left + ROOM[0]] = fitted(view(seen))
    save_display(PICTURES / "debug-house.png", written(page, captions, (230, 230, 230)))


if __name__ == "__main__":
    main()
