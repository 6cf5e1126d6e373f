"""Who wants to know how far a long measurement is: `ddgi.cli.progress`, or nobody."""

from __future__ import annotations

from typing import Protocol


class Watch(Protocol):
    """Told what happens."""

    def phase(self, text: str, total: int = 0) -> None:
        """What happens now, and in how many steps if that is known."""
        ...

    def step(self) -> None:
        """One of the steps is done."""
        ...


class Unwatched:
    """A `Watch` that does nothing."""

    def phase(self, text: str, total: int = 0) -> None:
        """See `Watch.phase`."""

    def step(self) -> None:
        """See `Watch.step`."""


NOBODY = Unwatched()
