"""The elements of a PLY file as arrays: words, or bytes of either order.

Words become bytes first, so that one reader does for all. Where every row is as long as the first, as with
triangles alone, a table is one view of the bytes; else its rows are walked.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.ply.header import TEXT, Element, Header, Property

WORD = "f8"
"""What words are read as: whole numbers of 32 bits are exact."""
LONGEST_WORD = 64
FORMATS = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}
"""Of `struct`, by NumPy's codes."""


@dataclass(frozen=True)
class Table:
    """An element of N rows; numbers are doubles."""

    numbers: dict[str, np.ndarray]  # (N,) each
    lists: dict[str, tuple[np.ndarray, np.ndarray]]  # (N,) lengths, and all members one after another


def read_tables(data: bytes, header: Header, wanted: tuple[str, ...]) -> dict[str, Table]:
    """The elements of a file's bytes, as far as they are wanted.

    Raises:
        SceneError: The file is cut short, or a word is no number; says where.
    """
    body, order = memoryview(data)[header.start :], header.order
    if order == TEXT:
        body, order = _from_words(bytes(body)), "="
    out: dict[str, Table] = {}
    at = 0
    for element in header.elements:
        if set(wanted) <= set(out):
            break
        element = _as_words(element) if header.order == TEXT else element
        if not element.properties or not element.count:
            out.setdefault(element.name, _empty(element))
            continue
        found = _uniform(body, at, element, order) or _walked(body, at, element, order)
        table, at = found
        out.setdefault(element.name, table)
    return out


def _from_words(text: bytes) -> memoryview:
    words = text.split()
    for word in words:
        if len(word) > LONGEST_WORD:
            raise SceneError(f"{word[:40].decode('ascii', 'replace')!r}... is not a number")
    try:
        return memoryview(np.array(words).astype(np.float64).tobytes())
    except ValueError:
        bad = next(word for word in words if not _is_number(word)).decode("ascii", "replace")
        raise SceneError(f"{bad!r} is not a number") from None


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _as_words(element: Element) -> Element:
    properties = (Property(p.name, WORD, None if p.length is None else WORD) for p in element.properties)
    return Element(element.name, element.count, tuple(properties))


def _empty(element: Element) -> Table:
    none = np.zeros(0)
    numbers = {p.name: none for p in element.properties if p.length is None}
    return Table(numbers, {p.name: (none.astype(int), none) for p in element.properties if p.length})


def _uniform(body: memoryview, at: int, element: Element, order: str) -> tuple[Table, int] | None:
    """The table if all its rows have lists as long as the first has; and where it ends."""
    first, _ = _row(body, at, element, order, 0)
    fields: list[tuple] = []
    for number, (prop, (_, length)) in enumerate(zip(element.properties, first, strict=True)):
        if prop.length is None:
            fields.append((f"{number}", order + prop.code))
        else:
            fields.append((f"length {number}", order + prop.length))
            fields.append((f"{number}", order + prop.code, (length,)))
    rows = np.dtype(fields)
    end = at + rows.itemsize * element.count
    if end > len(body):
        if all(prop.length is None for prop in element.properties):
            raise _cut(element, (len(body) - at) // rows.itemsize)
        return None
    values = np.frombuffer(body[at:end], rows)
    table = Table({}, {})
    for number, (prop, (_, length)) in enumerate(zip(element.properties, first, strict=True)):
        column = values[f"{number}"].astype(np.float64)
        if prop.length is None:
            table.numbers[prop.name] = column
        elif (values[f"length {number}"] != length).any():
            return None
        else:
            table.lists[prop.name] = np.full(element.count, length), column.ravel()
    return table, end


def _row(
    body: memoryview, at: int, element: Element, order: str, row: int
) -> tuple[list[tuple[int, int]], int]:
    """Where each property of a row begins, and how many numbers it has; and where the row ends."""
    places = []
    for prop in element.properties:
        length = 1
        if prop.length is not None:
            length = _length(body, at, element, order + FORMATS[prop.length], row)
            at += np.dtype(prop.length).itemsize
        places.append((at, length))
        at += length * np.dtype(prop.code).itemsize
    if at > len(body):
        raise _cut(element, row)
    return places, at


def _length(body: memoryview, at: int, element: Element, code: str, row: int) -> int:
    try:
        length = struct.unpack_from(code, body, at)[0]
    except struct.error:
        raise _cut(element, row) from None
    if not 0 <= length <= len(body) or length != int(length):
        raise SceneError(f"{_place(element, row)} has a list of {length:.6g} members")
    return int(length)


def _walked(body: memoryview, at: int, element: Element, order: str) -> tuple[Table, int]:
    places = []
    for row in range(element.count):
        found, at = _row(body, at, element, order, row)
        places.append(found)
    table, raw = Table({}, {}), np.frombuffer(body, np.uint8)
    starts_and_lengths = np.array(places)  # (N, properties, 2)
    for number, prop in enumerate(element.properties):
        starts, lengths = starts_and_lengths[:, number].T
        values = _gathered(raw, starts, lengths, np.dtype(order + prop.code))
        if prop.length is None:
            table.numbers[prop.name] = values
        else:
            table.lists[prop.name] = lengths, values
    return table, at


def _gathered(raw: np.ndarray, starts: np.ndarray, lengths: np.ndarray, kind: np.dtype) -> np.ndarray:
    """All numbers of runs that begin at some bytes, as doubles."""
    before = np.cumsum(lengths) - lengths
    within = np.arange(int(lengths.sum())) - np.repeat(before, lengths)
    places = np.repeat(starts, lengths) + within * kind.itemsize
    picked = raw[places[:, None] + np.arange(kind.itemsize)]
    return np.ascontiguousarray(picked).view(kind).ravel().astype(np.float64)


def _cut(element: Element, row: int) -> SceneError:
    return SceneError(f"{_place(element, row)}: the file is cut short")


def _place(element: Element, row: int) -> str:
    return f"{element.name[:40]} {row + 1} of {element.count}"
