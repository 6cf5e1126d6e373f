"""JPEG pictures that are damaged: what libjpeg says of them, which it would print by itself.

It writes to the process's stderr, past Python and past Mitsuba, and then gives up, or makes up the rest of the
picture. Here its words are caught, to become a note or to give way to an error.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from threading import RLock

from ddgi.scene.notes import Notes

SIGNATURE = b"\xff\xd8\xff"
STDERR = 2
WORDS = re.compile(
    rb"(?:Corrupt JPEG data|Premature end of JPEG|Invalid SOS parameters|Inconsistent progression"
    rb"|Unknown Adobe color transform|Warning: unknown JFIF revision|Invalid progressive parameters).*\n?"
)
"""The lines of libjpeg's warnings (`jerror.h`), which may follow a progress bar."""
END = b"\xff\xd9" * (1 << 16)
"""Marks of the end: more than the longest segment can skip, so that a picture cut short has one."""

_lock = RLock()  # the process has one stderr


def is_jpeg(path: Path) -> bool:
    """Whether a file starts like a JPEG picture."""
    with path.open("rb") as file:
        return file.read(len(SIGNATURE)) == SIGNATURE


@contextmanager
def heard(label: str, notes: Notes) -> Iterator[None]:
    """Decode a picture meanwhile: if it is damaged and nevertheless decoded, a note says so.

    Args:
        label: What to call the picture.
        notes: Takes the note.
    """
    with _caught() as said:
        yield
    if said:
        notes.add(f"{label}: a damaged picture, shown as far as it goes: {said[0]}")


@contextmanager
def _caught() -> Iterator[list[str]]:
    """What libjpeg writes to stderr meanwhile; what anything else does comes through afterwards."""
    said: list[str] = []
    with _lock, TemporaryFile() as file:
        try:
            own = os.dup(STDERR)
        except OSError:  # there is none to write to
            yield said
            return
        try:
            _flush()
            os.dup2(file.fileno(), STDERR)
            yield said
        finally:
            _flush()
            os.dup2(own, STDERR)
            os.close(own)
            file.seek(0)
            caught = file.read()
            said += [line.decode(errors="replace").strip() for line in WORDS.findall(caught)]
            if rest := WORDS.sub(b"", caught):
                os.write(STDERR, rest)


def _flush() -> None:
    if sys.stderr is not None:  # as where a program has no console
        sys.stderr.flush()
