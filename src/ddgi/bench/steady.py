"""Time of whole frames in the steady state: the same calls as in a live view, after the warm-up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING

import drjit as dr

from ddgi.frame import Frame, advance, expose, render_frame, render_view, updated
from ddgi.probes.field import IrradianceField

if TYPE_CHECKING:
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings

WARM_UP, STEADY = 24, 20
"""Frames before anything is timed, and frames of which the median counts."""


@dataclass
class Steady:
    """A running field, and what was measured on it."""

    field: IrradianceField
    frame: Frame
    recordings: list[tuple[int, int]]  # (update, picture) after each frame
    frame_ms: float
    update_ms: float
    camera_ms: float
    overhead_ms: float  # of a frame, outside kernels
    launches: int  # of a frame


def measure(scene: Scene, s: RenderSettings) -> Steady:
    """Render until all is steady, then time frames by themselves, their two halves, and their kernels."""
    run = _Run(scene, s)
    recordings = []
    for _ in range(WARM_UP):
        run.render()
        recordings.append((advance().recordings, expose().recordings))
    whole = [_milliseconds(run.render) for _ in range(STEADY)]
    halves = [(_milliseconds(run.update), _milliseconds(run.picture)) for _ in range(STEADY)]
    recordings.append((advance().recordings, expose().recordings))
    overhead, launches = _outside_kernels(run)
    return Steady(
        run.field,
        run.frame,
        recordings,
        frame_ms=median(whole),
        update_ms=median(u for u, _ in halves),
        camera_ms=median(c for _, c in halves),
        overhead_ms=overhead,
        launches=launches,
    )


def constant_from(recordings: list[tuple[int, int]]) -> int:
    """Number of the first frame, counted from one, after which nothing was recorded any more."""
    return 1 + next(n for n, counts in enumerate(recordings) if counts == recordings[-1])


class _Run:
    """A live view that goes on, whole frames or halves at a time."""

    def __init__(self, scene: Scene, s: RenderSettings) -> None:
        self._scene, self._s, self._tick = scene, s, 0
        self.field = IrradianceField.fit(scene, s)
        self.field, self.frame = render_frame(scene, self.field, scene.camera, 0, s)

    def render(self) -> None:
        """One frame."""
        self._tick += 1
        scene, s = self._scene, self._s
        self.field, self.frame = render_frame(scene, self.field, scene.camera, self._tick, s)

    def update(self) -> None:
        """The update half of `render_frame`."""
        self._tick += 1
        self.field = updated(self._scene, self.field, self._tick, self._s)

    def picture(self) -> None:
        """The camera half of `render_frame`."""
        scene = self._scene
        self.frame = render_view(scene, self.field, scene.camera, self._tick, self._s)


def _outside_kernels(run: _Run) -> tuple[float, int]:
    """(median frame time that no kernel accounts for [ms], kernel launches of a frame).

    In frames of their own: noting every kernel's time costs a little itself.
    """
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        run.render()  # the flag is part of what a recording depends on: this frame records anew
        rest, launches = [], 0
        for _ in range(STEADY):
            dr.sync_thread()
            dr.kernel_history_clear()
            total = _milliseconds(run.render)
            kernels = dr.kernel_history()
            rest.append(total - sum(k["execution_time"] for k in kernels))
            launches = len(kernels)
    return median(rest), launches


def _milliseconds(work: Callable[[], None]) -> float:
    dr.sync_thread()
    start = perf_counter()
    work()
    dr.sync_thread()
    return (perf_counter() - start) * 1e3
