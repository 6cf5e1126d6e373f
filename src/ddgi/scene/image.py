"""A picture that covers a surface, on its way from a texture plugin to the scene's texture buffer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import mitsuba as mi
import numpy as np
import numpy.typing as npt

from ddgi.luminance import LUMINANCE
from ddgi.trace.materials import NO_TEXTURE, Textures
from ddgi.trace.textures import CLAMP, MIRROR, REPEAT

WRAP = {"repeat": REPEAT, "clamp": CLAMP, "mirror": MIRROR}
HALF_MAX = 65504.0
IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


@dataclass(frozen=True, eq=False)
class Image:
    """Linear RGBA texels; the first row lies at v = 0."""

    texels: npt.NDArray[np.float16]  # (height, width, 4)
    wrap: int = REPEAT
    nearest: bool = False
    to_uv: tuple[Sequence[float], Sequence[float]] = IDENTITY  # two rows of three: u', v' from (u, v, 1)

    @classmethod
    def from_array(cls, values: np.ndarray, **keywords) -> Image:
        """From (H, W, C) linear values: C = 1 is grey; 2 grey and alpha; 3 RGB; 4 RGBA."""
        height, width, channels = values.shape
        texels = np.ones((height, width, 4), np.float16)
        texels[..., :3] = np.minimum(values[..., :1] if channels < 3 else values[..., :3], HALF_MAX)
        if channels in (2, 4):
            texels[..., 3] = values[..., -1]
        return cls(texels, **keywords)

    @cached_property
    def mean(self) -> npt.NDArray[np.float64]:
        """(3,) mean colour."""
        return self.texels[..., :3].mean((0, 1), dtype=np.float32).astype(np.float64)

    def tinted(self, color: npt.ArrayLike) -> Image:
        """Every texel times an RGB colour."""
        values = self.texels.astype(np.float32)
        values[..., :3] = np.minimum(values[..., :3] * np.asarray(color, np.float32), HALF_MAX)
        return replace(self, texels=values.astype(np.float16))

    def mapped(self, curve: Callable[[np.ndarray], np.ndarray]) -> Image:
        """Every channel of every texel through a function of arrays."""
        values = self.texels.astype(np.float32)
        values[..., :3] = np.minimum(curve(values[..., :3]), HALF_MAX)
        return replace(self, texels=values.astype(np.float16))

    def grey(self) -> Image:
        """Luminance in every channel."""
        values = self.texels.astype(np.float32)
        values[..., :3] = (values[..., :3] @ LUMINANCE)[..., None]
        return replace(self, texels=values.astype(np.float16))

    def laid_as(self, other: Image) -> bool:
        """Whether both cover a surface in the same way."""
        ours, theirs = ((i.wrap, i.nearest, tuple(map(tuple, i.to_uv))) for i in (self, other))
        return ours == theirs

    def clamped(self) -> Image:
        """Colours limited to [0, 1], as reflectances must be."""
        return replace(self, texels=np.clip(self.texels, 0, 1))


def beside(red: Image | float, green: Image | float) -> Image:
    """Two channels, pictures of one channel each or numbers, in one picture; they lie as the first picture does.

    The one with fewer texels is enlarged as a lookup would see it.
    """
    layout = next(value for value in (red, green) if isinstance(value, Image))
    channels = [
        value.texels[..., 0] if isinstance(value, Image) else np.full((1, 1), value) for value in (red, green)
    ]
    size = [max(pair) for pair in zip(*(values.shape for values in channels), strict=True)]
    texels = np.ones((*size, 4), np.float16)
    for number, values in enumerate(channels):
        for axis in (0, 1):
            values = _enlarged(values, axis, size[axis], layout)
        texels[..., number] = values
    return replace(layout, texels=texels)


def _enlarged(values: np.ndarray, axis: int, size: int, layout: Image) -> np.ndarray:
    """A channel with more texels along an axis, by the layout's filter and at its edges as its wrap mode has it."""
    count = values.shape[axis]
    if count == size:
        return values
    position = (np.arange(size) + 0.5) * count / size
    if layout.nearest:
        return values.take(position.astype(int), axis)
    first = np.floor(position - 0.5).astype(int)
    mode: Literal["wrap", "clip"] = "wrap" if layout.wrap == REPEAT else "clip"
    low, high = (values.take(first + k, axis, mode=mode).astype(np.float32) for k in (0, 1))
    share = np.expand_dims(position - 0.5 - first, 1 - axis)
    return low + share * (high - low)


class Pack:
    """Collects images and gives each its number; the same image is stored once."""

    def __init__(self) -> None:
        self._images: list[Image] = []
        self._numbers: dict[int, int] = {}

    def add(self, image: Image | None) -> int:
        """Number of an image; NO_TEXTURE for None."""
        if image is None:
            return NO_TEXTURE
        if id(image) not in self._numbers:
            self._numbers[id(image)] = len(self._images)
            self._images.append(image)
        return self._numbers[id(image)]

    def textures(self) -> Textures | None:
        """Everything in one buffer; None without any image. Images that share texels share them here too."""
        if not self._images:
            return None
        first: dict[int, int] = {}
        parts, size = [], 0
        for image in self._images:
            if id(image.texels) not in first:
                first[id(image.texels)] = size
                parts.append(image.texels.reshape(-1))
                size += image.texels.shape[0] * image.texels.shape[1]

        return Textures(
            texels=mi.Float16(np.concatenate(parts)),
            offset=mi.UInt32([first[id(i.texels)] for i in self._images]),
            width=mi.UInt32([i.texels.shape[1] for i in self._images]),
            height=mi.UInt32([i.texels.shape[0] for i in self._images]),
            wrap=mi.UInt32([i.wrap for i in self._images]),
            nearest=mi.Bool([i.nearest for i in self._images]),
            to_uv=mi.Float([x for i in self._images for row in i.to_uv for x in (*row, 0.0)]),
        )
