"""Files that appear whole or not at all: written beside their place, then moved there."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from ddgi.errors import OutputError


def check_place(path: str | os.PathLike[str]) -> Path:
    """See that a file can be written, before the work that fills it starts.

    Returns:
        The path with links followed, so that moving the file there keeps them.

    Raises:
        OutputError: It cannot; says why.
    """
    given = Path(path)
    if given.is_dir():
        raise OutputError(f"{given} is a folder: name a file in it")
    try:
        target = given.resolve()
    except (OSError, RuntimeError) as error:
        raise OutputError(f"{given}: cannot be written: {error}") from error
    if not target.parent.is_dir():
        raise OutputError(f"{given}: there is no folder {target.parent}")
    if target.exists() and not target.is_file():
        raise OutputError(f"{given} is not a plain file")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise OutputError(f"{given}: no permission to write in {target.parent}")
    if target.exists() and not os.access(target, os.W_OK):
        raise OutputError(f"{given}: no permission to replace it")
    beside = _beside(target)
    try:  # some folders take no files whatever their permissions say: full or virtual ones
        beside.touch()
    except OSError as error:
        raise OutputError(f"{given}: no file can be made there: {error.strerror}") from error
    with suppress(OSError):
        beside.unlink()
    return target


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A file to write in place of `path`; moved there when the `with` block ends well.

    Raises:
        OutputError: Writing or moving it failed.
    """
    target = check_place(path)
    beside = _beside(target)
    try:
        yield beside
        os.replace(beside, target)
    except (OSError, RuntimeError) as error:  # Mitsuba's writers raise RuntimeError, over several lines
        reason = getattr(error, "strerror", None) or str(error).strip().splitlines()[-1]
        raise OutputError(f"{path}: cannot be written: {reason}") from error
    finally:
        with suppress(OSError):
            beside.unlink()


@contextmanager
def whole_files(paths: Sequence[str | os.PathLike[str]]) -> Iterator[list[Path]]:
    """Files to write in place of `paths`, with the same endings; moved there together when the block ends well.

    Raises:
        OutputError: One cannot be written, or moved.
    """
    targets = [check_place(path) for path in paths]
    besides = [t.with_name(f".{t.stem}.{os.getpid()}-{n}.part{t.suffix}") for n, t in enumerate(targets)]
    try:
        yield besides
        for target, beside in zip(targets, besides, strict=True):
            _move(beside, target)
    finally:
        for beside in besides:
            with suppress(OSError):
                beside.unlink()


def _move(beside: Path, target: Path) -> None:
    try:
        os.replace(beside, target)
    except OSError as error:
        raise OutputError(f"{target}: cannot be written: {error.strerror}") from error


def _beside(target: Path) -> Path:
    return target.with_name(f".{target.name}.{os.getpid()}.part")
