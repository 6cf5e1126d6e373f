"""Ctrl-C, remembered.

A KeyboardInterrupt that arrives inside Dr.Jit or during an import comes out as some other error;
so that it still ends as an interruption, the signal itself is noted.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def noticing_interrupts() -> Iterator[threading.Event]:
    """An event that is set once SIGINT came; it raises KeyboardInterrupt as ever."""
    seen = threading.Event()
    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGINT) is None:
        yield seen  # only the main thread may handle signals
        return

    def note(number: int, frame: FrameType | None) -> None:
        seen.set()
        signal.default_int_handler(number, frame)

    before = signal.getsignal(signal.SIGINT)
    if before != signal.SIG_IGN:  # a shell's background job
        signal.signal(signal.SIGINT, note)
    try:
        yield seen
    finally:
        signal.signal(signal.SIGINT, before)
