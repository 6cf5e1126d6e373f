"""Buffers and the views into them, read when first asked for."""

from __future__ import annotations

from ddgi.errors import SceneError
from ddgi.scene.gltf import meshopt
from ddgi.scene.gltf.document import Container
from ddgi.scene.gltf.uris import read_uri


class Views:
    """The bytes of every buffer view of a file."""

    def __init__(self, container: Container) -> None:
        self._container = container
        self._buffers: dict[int, bytes] = {}
        self._decoded: dict[int, bytes] = {}

    def content(self, index: int) -> memoryview:
        """A view's bytes, decompressed.

        Raises:
            SceneError: Its buffer cannot be read, or is too short for it.
        """
        view = self._container.document.buffer_views[index]
        compressed = view.extensions.meshopt
        if compressed is None:
            return self._part(index, view.buffer, view.byte_offset, view.byte_length)
        if index not in self._decoded:
            data = self._part(index, compressed.buffer, compressed.byte_offset, compressed.byte_length)
            self._decoded[index] = meshopt.decode(compressed, bytes(data), f"bufferViews[{index}]")
        if len(self._decoded[index]) < view.byte_length:
            raise SceneError(
                f"bufferViews[{index}]: its compressed data holds {len(self._decoded[index])} bytes, "
                f"but it says {view.byte_length}"
            )
        return memoryview(self._decoded[index])[: view.byte_length]

    def stride(self, index: int) -> int | None:
        """Bytes from one element to the next, where the view says so."""
        view = self._container.document.buffer_views[index]
        return view.byte_stride

    def buffer(self, index: int) -> bytes:
        """All bytes of a buffer.

        Raises:
            SceneError: It cannot be read, or is shorter than it says.
        """
        if index not in self._buffers:
            self._buffers[index] = self._read(index)
        return self._buffers[index]

    def _part(self, view: int, buffer: int, start: int, length: int) -> memoryview:
        data = self.buffer(buffer)
        if start + length > len(data):
            raise SceneError(
                f"bufferViews[{view}]: bytes {start} to {start + length} lie outside buffers[{buffer}], "
                f"which has {len(data)}"
            )
        return memoryview(data)[start : start + length]

    def _read(self, index: int) -> bytes:
        buffer, owner = self._container.document.buffers[index], f"buffers[{index}]"
        if buffer.uri is not None:
            data = read_uri(buffer.uri, self._container.path.parent, owner)
        elif index == 0 and self._container.binary is not None:
            data = self._container.binary
        elif buffer.extensions.meshopt is not None:
            raise SceneError(f"{owner} is a fallback without data, yet an uncompressed view reads it")
        else:
            raise SceneError(f"{owner} has no uri, and the file no binary chunk for it")
        if len(data) < buffer.byte_length:
            raise SceneError(f"{owner} is cut short: {buffer.byte_length} bytes expected, {len(data)} found")
        return data[: buffer.byte_length]
