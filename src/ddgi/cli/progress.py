"""Progress on stderr, for anything that takes over two seconds.

On a terminal a bar that redraws itself and vanishes; elsewhere a line for each phase and one now and then, so
that logs stay short.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from threading import Event, Thread
from time import monotonic
from types import TracebackType

PATIENCE = 2.0
"""Seconds before anything is shown."""
REDRAW = 0.2
"""Seconds between two drawings of the bar."""
REPEAT = 20.0
"""Seconds between two lines of a phase in a log."""
BAR = 24
"""Width of the bar [characters]."""
TELLING = 3
"""Steps after which the time left is told: the first compile."""
FIRST = "compiling"
"""In the bar until the first step is done, which takes longest."""


class Progress:
    """Shows what is going on until the `with` block ends.

    A thread draws, so loading and compiling show too, during which nobody calls us.
    """

    def __init__(self, write: Callable[[str], object] | None = None, terminal: bool | None = None) -> None:
        self._write = write or _to_stderr
        self._terminal = sys.stderr.isatty() if terminal is None else terminal
        self._begin = monotonic()
        self._text, self._done, self._total = "", 0, 0
        self._drawn = False
        self._over = Event()
        self._thread = Thread(target=self._draw_on, daemon=True)

    def phase(self, text: str, total: int = 0) -> None:
        """What happens now, and in how many steps if that is known."""
        self._text, self._done, self._total, self._begin = text, 0, total, monotonic()

    def step(self) -> None:
        """One of the steps is done."""
        self._done += 1

    def __enter__(self) -> Progress:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()
        self._thread.join()
        if self._drawn and self._terminal:
            self._write("\r\x1b[K")

    def _draw_on(self) -> None:
        wait, logged, since = PATIENCE, "", 0.0
        while not self._over.wait(wait):
            wait = REDRAW
            self._drawn = True
            if self._terminal:
                self._write(f"\r\x1b[K{self._line()}")
            elif self._text != logged:
                logged, since = self._text, monotonic()
                self._write(f"ddgi: {logged} ...\n")
            elif self._done and monotonic() - since > REPEAT:
                since = monotonic()
                self._write(
                    f"ddgi: {logged}: {self._done}/{self._total}, {since - self._begin:.0f} s, {(since - self._begin) / self._done * (self._total - self._done):.0f} s left ...\n"
                )

    def _line(self) -> str:
        seconds = monotonic() - self._begin
        elapsed = f"{seconds:.0f} s"
        if not self._total:
            return f"{self._text} {elapsed}"
        if self._done >= TELLING:
            elapsed += f", {seconds / self._done * (self._total - self._done):.0f} s left"
        bar = "#" * (BAR * self._done // self._total) if self._done else FIRST
        return f"{self._text} [{bar:<{BAR}}] {self._done}/{self._total} {elapsed}"


def _to_stderr(text: str) -> None:
    sys.stderr.write(text)
    sys.stderr.flush()
