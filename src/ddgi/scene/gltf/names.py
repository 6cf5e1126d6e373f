"""Names of shapes, lights and cameras: those of the file, each once, as Mitsuba wants its ids."""

from __future__ import annotations

import re

from ddgi.scene.unique_names import UniqueNames

OURS = re.compile(r"_[a-z]+-[0-9]+")
"""Keys of plugins in our descriptions."""


class Names(UniqueNames):
    """Gives out names that are not ours."""

    def taken(self, name: str) -> bool:
        """Whether it cannot be given any more, or ever."""
        return super().taken(name) or OURS.fullmatch(name) is not None
