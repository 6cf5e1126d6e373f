"""Accessors: numbers in buffer views, with strides, normalised integers and sparse replacements.

glTF 2.0 specification, sections 3.6.2 (accessors), 3.11 (normalised integers).
"""

from __future__ import annotations

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf.buffers import Views
from ddgi.scene.gltf.schema import Accessor, Document

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
SHAPES = {
    "SCALAR": (1, 1), "VEC2": (1, 2), "VEC3": (1, 3), "VEC4": (1, 4),
    "MAT2": (2, 2), "MAT3": (3, 3), "MAT4": (4, 4),
}  # fmt: skip
"""(columns, rows) of an element; the columns of a matrix start at multiples of four bytes."""
MOST_WITHOUT_DATA = 2**24
"""Elements of an accessor without a buffer view: a count beyond that is a mistake, or a trap."""


class Accessors:
    """Every accessor of a file, read once."""

    def __init__(self, document: Document, views: Views) -> None:
        self._document = document
        self._views = views
        self._raw: dict[int, np.ndarray] = {}

    def spec(self, index: int) -> Accessor:
        """What the file says of an accessor."""
        return self._document.accessors[index]

    def label(self, index: int) -> str:
        """An accessor in messages."""
        name = self.spec(index).name
        return f"accessors[{index}]" + (f' "{name}"' if name.isprintable() and name else "")

    def width(self, index: int) -> int:
        """How many numbers an element of an accessor has."""
        columns, rows = SHAPES[self.spec(index).type]
        return columns * rows

    def raw(self, index: int) -> np.ndarray:
        """(count, components) numbers as stored; of matrices column by column.

        Raises:
            SceneError: It reaches outside its buffer view, or replaces elements that are not there.
        """
        if index not in self._raw:
            self._raw[index] = self._read(index)
        return self._raw[index]

    def floats(self, index: int, kinds: tuple[str, ...], count: int | None = None) -> np.ndarray:
        """(count, components) numbers, integers that stand for fractions converted.

        Args:
            index: Which accessor.
            kinds: Types it may have, such as "VEC3".
            count: How many elements it must have.

        Raises:
            SceneError: It is of another type or length, not finite, or outside its buffer.
        """
        self.check(index, kinds, count)
        return self.converted(index, self.raw(index))

    def converted(self, index: int, raw: np.ndarray) -> np.ndarray:
        """Stored numbers of an accessor to what they stand for; float32.

        Raises:
            SceneError: Some are not finite.
        """
        values = raw.astype(np.float32)
        if self.spec(index).normalized and raw.dtype.kind in "iu":
            # For signed ones both -1 and the number below it stand for -1.
            values = np.maximum(raw / np.float64(np.iinfo(raw.dtype).max), -1).astype(np.float32)
        if not np.isfinite(values).all():
            raise SceneError(f"{self.label(index)}: a value is not finite")
        return values

    def integers(self, index: int, kinds: tuple[str, ...], count: int | None = None) -> np.ndarray:
        """(count, components) whole numbers that are not negative.

        Raises:
            SceneError: It is of another type or length, or outside its buffer.
        """
        self.check(index, kinds, count)
        if np.dtype(COMPONENTS[self.spec(index).component_type]).kind != "u" or self.spec(index).normalized:
            raise SceneError(f"{self.label(index)} must hold plain unsigned integers")
        return self.raw(index)

    def check(self, index: int, kinds: tuple[str, ...], count: int | None = None) -> None:
        """Refuse an accessor of another type or length.

        Raises:
            SceneError: It is.
        """
        spec = self.spec(index)
        if spec.type not in kinds:
            raise SceneError(f"{self.label(index)} must be {' or '.join(kinds)}, not {spec.type}")
        if count is not None and spec.count != count:
            raise SceneError(f"{self.label(index)} has {spec.count} elements, but {count} are needed")

    def _read(self, index: int) -> np.ndarray:
        spec = self.spec(index)
        columns, rows = SHAPES[spec.type]
        if spec.buffer_view is None:
            if spec.count > MOST_WITHOUT_DATA:
                raise SceneError(f"{self.label(index)}: {spec.count} elements without data")
            values = np.zeros((spec.count, columns * rows), COMPONENTS[spec.component_type])
        else:
            values = self._elements(
                self.label(index), spec.buffer_view, spec.byte_offset, spec.component_type, spec.count,
                (columns, rows), self._views.stride(spec.buffer_view),
            )  # fmt: skip
        if spec.sparse is not None:
            self._replace(index, values)
        return values

    def _replace(self, index: int, values: np.ndarray) -> None:
        """Put a sparse accessor's elements in."""
        spec, label = self.spec(index), f"{self.label(index)}: its sparse"
        sparse = spec.sparse
        assert sparse is not None
        at, by = sparse.indices, sparse.values
        places = self._elements(
            f"{label} indices", at.buffer_view, at.byte_offset, at.component_type, sparse.count, (1, 1), None
        )[:, 0]
        if places.max() >= spec.count or (np.diff(places.astype(np.int64)) <= 0).any():
            raise SceneError(f"{label} indices must rise, and stay below its count of {spec.count}")
        values[places] = self._elements(
            f"{label} values", by.buffer_view, by.byte_offset, spec.component_type, sparse.count,
            SHAPES[spec.type], None,
        )  # fmt: skip

    def _elements(
        self,
        label: str,
        view: int,
        offset: int,
        component: int,
        count: int,
        shape: tuple[int, int],
        stride: int | None,
    ) -> np.ndarray:
        """(count, columns * rows) numbers out of a view, copied."""
        data, kind = self._views.content(view), np.dtype(COMPONENTS[component])
        columns, rows = shape
        column = rows * kind.itemsize
        if columns > 1:
            column = -(-column // 4) * 4
        size = column * (columns - 1) + rows * kind.itemsize
        stride = stride or column * columns
        if stride < size:
            raise SceneError(f"{label}: elements of {size} bytes overlap in bufferViews[{view}]")
        end = offset + stride * (count - 1) + size
        if end > len(data):
            raise SceneError(
                f"{label} reaches to byte {end} of bufferViews[{view}], which has {len(data)} bytes"
            )
        strides = (stride, column, kind.itemsize)
        values = np.ndarray((count, columns, rows), kind, data, offset, strides)
        return values.reshape(count, columns * rows).copy()
