"""Pictures: PNG and JPEG out of files, buffer views and data URIs, as RGBA texels."""

from __future__ import annotations

import struct

import mitsuba as mi
import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf.buffers import Views
from ddgi.scene.gltf.document import Container
from ddgi.scene.gltf.uris import read_uri
from ddgi.scene.jpeg import END, heard
from ddgi.scene.jpeg import SIGNATURE as JPEG
from ddgi.scene.notes import Notes

PNG = b"\x89PNG\r\n\x1a\n"
OTHERS = {b"\xabKTX 20": "KTX2", b"RIFF": "WebP", b"DDS ": "DDS", b"GIF8": "GIF", b"BM": "BMP"}
FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""JPEG markers that say the size."""
MOST_TEXELS = 2**27
"""In one picture: more is a mistake, or a trap."""


class Images:
    """Every picture of a file, decoded when first asked for."""

    def __init__(self, container: Container, views: Views, notes: Notes) -> None:
        self._container = container
        self._views = views
        self._notes = notes
        self._texels: dict[int, np.ndarray] = {}

    def texels(self, index: int) -> np.ndarray:
        """(H, W, 4) RGBA as stored, uint8 or uint16; the first row is the top.

        Raises:
            SceneError: It is missing, of a kind that is not read here, or broken.
        """
        if index not in self._texels:
            image, label = self._container.document.images[index], f"images[{index}]"
            if image.uri is not None:
                data = read_uri(image.uri, self._container.path.parent, label)
            elif image.buffer_view is not None:
                data = bytes(self._views.content(image.buffer_view))
            else:
                raise SceneError(f"{label} has neither uri nor bufferView")
            self._texels[index] = decode(data, label, self._notes)
        return self._texels[index]


def decode(data: bytes, label: str, notes: Notes) -> np.ndarray:
    """(H, W, 4) texels of a PNG or JPEG; a note if a JPEG is damaged and yet decoded.

    Raises:
        SceneError: It is neither, broken, or too large.
    """
    if not data.startswith((PNG, JPEG)):
        other = next((name for magic, name in OTHERS.items() if data.startswith(magic)), None)
        kind = f"a {other} picture" if other else "neither PNG nor JPEG"
        raise SceneError(f"{label} is {kind}: convert it to PNG or JPEG")
    width, height = _png_size(data) if data.startswith(PNG) else _jpeg_size(data)
    if width * height == 0:
        raise SceneError(f"{label}: a broken picture, its size cannot be read")
    if width * height > MOST_TEXELS:
        raise SceneError(f"{label}: a picture of {width} x {height} texels cannot be used")
    stream = mi.MemoryStream()
    stream.write(data)
    if data.startswith(JPEG):
        stream.write(END)  # where there is none Mitsuba would read on for ever
    stream.seek(0)
    try:
        with heard(label, notes):
            bitmap = mi.Bitmap(stream)
    except Exception as error:  # Mitsuba raises RuntimeError and others
        raise SceneError(f"{label} cannot be decoded: {_reason(error)}") from error
    return _rgba(np.array(bitmap))


def _rgba(values: np.ndarray) -> np.ndarray:
    values = values.reshape(*values.shape[:2], -1)
    channels = values.shape[2]
    out = np.full((*values.shape[:2], 4), np.iinfo(values.dtype).max, values.dtype)
    out[..., :3] = values[..., :1] if channels < 3 else values[..., :3]
    if channels in (2, 4):
        out[..., 3] = values[..., -1]
    return out


def _png_size(data: bytes) -> tuple[int, int]:
    return struct.unpack_from(">II", data, 16) if len(data) >= 24 else (0, 0)


def _jpeg_size(data: bytes) -> tuple[int, int]:
    """Of the first frame; zero if there is none."""
    at = 2
    while at + 9 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker in FRAMES:
            height, width = struct.unpack_from(">HH", data, at + 5)
            return width, height
        if marker == 0xFF:  # padding
            at += 1
            continue
        at += 2 + struct.unpack_from(">H", data, at + 2)[0]
    return 0, 0


def _reason(error: Exception) -> str:
    from ddgi.scene.plugin_tree import one_line

    return one_line(error)
