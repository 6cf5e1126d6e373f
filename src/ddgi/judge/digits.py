"""Numbers as small bitmaps, three pixels wide and five high, for pictures that must do without fonts."""

from __future__ import annotations

import numpy as np

HEIGHT = 5
SHAPES = {
    "0": "### #.# #.# #.# ###",
    "1": ".#. ##. .#. .#. ###",
    "2": "### ..# ### #.. ###",
    "3": "### ..# ### ..# ###",
    "4": "#.# #.# ### ..# ..#",
    "5": "### #.. ### ..# ###",
    "6": "### #.. ### #.# ###",
    "7": "### ..# ..# ..# ..#",
    "8": "### #.# ### #.# ###",
    "9": "### #.# ### ..# ###",
    ".": ". . . . #",
    "-": "... ... ### ... ...",
    "e": "... ### ##. #.. ###",
    "+": "... .#. ### .#. ...",
}
"""Rows from the top."""


def bitmap(number: float, scale: int = 1) -> np.ndarray:
    """The number, (5 scale, W) bool: true where there is ink."""
    letters = [_letter(letter) for letter in f"{number:g}"]
    gap = np.zeros((HEIGHT, 1), bool)
    parts = [part for letter in letters for part in (letter, gap)][:-1]
    return np.kron(np.concatenate(parts, 1), np.ones((scale, scale), bool))


def _letter(letter: str) -> np.ndarray:
    return np.array([[pixel == "#" for pixel in row] for row in SHAPES[letter].split()])
