"""How many samples fit into the time left: they cost time each, and looking at what they came to costs some more."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter


class Pace:
    """A time limit, and how long the work done so far took."""

    def __init__(self, most_seconds: float) -> None:
        """Start the clock."""
        self._end = perf_counter() + most_seconds
        self._sampling = self._judging = 0.0  # [s]; the latter of the last time
        self.samples = 0  # made so far

    @contextmanager
    def sampling(self, samples: int) -> Iterator[None]:
        """While samples are made."""
        begin = perf_counter()
        yield
        self._sampling += perf_counter() - begin
        self.samples += samples

    @contextmanager
    def judging(self) -> Iterator[None]:
        """While it is measured how good they are."""
        begin = perf_counter()
        yield
        self._judging = perf_counter() - begin

    @property
    def left(self) -> float:
        """Time left [s], 0 at least."""
        return max(0.0, self._end - perf_counter())

    @property
    def per_sample(self) -> float:
        """What a sample cost so far [s]; 0 where none was made."""
        return self._sampling / self.samples if self.samples else 0.0

    def affordable(self) -> int:
        """Samples that can be made and judged in the time left; needs some that were made."""
        return int((self._end - perf_counter() - self._judging) / self.per_sample)
