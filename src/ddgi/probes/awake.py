"""The probes that an update is for, and the state of every probe."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

OFF, SLEEPING, NEWLY_AWAKE, NEWLY_VIGILANT, AWAKE, VIGILANT = range(6)
"""The states of SCALE 6. A vigilant probe is updated always; one that is awake may go to sleep again."""
NAMES = ("off", "sleeping", "newly awake", "newly vigilant", "awake", "vigilant")


@dataclass
class Awake:
    """A of P probes, those that are traced and blended; rays and maps in the making are laid out by their places in it."""

    count: int  # A; a constant of the kernels
    numbers: mi.UInt32 | None = None  # (A,) ascending; None: all probes, P = A

    def probe(self, place: mi.UInt32) -> mi.UInt32:
        """Probe numbers at places below A. (N,)."""
        return place if self.numbers is None else dr.gather(mi.UInt32, self.numbers, place)


@dataclass
class States:
    """What each of P probes is doing."""

    code: mi.UInt32  # (P,) `OFF` to `VIGILANT`
    quiet: mi.UInt32  # (P,) updates since it last met anything near, where that counts (CTU)
    stand_in: mi.UInt32  # (P,) the nearest probe that gives light

    def counts(self) -> dict[str, int]:
        """How many probes are in each state, by name; those that none is in are left out."""
        many = np.bincount(np.array(self.code), minlength=len(NAMES))
        return {name: int(n) for name, n in zip(NAMES, many, strict=True) if n}

    def updated(self) -> States:
        """The states after an update: what was new is not any more."""
        new = (self.code == NEWLY_AWAKE) | (self.code == NEWLY_VIGILANT)
        return States(dr.select(new, self.code + 2, self.code), self.quiet, self.stand_in)
