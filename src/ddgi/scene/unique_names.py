"""Names that are each given once: equal ones are numbered from 2 on."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class UniqueNames:
    """Gives out names."""

    used: set[str] = field(default_factory=set)
    numbers: dict[str, int] = field(default_factory=dict)  # the next to try, by name: all below are used

    def unique(self, wanted: str) -> str:
        """The name, with a number if it is taken."""
        name, number = wanted, self.numbers.get(wanted, 2)
        while self.taken(name):
            name, number = f"{wanted}-{number}", number + 1
        self.numbers[wanted] = number
        self.used.add(name)
        return name

    def taken(self, name: str) -> bool:
        """Whether it cannot be given any more."""
        return name in self.used
