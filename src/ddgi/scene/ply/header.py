"""The header of a PLY file: which elements follow, what each is made of, and in which bytes.

Source: Turk, "The PLY Polygon File Format" (1994).
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from ddgi.errors import SceneError

TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
"""NumPy's codes."""
TEXT, LITTLE, BIG = "", "<", ">"
ORDERS = {"ascii": TEXT, "binary_little_endian": LITTLE, "binary_big_endian": BIG}
LONGEST = 1 << 16
_END = re.compile(rb"^end_header[ \t]*\n?", re.MULTILINE)


@dataclass(frozen=True)
class Property:
    """A number of an element, or a list of numbers."""

    name: str
    code: str  # of `TYPES`
    length: str | None = None  # code of the number of members in front of a list


@dataclass(frozen=True)
class Element:
    """A table: so many rows of these properties."""

    name: str
    count: int
    properties: tuple[Property, ...]


@dataclass(frozen=True)
class Header:
    """What a file says of itself."""

    order: str  # of bytes; TEXT for words
    elements: tuple[Element, ...]
    start: int  # of the data [bytes]


def read_header(data: bytes) -> Header:
    """The header of a file's bytes.

    Raises:
        SceneError: It is none, or has a line that cannot be understood.
    """
    end = _END.search(data[:LONGEST].replace(b"\r", b"\n"))
    if not data.startswith(b"ply") or end is None:
        raise SceneError("is not a PLY file")
    order = None
    tables: list[tuple[str, int, list[Property]]] = []
    for line in data[: end.start()].decode("ascii", "replace").splitlines()[1:]:
        match line.split():
            case ["format", name, *_]:
                order = ORDERS.get(name)
            case ["element", name, count]:
                tables.append((name, _count(line, count), []))
            case ["property", *words] if tables:
                tables[-1][2].append(_property(line, words))
            case ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise SceneError(f"its header has a line that is not understood: {line[:60]!r}")
    if order is None:
        raise SceneError(f"its format is none of {', '.join(ORDERS)}")
    start = end.end() + (data[end.end() - 1 : end.end() + 1] == b"\r\n")
    return Header(order, tuple(Element(n, c, _distinct(n, p)) for n, c, p in tables), start)


def _count(line: str, word: str) -> int:
    if not (word.isascii() and word.isdecimal() and len(word) < 16):
        raise SceneError(f"its header has a line whose count is none: {line[:60]!r}")
    return int(word)


def _property(line: str, words: list[str]) -> Property:
    match words:
        case ["list", length, code, name] if TYPES.get(length, "f")[0] != "f" and code in TYPES:
            return Property(name, TYPES[code], TYPES[length])
        case [code, name] if code in TYPES:
            return Property(name, TYPES[code])
    raise SceneError(f"its header has a property of an unknown type: {line[:60]!r}")


def _distinct(element: str, properties: list[Property]) -> tuple[Property, ...]:
    names = [p.name for p in properties]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise SceneError(f"its header has two properties {twice[:40]!r} of one {element[:40]!r}")
    return tuple(properties)
