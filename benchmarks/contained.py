"""Loading files that may be bad, in processes of their own that may take only so long and so much memory."""

from __future__ import annotations

import multiprocessing
import re
import resource
import signal
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from time import process_time
from typing import Any

import ddgi  # isort: skip  # before Mitsuba: it says where libLLVM is

import mitsuba as mi
import numpy as np

from ddgi.backend import use_backend
from ddgi.errors import SceneError

SECONDS, MEGABYTES = 1.0, 512
"""Of processor time for a file, and of memory beyond what the process has before."""
STARTING, DEAD = 120.0, 10.0
"""Seconds until the first word of a process, and until the next, after which it counts as hung."""


class SlowError(Exception):
    """A file took longer than it may."""


@dataclass(frozen=True)
class Outcome:
    """What became of a file."""

    what: str  # "loaded", "refused" (by a SceneError of one line) or "failed"
    how: str = ""
    seconds: float = 0.0
    megabytes: float = 0.0  # most so far of the process, beyond what it had before the first file


def described(path: Path) -> None:
    """Load a file: glTF and OBJ up to the description that Mitsuba's parser takes, others to the scene."""
    from ddgi.scene.gltf.description import read_gltf
    from ddgi.scene.notes import Notes
    from ddgi.scene.obj.description import read_obj

    if path.suffix not in (".gltf", ".glb", ".obj"):
        ddgi.load_scene(path, sky=[1, 1, 1])  # or a sky is made each time
        return
    notes = Notes()
    description = read_obj(path, notes)[0] if path.suffix == ".obj" else read_gltf(path, notes).description
    if any("\n" in line for line in notes.lines()):
        raise AssertionError("a note of two lines")
    for part in description.values():
        if isinstance(part, dict) and part.get("type") == "ddgi_mesh":
            _check(part)


def outcome(path: Path, load: Callable[[Path], None] = described) -> Outcome:
    """What becomes of a file."""
    try:
        load(path)
    except SceneError as error:
        text = str(error).removeprefix(f"{path}: ")
        return Outcome("failed", f"two lines: {text!r}") if "\n" in text else Outcome("refused", text)
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        inner = [f for f in frames if "ddgi" in f.filename or f.filename == __file__][-1]
        return Outcome(
            "failed", f"{type(error).__name__} in {Path(inner.filename).name}:{inner.lineno}: {error}"
        )
    return Outcome("loaded")


def _check(mesh: dict[str, Any]) -> None:
    positions, faces = np.array(mesh["positions"]).reshape(-1, 3), np.array(mesh["faces"])
    for key in ("positions", "normals", "texcoords", "colors", "alphas"):
        if key in mesh and not np.isfinite(np.array(mesh[key])).all():
            raise AssertionError(f"{key} that are not finite")
    if not faces.size or faces.max() >= len(positions):
        raise AssertionError("triangles of vertices that do not exist, or none")


def outcomes(
    load: Callable[[int], Outcome], numbers: range, warm_up: Callable[[], None]
) -> Iterator[tuple[int, Outcome]]:
    """The outcome of each number, within the limits; a process that dies is replaced by another.

    Args:
        load: Loads file n. A function of a module, as another process calls it.
        numbers: Which.
        warm_up: Called first in every process, so that imports and first compilations do not count.
    """
    spawn = multiprocessing.get_context("spawn")
    while numbers:
        ours, theirs = spawn.Pipe(duplex=False)
        process = spawn.Process(target=_work, args=(load, numbers, warm_up, theirs))
        process.start()
        theirs.close()
        patience = STARTING
        try:
            while numbers:
                if not ours.poll(patience):
                    process.kill()
                yield numbers[0], ours.recv()
                numbers, patience = numbers[1:], DEAD
        except EOFError:
            process.join()
            yield numbers[0], Outcome("failed", f"the process died: exit code {process.exitcode}")
            numbers = numbers[1:]
        process.join()


def _work(
    load: Callable[[int], Outcome], numbers: range, warm_up: Callable[[], None], say: Connection
) -> None:
    use_backend("llvm")
    mi.set_log_level(mi.LogLevel.Error)  # as the command line does
    warnings.simplefilter("error")  # they would be lines on the screen too
    signal.signal(signal.SIGPROF, _slow)
    warm_up()
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    most = size + MEGABYTES * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    Path("/proc/self/clear_refs").write_text("5")  # the peak starts anew
    before = _peak()
    for number in numbers:
        signal.setitimer(signal.ITIMER_PROF, SECONDS)
        start = process_time()
        found = load(number)
        took = process_time() - start
        signal.setitimer(signal.ITIMER_PROF, 0)
        if took > SECONDS:
            found = Outcome("failed", f"slow: {took:.1f} s; {found.how}")
        say.send(Outcome(found.what, found.how, took, _peak() - before))


def _slow(*_: Any) -> None:
    raise SlowError


def _peak() -> float:
    """Most memory of this process so far [MB]."""
    line = re.search(r"VmHWM:\s+([0-9]+) kB", Path("/proc/self/status").read_text())
    assert line is not None
    return int(line[1]) / 1024
