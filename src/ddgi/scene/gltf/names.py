"""Names of shapes, lights and cameras: those of the file, each once, as Mitsuba wants its ids."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

OURS = re.compile(r"_[a-z]+-[0-9]+")
"""Keys of plugins in our descriptions."""


@dataclass
class Names:
    """Gives out names."""

    used: set[str] = field(default_factory=set)

    def unique(self, wanted: str) -> str:
        """The name, with a number if it is taken."""
        name, number = wanted, 2
        while name in self.used or OURS.fullmatch(name):
            name, number = f"{wanted}-{number}", number + 1
        self.used.add(name)
        return name
