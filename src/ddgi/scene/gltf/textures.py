"""Textures: what a material reads from a picture, as Mitsuba's `bitmap` plugins; each made once.

Texture coordinates stay as the file has them: for glTF as for Mitsuba's bitmaps v = 0 is a picture's
first row. Factors are multiplied into the texels.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.scene.gltf.images import Images
from ddgi.scene.gltf.schema import Document, TextureInfo, TextureTransform
from ddgi.scene.image import HALF_MAX
from ddgi.scene.notes import Notes
from ddgi.scene.textures import srgb_to_linear

REPEAT, CLAMP, MIRROR = 10497, 33071, 33648
WRAP = {REPEAT: "repeat", CLAMP: "clamp", MIRROR: "mirror"}
NEAREST = 9728
Described = dict[str, Any]
Filter = Callable[[np.ndarray], tuple[np.ndarray, bool]]
"""From (H, W, 4) stored texels to those of a bitmap, and whether these are linear."""


@dataclass(frozen=True)
class Sampling:
    """How a texture is read. Two rows of a transform from (u, v, 1), and modes for both directions."""

    to_uv: tuple[tuple[float, float, float], tuple[float, float, float]]
    wrap: tuple[int, int]
    nearest: bool


class Textures:
    """Makes the texture plugins of a file."""

    def __init__(self, document: Document, images: Images, notes: Notes) -> None:
        self._document = document
        self._images = images
        self._notes = notes
        self._names: dict[Any, str] = {}
        self._bitmaps: dict[Any, tuple[mi.Bitmap, bool]] = {}
        self.plugins: dict[str, Described] = {}  # as inside a scene dictionary

    def has_picture(self, info: TextureInfo | None) -> bool:
        """Whether a use of a texture shows one; a note says if it should but cannot."""
        if info is None:
            return False
        if self._document.textures[info.index].source is None:
            self._notes.add("a texture without a PNG or JPEG picture is left out")
            return False
        return True

    def mean(self, info: TextureInfo, filtered: Filter) -> np.ndarray:
        """(3,) mean of what a use of a texture would show, linear."""
        texels, linear = filtered(self._texels(info))
        values = texels.reshape(-1, texels.shape[2])
        if not linear:
            return _linear(values)[:, :3].mean(0)
        scale = np.iinfo(values.dtype).max if values.dtype.kind == "u" else 1.0
        return np.resize(values.mean(0, dtype=np.float64) / scale, 3)

    def shown(self, info: TextureInfo, filter_name: str, filtered: Filter) -> Described:
        """Reference to the plugin for a use of a texture.

        Args:
            info: The use.
            filter_name: Names what `filtered` does, all its numbers included.
            filtered: What to read from the picture.
        """
        texture = self._document.textures[info.index]
        sampling = self._sampling(info)
        key = (texture.source, filter_name, sampling)
        if key not in self._names:
            self._names[key] = name = f"_texture-{len(self._names)}"
            self.plugins[name] = self._plugin(info, filter_name, filtered, sampling)
        return {"type": "ref", "id": self._names[key]}

    def opaque(self, info: TextureInfo) -> bool:
        """Whether the picture's alpha is one everywhere."""
        alpha = self._texels(info)[..., 3]
        return bool((alpha == np.iinfo(alpha.dtype).max).all())

    def _texels(self, info: TextureInfo) -> np.ndarray:
        source = self._document.textures[info.index].source
        assert source is not None
        return self._images.texels(source)

    def _plugin(self, info: TextureInfo, filter_name: str, filtered: Filter, sampling: Sampling) -> Described:
        source = self._document.textures[info.index].source
        tiles, wrap, to_uv = _one_wrap_mode(sampling)
        key = (source, filter_name, tiles)
        if key not in self._bitmaps:
            texels, linear = filtered(self._texels(info))
            tiled = np.ascontiguousarray(_tiled(texels, tiles))
            self._bitmaps[key] = mi.Bitmap(tiled), linear
        bitmap, linear = self._bitmaps[key]
        return {
            "type": "bitmap",
            "bitmap": bitmap,
            "raw": linear,
            "wrap_mode": WRAP[wrap],
            "filter_type": "nearest" if sampling.nearest else "bilinear",
            "to_uv": mi.ScalarTransform3f([list(row) for row in to_uv] + [[0.0, 0.0, 1.0]]),
        }

    def _sampling(self, info: TextureInfo) -> Sampling:
        number = self._document.textures[info.index].sampler
        transform = info.extensions.transform or TextureTransform()
        if number is None:
            return Sampling(matrix(transform), (REPEAT, REPEAT), False)
        sampler = self._document.samplers[number]
        wrap = sampler.wrap_s, sampler.wrap_t
        return Sampling(matrix(transform), wrap, sampler.mag_filter == NEAREST)


