"""Damage to files, by chance but repeatable: values of JSON with a sense for its structure, bytes, and words of text."""

from __future__ import annotations

import copy
import json
import random
import struct
from collections.abc import Iterator, Sequence
from typing import Any

Path = tuple[str | int, ...]
ODD: tuple[Any, ...] = (
    0, 1, -1, 2, 3, 7, 255, 256, 65535, 2**31, 2**32, 2**53, 2**63, 10**30, 0.5, -0.0, 1e-45, 1e38, 1e300,
    float("nan"), float("inf"), "", "\n", "../x", "data:,", "a" * 300, "é\u202e", "SCALAR", "VEC2", "VEC4", "MAT4", "MASK",
    "BLEND", "CUBICSPLINE", "weights", "TRIANGLES", "OCTAHEDRAL", True, False, None, [], {}, [0] * 16, [[]], {"a": 1},
    5120, 5121, 5123, 5125, 5126, 9728, 10497, 33071,
)  # fmt: skip
"""What stands where it should not."""
WORDS = (
    b"0", b"-1", b"1e999", b"nan", b"-inf", b"99999999999999999999", b"1/", b"//", b"1/2/3/4", b"-0", b"1.5", b"f", b"v",
    b"vt", b"usemtl", b"newmtl", b"mtllib", b"map_Kd", b"-s", b"-o", b"illum", b"\\", b"#", b"\xff", b"\0", b"9" * 5000,
    b"../../etc/passwd", b"list", b"uchar", b"float", b"end_header", b"4294967295", b"element", b"property", b"vertex",
)  # fmt: skip
RUNS = (
    b"\0",
    b"\xff",
    struct.pack("<f", float("nan")),
    struct.pack("<f", float("inf")),
    struct.pack("<f", 1e38),
)


class JsonDamage:
    """Changes documents; what some documents have, others may get in the same place."""

    def __init__(self, documents: Sequence[dict[str, Any]]) -> None:
        self._seen: dict[Path, dict[str, list[Any]]] = {}
        for document in documents:
            for path, value in places(document):
                if isinstance(value, dict):
                    for key, inner in value.items():
                        self._seen.setdefault(kind(path), {}).setdefault(key, []).append(inner)

    def damaged(self, document: dict[str, Any], chance: random.Random) -> dict[str, Any]:
        """A copy with one to three changes."""
        document = copy.deepcopy(document)
        for _ in range(chance.choice((1, 1, 2, 3))):
            self._change(document, chance)
        return document

    def _change(self, document: dict[str, Any], chance: random.Random) -> None:
        if not document:
            return
        everywhere = [found for found in places(document) if found[0]]
        path, value = chance.choice(everywhere)
        if isinstance(value, (dict, list)) and chance.random() < 0.5:  # or all are refused for their types
            path, value = chance.choice(everywhere)
        holder: Any = document
        for key in path[:-1]:
            holder = holder[key]
        at = path[-1]
        way = chance.random()
        if way < 0.15:
            del holder[at]
        elif way < 0.3 and isinstance(value, dict):
            self._enrich(value, kind(path), chance)
        elif way < 0.4 and isinstance(value, list) and value:
            value.extend(copy.deepcopy(value) * chance.choice((1, 1, 2, 50)))
        elif way < 0.7 and isinstance(value, (int, float)):
            holder[at] = chance.choice((value + 1, value - 1, value * 2, -value, value * 1000, float(value)))
        elif way < 0.85:  # what else stands in such a place
            options = self._seen.get(kind(path[:-1]), {}).get(str(at), [None])
            holder[at] = copy.deepcopy(chance.choice(options))
        else:
            holder[at] = copy.deepcopy(chance.choice(ODD))

    def _enrich(self, value: dict[str, Any], where: Path, chance: random.Random) -> None:
        options = self._seen.get(where, {})
        if options:
            key = chance.choice(sorted(options))
            value[key] = copy.deepcopy(chance.choice(options[key]))


def places(value: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Every value in a document, and where."""
    yield path, value
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield from places(inner, (*path, key))


def kind(path: Path) -> Path:
    """A place without the numbers in it: all accessors are alike."""
    return tuple("[]" if isinstance(part, int) else part for part in path)


def text(document: Any) -> bytes:
    """A document as a file has it; not every number is one that JSON knows."""
    return json.dumps(document).encode()


def bytes_damaged(data: bytes, chance: random.Random) -> bytes:
    """Bytes changed, overwritten, cut out or doubled, or the end cut off."""
    out = bytearray(data)
    for _ in range(chance.randint(1, 4)):
        if not out:
            break
        at, way = chance.randrange(len(out)), chance.random()
        if way < 0.5:
            out[at] = chance.randrange(256)
        elif way < 0.75:
            at -= at % 4
            run = chance.choice(RUNS) * chance.randint(1, 4)
            out[at : at + len(run)] = run
        elif way < 0.85:
            del out[at : at + chance.randint(1, 16)]
        elif way < 0.9:
            out[at:at] = out[at : at + chance.randint(1, 64)]
        else:
            del out[at:]
    return bytes(out)


def words_damaged(data: bytes, chance: random.Random) -> bytes:
    """Words and lines of a text changed, left out, doubled or swapped."""
    lines = data.split(b"\n")
    for _ in range(chance.randint(1, 4)):
        at, way = chance.randrange(len(lines)), chance.random()
        words = lines[at].split(b" ")
        if way < 0.5:
            words[chance.randrange(len(words))] = chance.choice(WORDS)
            lines[at] = b" ".join(words)
        elif way < 0.65:
            lines[at] = b" ".join([*words, chance.choice(WORDS)])
        elif way < 0.8:
            lines[at] = b""
        elif way < 0.9:
            lines[at] = b"\n".join([lines[at]] * chance.randint(2, 20))
        else:
            other = chance.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
    return b"\n".join(lines)
