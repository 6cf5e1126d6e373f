"""Numbered pictures to a video. Needs PyAV, an optional package."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ddgi.errors import DDGIError, OutputError
from ddgi.whole_file import check_place, whole_file

ENDING = ".mp4"
MISSING = "videos need PyAV: pip install 'ddgi[video]', or name a picture, such as out.png, for numbered ones"
QUALITY = "18"
"""x264's constant rate factor: no loss that is seen."""


def check_video(path: Path) -> Path:
    """The file that a video would go to; called before rendering.

    Raises:
        DDGIError: PyAV is not installed.
        OutputError: No file can be written there.
    """
    if find_spec("av") is None:
        raise DDGIError(MISSING)
    return check_place(path)


def write_video(path: Path, pictures: Sequence[Path], fps: float) -> None:
    """Encode pictures as H.264, with sides made even by leaving out a row or column.

    Args:
        path: Where to; ends in `.mp4`.
        pictures: PNG files of one size, in order.
        fps: Pictures a second.

    Raises:
        OutputError: The video cannot be written, or a picture not read.
    """
    import av
    import mitsuba as mi

    with whole_file(path) as file, av.open(str(file), "w", format="mp4") as container:
        stream = None
        for picture in pictures:
            pixels = np.array(
                mi.Bitmap(str(picture)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8)
            )
            height, width = (n // 2 * 2 for n in pixels.shape[:2])
            if not (width and height):
                raise OutputError(f"{path}: a video needs pictures of 2 x 2 pixels at least")
            if stream is None:
                stream = container.add_stream("libx264", rate=Fraction(fps).limit_denominator(1001))
                stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
                stream.options = {"crf": QUALITY}
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels[:height, :width]), format="rgb24")
            container.mux(stream.encode(frame))
        if stream is not None:
            container.mux(stream.encode())
