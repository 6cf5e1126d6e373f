"""`ddgi render --animation`: moments of a scene that moves, to numbered pictures or a video.

A run that was stopped goes on where it was: what it was asked for lies beside its pictures until all are there.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ddgi import __version__
from ddgi.errors import DDGIError, OutputError
from ddgi.whole_file import whole_file

if TYPE_CHECKING:
    from ddgi.cli.progress import Progress
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings

DIGITS = 4
MOST = 10**DIGITS
"""Pictures of one run."""
SETTLE = 64
"""Updates before the first picture."""
FRAMES = 8
"""Added up to each picture, if nothing else is asked for."""


@dataclass(frozen=True)
class Asked:
    """What of a scene is to be shown."""

    clip: str | None  # name or number of the animation; None: the first
    fps: float
    start: float  # [s]
    duration: float | None  # [s]; None: to the animation's end
    frames: int  # of each picture


@dataclass(frozen=True)
class Work:
    """Where the pictures of a run go, and what becomes of them."""

    output: Path
    count: int

    @property
    def video(self) -> bool:
        """Whether a video is made of the pictures."""
        return self.output.suffix.lower() == ".mp4"

    @property
    def folder(self) -> Path:
        """Of the pictures: beside a video, until it is made."""
        return self.output.with_name(f"{self.output.name}.frames") if self.video else self.output.parent

    @property
    def pictures(self) -> list[Path]:
        """Their files, in order."""
        ending = ".png" if self.video else self.output.suffix
        return [self.folder / f"{self.output.stem}-{n:0{DIGITS}d}{ending}" for n in range(self.count)]

    @property
    def note(self) -> Path:
        """What the run was asked for."""
        return self.output.with_name(f"{self.output.name}.unfinished.json")


def check(output: Path) -> None:
    """See that the result can be written, before anything is loaded.

    Raises:
        OutputError: It cannot.
        DDGIError: It is a video, and PyAV is not installed.
    """
    from ddgi.output import check_writable
    from ddgi.video import ENDING, check_video

    check_video(output) if output.suffix.lower() == ENDING else check_writable(output)


def moments(scene: Scene, asked: Asked) -> list[float]:
    """The times to show [s].

    Raises:
        SceneError: Nothing is animated, or there is no such animation.
        DDGIError: There are none, or too many.
    """
    from ddgi.scene.play import find_clip

    scene.at(0.0, asked.clip)  # says what is missing
    assert scene.rig is not None
    whole = find_clip(scene.rig.clips, asked.clip).duration
    duration = max(whole - asked.start, 0.0) if asked.duration is None else asked.duration
    count = max(1, round(duration * asked.fps))
    if count > MOST:
        raise DDGIError(
            f"{count:,} pictures are more than {MOST:,}: ask for a shorter --duration, or fewer --fps"
        )
    return [asked.start + n / asked.fps for n in range(count)]


def animate(
    scene: Scene,
    settings: RenderSettings,
    asked: Asked,
    output: Path,
    described: dict[str, Any],
    progress: Progress,
    say: Callable[[str], object],
) -> dict[str, Any]:
    """Render, or go on with what an earlier run left.

    Args:
        scene: What there is.
        settings: All of them.
        asked: Which moments.
        output: A picture's name, to which numbers are added, or a video's.
        described: What else the pictures depend on: the scene's file and options.
        progress: Told of every picture.
        say: Told that a run goes on.

    Returns:
        What was made, by name.
    """
    from ddgi.output import save
    from ddgi.passes.tone import automatic_exposure
    from ddgi.sequence import sequence
    from ddgi.video import write_video

    times = moments(scene, asked)
    work = Work(output, len(times))
    request = (
        described | asdict(asked) | {"settings": repr(settings), "version": __version__, "count": len(times)}
    )
    done, exposure = _left_behind(work, request)
    if done:
        say(f"going on at picture {done + 1} of {len(times)}, after {work.pictures[done - 1]}")
    else:
        _begin(work, request)
    tone = settings.tone if exposure is None else replace(settings.tone, exposure=exposure)
    left = len(times) - done
    if left:
        progress.phase(f"rendering {scene.name}", SETTLE + len(times))
    shown = sequence(
        scene, settings, times, asked.clip, frames=asked.frames, settle=SETTLE, skip=done, step=progress.step
    )  # fmt: skip
    for picture, frame in zip(work.pictures[done:], shown if left else (), strict=True):
        if tone.exposure is None:
            tone = replace(tone, exposure=automatic_exposure(frame.numpy()))
            _write_note(work, request | {"exposure": tone.exposure})
        save(picture, frame, tone)
    if work.video:
        progress.phase(f"encoding {output.name}")
        write_video(output, work.pictures, asked.fps)
        shutil.rmtree(work.folder, ignore_errors=True)
    with suppress(OSError):
        work.note.unlink()
    names = [str(output)] if work.video else [str(p) for p in work.pictures]
    notes = list(scene.at(times[0], asked.clip).notes)
    return {
        "notes": notes,
        "outputs": names,
        "pictures": len(times),
        "continued_at": done,
        "exposure": tone.exposure,
    }


def _left_behind(work: Work, request: dict[str, Any]) -> tuple[int, float | None]:
    """How many pictures an earlier run of the same request made, and how they were exposed."""
    try:
        noted = json.loads(work.note.read_text())
    except (OSError, ValueError):
        return 0, None
    if not isinstance(noted, dict) or {k: v for k, v in noted.items() if k != "exposure"} != request:
        return 0, None
    there = [picture.is_file() for picture in work.pictures]
    return (there.index(False) if False in there else len(there)), noted.get("exposure")


def _begin(work: Work, request: dict[str, Any]) -> None:
    if work.video:
        shutil.rmtree(work.folder, ignore_errors=True)
        try:
            work.folder.mkdir()
        except OSError as error:
            raise OutputError(f"{work.folder}: cannot be made: {error.strerror}") from error
    _write_note(work, request)


def _write_note(work: Work, request: dict[str, Any]) -> None:
    with whole_file(work.note) as file:
        file.write_text(json.dumps(request, indent=2) + "\n")
