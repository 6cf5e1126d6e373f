"""Noticing that light has changed: probes compare what each update brought with what is usual.

New light scatters around what is usual, by how much a probe learns as it goes. What lies farther off than
that allows, three times running and on the same side, is no noise: the probe warms up again, so that light
comes one bounce an update, as fast as it can. Flashes, as of a small lamp that few rays meet, move what is
usual but little, and one that was no change makes the probe more patient. Six lobes along the axes are
watched, for light that only comes from elsewhere; and probes by themselves, as most changes reach few of
them at once.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.extrema import at_least, clamp
from ddgi.own_memory import own_numbers

ONE_EACH = dr.ReduceMode.Permute
LOBES = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))
LEARNED, LEARNED_FIRST = 0.05, 0.25
"""Share of what is usual that comes from the latest update: of a settled probe, and of one that warms up."""
OUTLIER = 3.0
"""An update moves what is usual as if it were off by at most so many deviations."""
PATIENCE = 4.0
"""By how much the scatter (its square) grows when what was suspected was no change."""
TWICE = 12
"""First bit of the lobes that were far off at the last two updates."""
LEAST = 0.02
"""Of the light: smaller changes are left to the hysteresis, however quiet a probe is."""


@dataclass
class Change:
    """What P probes know of how their light scatters."""

    usual: mi.Float  # (6 P,) luminance, lobe by lobe
    scatter: mi.Float  # (6 P,) its mean squared deviation
    suspected: (
        mi.UInt32
    )  # (P,) lobes far off at the last update: bits 0 to 5 brighter, 6 to 11 darker; at the last two: 12 on
    settled: mi.UInt32  # (P,) updates of the light maps since the probe last warmed up

    @staticmethod
    def none(probes: int) -> Change:
        """Nothing is known."""
        floats, counts = (dr.opaque(t, 0, n) for t, n in ((mi.Float, 6 * probes), (mi.UInt32, probes)))
        return Change(floats, mi.Float(floats), counts, mi.UInt32(counts))

    @staticmethod
    def unknown() -> Change:
        """Of volumes made by hand, whose probes are not watched."""
        return Change.none(1)

    def renewed(self, which: np.ndarray, start: int) -> Change:
        """Some probes begin anew, at an update number. which: (P,) bool."""
        settled = np.array(self.settled)
        if len(settled) != len(which):
            return self
        return replace(self, settled=own_numbers(np.where(which, np.minimum(settled, start), settled)))

    def after(
        self, probe: mi.UInt32, light: list[mi.Float], warm_up: int, deviations: float
    ) -> tuple[Change, mi.UInt32]:
        """What is known after an update, and which update since they warmed up it is for each of A probes.

        Args:
            probe: (A,) their numbers.
            light: 6 x (A,) luminance that the update brought, lobe by lobe.
            warm_up: Updates that keep nothing old.
            deviations: Of the scatter, beyond which light is far off.
        """
        settled = dr.gather(mi.UInt32, self.settled, probe)
        knows = settled >= max(warm_up, 2)
        before = dr.gather(mi.UInt32, self.suspected, probe)
        known = [self._known(probe * 6 + lobe) for lobe in range(6)]
        suspected = mi.UInt32(0)
        for lobe, (new, (usual, scatter)) in enumerate(zip(light, known, strict=True)):
            far = dr.abs(new - usual) > at_least(
                deviations * dr.sqrt(scatter), LEAST * dr.maximum(new, usual)
            )
            side = dr.select(new > usual, mi.UInt32(1 << lobe), mi.UInt32(64 << lobe))
            suspected |= dr.select(knows & far, side, 0)
        changed = (suspected & before >> TWICE) != 0
        learnt = Change(
            mi.Float(self.usual), mi.Float(self.scatter), mi.UInt32(self.suspected), mi.UInt32(self.settled)
        )
        for lobe, (new, (usual, scatter)) in enumerate(zip(light, known, strict=True)):
            sides = mi.UInt32((1 | 64) << lobe)
            waits, idle = (suspected & sides) != 0, (before & ~suspected & sides) != 0
            reach = OUTLIER * dr.sqrt(scatter)
            off = dr.select(knows, clamp(new - usual, -reach, reach), new - usual)
            rate = dr.select(
                knows, mi.Float(LEARNED), dr.select(settled == 0, mi.Float(1), mi.Float(LEARNED_FIRST))
            )
            first = dr.select(settled == 0, mi.Float(0), dr.select(settled == 1, mi.Float(1), rate))
            scatter_now = dr.lerp(scatter, dr.square(off), first) * dr.select(knows & idle, PATIENCE, 1)
            usual_now = dr.fma(off, rate, usual)
            place = probe * 6 + lobe
            dr.scatter(
                learnt.usual,
                dr.select(changed, new, dr.select(waits, usual, usual_now)),
                place,
                mode=ONE_EACH,
            )
            dr.scatter(learnt.scatter, dr.select(waits | changed, scatter, scatter_now), place, mode=ONE_EACH)
        settled = dr.select(changed, 0, settled)
        suspected |= (suspected & before) << TWICE
        dr.scatter(learnt.suspected, dr.select(changed, 0, suspected), probe, mode=ONE_EACH)
        dr.scatter(learnt.settled, settled + 1, probe, mode=ONE_EACH)
        return learnt, settled

    def _known(self, place: mi.UInt32) -> tuple[mi.Float, mi.Float]:
        """What is usual, and how it scatters."""
        return dr.gather(mi.Float, self.usual, place), dr.gather(mi.Float, self.scatter, place)
