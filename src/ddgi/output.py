"""Pictures to files: PNG for the eye, EXR with named layers for work."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ddgi import __version__
from ddgi.backend import use_backend
from ddgi.errors import OutputError
from ddgi.frame import Frame
from ddgi.passes import tone as tones
from ddgi.whole_file import check_place, whole_file

if TYPE_CHECKING:
    import mitsuba as mi

KNOWN = (".png", ".exr")
COMPONENTS = {1: ("Z",), 3: ("R", "G", "B")}
"""What the channels of a layer are called, by their number."""
AXES = ("X", "Y", "Z")


def save(path: str | os.PathLike[str], what: Frame | Any, tone: tones.Settings | None = None) -> None:
    """Write a picture.

    Args:
        path: Ends in `.png` (for a display: exposure, tone curve, sRGB) or `.exr` (radiance as it
            is, 32 bit, with the frame's layers as `direct.R`, `normal.X`, `depth.Z`, ...).
        what: A frame, or an array (H, W, 3) of linear Rec.709 radiance.
        tone: How radiance becomes a PNG; by default automatic exposure and a filmic curve.

    Raises:
        OutputError: The ending is unknown, the array is no picture, or the file cannot be written.
    """
    target = check_writable(path)
    use_backend()
    image, layers = _content(what)
    if target.suffix.lower() == ".png":
        bitmap = display_bitmap(image, tone or tones.Settings())
    else:
        bitmap = layered_bitmap(image, layers)
    _write(bitmap, target)


def save_display(path: str | os.PathLike[str], pixels: np.ndarray) -> None:
    """Write display values as they are to a `.png`. pixels: (H, W, 3) uint8.

    Raises:
        OutputError: The ending is another, or the file cannot be written.
    """
    import mitsuba as mi

    _write(mi.Bitmap(np.ascontiguousarray(pixels)), check_display(path))


def check_display(path: str | os.PathLike[str]) -> Path:
    """The `.png` that display values would go to.

    Raises:
        OutputError: The ending is another, or no file can be written there; says why.
    """
    if Path(path).suffix.lower() != ".png":
        raise OutputError(f"{path}: this picture holds display values, choose a name that ends in .png")
    return check_writable(path)


def check_writable(path: str | os.PathLike[str]) -> Path:
    """The file that a picture would go to; called before rendering, so that no time is wasted.

    Raises:
        OutputError: The ending is unknown, or no file can be written there; says why.
    """
    suffix = Path(path).suffix
    if suffix.lower() not in KNOWN and not Path(path).is_dir():
        raise OutputError(f"{path}: unknown kind of picture {suffix!r}, choose {' or '.join(KNOWN)}")
    return check_place(path)


def _content(what: Any) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Image (H, W, 3) and layers (H, W, channels) as float32."""
    layers: Mapping[str, Any] = {}
    if isinstance(what, Frame):
        what, layers = what.image, what.layers
    try:
        image = np.asarray(what, np.float32)
    except (TypeError, ValueError) as error:
        raise OutputError("a picture must be a frame or an array (height, width, 3)") from error
    if image.ndim != 3 or image.shape[2] != 3 or image.size == 0:
        raise OutputError(f"a picture must be an array (height, width, 3), not {image.shape}")
    return image, {name: np.asarray(layer, np.float32) for name, layer in layers.items()}


def display_bitmap(image: np.ndarray, tone: tones.Settings) -> mi.Bitmap:
    """Eight bits a channel, sRGB. image: (H, W, 3) radiance."""
    import mitsuba as mi

    display = np.rint(tones.tone_map(image, tone) * 255).astype(np.uint8)
    return mi.Bitmap(np.ascontiguousarray(display))


def layered_bitmap(image: np.ndarray, layers: Mapping[str, np.ndarray]) -> mi.Bitmap:
    """The image as R, G, B and every layer as `name.R`, ... image: (H, W, 3)."""
    import mitsuba as mi

    names, planes = list(COMPONENTS[3]), [image]
    for name, layer in layers.items():
        components = AXES if name == "normal" else COMPONENTS[layer.shape[2]]
        names += [f"{name}.{c}" for c in components]
        planes.append(layer)
    bitmap = mi.Bitmap(
        np.ascontiguousarray(np.concatenate(planes, axis=2)), mi.Bitmap.PixelFormat.MultiChannel, names
    )
    bitmap.metadata()["software"] = f"ddgi {__version__}"
    return bitmap


def _write(bitmap: mi.Bitmap, target: Path) -> None:
    import mitsuba as mi

    formats = {".png": mi.Bitmap.FileFormat.PNG, ".exr": mi.Bitmap.FileFormat.OpenEXR}
    with whole_file(target) as file:
        bitmap.write(str(file), formats[target.suffix.lower()])
