"""EXT_meshopt_compression: buffer views packed by meshoptimizer.

The library hands out raw bytes, whatever type its arrays claim to be, and leaves the filters to us.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf.extras import require
from ddgi.scene.gltf.schema import MeshoptView

MOST_BYTES = 2**31
"""That one view may unpack to: a count beyond that is a mistake, or a trap."""
STRIDES = {"OCTAHEDRAL": (4, 8), "QUATERNION": (8,)}
"""Bytes per element that a filter is defined for; the exponential one takes multiples of four."""


def decode(view: MeshoptView, data: bytes, owner: str) -> bytes:
    """The bytes of a compressed view.

    Raises:
        SceneError: The library is missing, or refuses the data.
    """
    library = require("meshoptimizer", "EXT_meshopt_compression")
    if view.count * view.byte_stride > MOST_BYTES:
        raise SceneError(f"{owner}: {view.count} elements are more than fit into memory")
    _check_stride(view, owner)
    try:
        raw = _unpacked(library, view, data)
    except Exception as error:  # the library raises ValueError and RuntimeError
        reason = str(error).splitlines()[0]
        raise SceneError(f"{owner}: its meshopt data cannot be decoded: {reason}") from error
    return raw.tobytes()


def _check_stride(view: MeshoptView, owner: str) -> None:
    if view.mode == "ATTRIBUTES":
        allowed = view.byte_stride % 4 == 0
        allowed &= view.byte_stride in STRIDES.get(view.filter, (view.byte_stride,))
    else:
        allowed = view.byte_stride in (2, 4) and view.filter == "NONE"
        allowed &= view.mode != "TRIANGLES" or view.count % 3 == 0
    if not allowed:
        raise SceneError(
            f"{owner}: {view.mode.lower()} of {view.byte_stride} bytes with filter {view.filter} "
            "are not what EXT_meshopt_compression allows"
        )


def _unpacked(library: Any, view: MeshoptView, data: bytes) -> np.ndarray:
    size = view.count * view.byte_stride
    if view.mode == "TRIANGLES":
        return _bytes(library.decode_index_buffer(view.count, view.byte_stride, data), size)
    if view.mode == "INDICES":
        return _bytes(library.decode_index_sequence(view.count, view.byte_stride, data), size)
    values = _bytes(library.decode_vertex_buffer(view.count, view.byte_stride, data), size)
    filters = {
        "OCTAHEDRAL": library.decode_filter_oct,
        "QUATERNION": library.decode_filter_quat,
        "EXPONENTIAL": library.decode_filter_exp,
    }
    if view.filter in filters:
        values = _bytes(filters[view.filter](values, view.count, view.byte_stride), size)
    return values


def _bytes(values: np.ndarray, size: int) -> np.ndarray:
    """The first `size` bytes of an array, whatever its type."""
    return np.ascontiguousarray(values).view(np.uint8).reshape(-1)[:size]