def matrix(transform: TextureTransform) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Two rows from (u, v, 1): scaled, then turned (counter-clockwise to the eye, as v runs down), then moved."""
    c, s = float(np.cos(transform.rotation)), float(np.sin(transform.rotation))
    (x, y), (across, down) = transform.offset, transform.scale
    return (c * across, s * down, x), (-s * across, c * down, y)


def _one_wrap_mode(
    sampling: Sampling,
) -> tuple[tuple[str, str], int, tuple[Sequence[float], Sequence[float]]]:
    """Mitsuba wraps both directions alike: where a file does not, the picture is tiled to make up for it.

    Returns:
        What to do with the picture along u and v ("", "pad" with its edge, or "mirror"); the mode for
        both directions; and the transform to the tiled picture's coordinates. Padding reaches one
        picture's width beyond each edge.
    """
    across, down = sampling.wrap
    if across == down:
        return ("", ""), across, sampling.to_uv
    tiles = {CLAMP: "pad", MIRROR: "mirror", REPEAT: ""}
    if CLAMP not in (across, down):
        wrap, tiling = REPEAT, (tiles[across], tiles[down])
    else:
        wrap = down if across == CLAMP else across
        tiling = ("pad", "") if across == CLAMP else ("", "pad")
    rows = [_tiled_row(row, tile) for row, tile in zip(sampling.to_uv, tiling, strict=True)]
    return (tiling[0], tiling[1]), wrap, (rows[0], rows[1])


def _tiled_row(row: Sequence[float], tile: str) -> Sequence[float]:
    copies, before = {"": (1, 0), "mirror": (2, 0), "pad": (3, 1)}[tile]
    a, b, c = row
    return a / copies, b / copies, (c + before) / copies


def _tiled(texels: np.ndarray, tiles: tuple[str, str]) -> np.ndarray:
    for axis, tile in ((1, tiles[0]), (0, tiles[1])):
        if tile == "mirror":
            texels = np.concatenate([texels, np.flip(texels, axis)], axis)
        elif tile == "pad":
            width = [(0, 0)] * texels.ndim
            width[axis] = (texels.shape[axis], texels.shape[axis])
            texels = np.pad(texels, width, "edge")
    return texels


# What is read from a picture ----------------------------------------------------------------------------


def color(factor: Sequence[float]) -> tuple[str, Filter]:
    """RGB, stored in sRGB, times a linear factor."""

    def filtered(texels: np.ndarray) -> tuple[np.ndarray, bool]:
        rgb = texels[..., :3]
        if rgb.dtype == np.uint8 and all(f == 1 for f in factor):
            return rgb, False
        return np.minimum(_linear(rgb) * np.asarray(factor), HALF_MAX).astype(np.float16), True

    return f"color {list(factor)}", filtered


def channel(number: int, factor: float) -> tuple[str, Filter]:
    """One linear channel times a factor."""

    def filtered(texels: np.ndarray) -> tuple[np.ndarray, bool]:
        return (_fractions(texels[..., number : number + 1]) * factor).astype(np.float16), True

    return f"channel {number} {factor}", filtered


def opacity(factor: float, cutoff: float | None) -> tuple[str, Filter]:
    """Alpha times a factor; with a cutoff, 1 from there on and 0 below."""

    def filtered(texels: np.ndarray) -> tuple[np.ndarray, bool]:
        alpha = _fractions(texels[..., 3:]) * factor
        return (alpha if cutoff is None else alpha >= cutoff).astype(np.float16), True

    return f"opacity {factor} {cutoff}", filtered


def normals(scale: float, mirrored: bool = False) -> tuple[str, Filter]:
    """A normal map whose slopes are multiplied by a factor; mirrored, those along green are turned around."""

    def filtered(texels: np.ndarray) -> tuple[np.ndarray, bool]:
        normal = 2 * _fractions(texels[..., :3]) - 1
        normal *= np.array([scale, -scale if mirrored else scale, 1], np.float32)
        length = np.linalg.norm(normal, axis=-1, keepdims=True)
        normal /= np.maximum(length, 1)  # steep ones would not fit into a picture
        return (0.5 * normal + 0.5).astype(np.float32), True

    return f"normals {scale} {mirrored}", filtered


def _fractions(values: np.ndarray) -> np.ndarray:
    return values / np.float32(np.iinfo(values.dtype).max)


def _linear(values: np.ndarray) -> np.ndarray:
    """Linear from sRGB as stored."""
    if values.dtype == np.uint8:
        return srgb_to_linear(np.arange(256) / 255).astype(np.float32)[values]
    return srgb_to_linear(_fractions(values)).astype(np.float32)
