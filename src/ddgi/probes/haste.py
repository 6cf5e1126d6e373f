"""Scene events (SCALE 4.3): for some updates after a large change, all probes keep less of what they have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import drjit as dr
import mitsuba as mi

from ddgi.errors import SettingsError

Event = Literal["small light", "large light", "large object"]
EVENTS: dict[str, tuple[float, int, float, int]] = {
    "small light": (0.15, 4, 0.0, 0),
    "large light": (0.5, 10, 0.0, 0),
    "large object": (0.5, 10, 0.5, 7),
}
"""By how much hysteresis is reduced and for how many updates: of light, and of distances."""


@dataclass
class Haste:
    """What is left of events. (1,) each; never compiled in, so that events record nothing anew."""

    light_cut: mi.Float  # share by which hysteresis is reduced
    light_left: mi.UInt32  # updates for which it is
    distance_cut: mi.Float
    distance_left: mi.UInt32

    @staticmethod
    def none() -> Haste:
        """Nothing happened."""
        zero, never = dr.opaque(mi.Float, 0), dr.opaque(mi.UInt32, 0)
        return Haste(zero, never, zero, never)

    def after(self, event: Event) -> Haste:
        """What is left once an event came too: the larger cut, for the longer time.

        Raises:
            SettingsError: There is no such event.
        """
        if event not in EVENTS:
            raise SettingsError(f"no scene event {event!r}: there are {', '.join(get_args(Event))}")
        light, updates, distance, longer = EVENTS[event]

        def cut(now: mi.Float, left: mi.UInt32, more: float) -> mi.Float:
            return dr.opaque(mi.Float, max(float(now[0]) if int(left[0]) else 0.0, more))

        def lasting(left: mi.UInt32, more: int) -> mi.UInt32:
            return dr.opaque(mi.UInt32, max(int(left[0]), more))

        return Haste(
            cut(self.light_cut, self.light_left, light),
            lasting(self.light_left, updates),
            cut(self.distance_cut, self.distance_left, distance),
            lasting(self.distance_left, longer),
        )

    def light_kept(self, alpha: mi.Float) -> mi.Float:
        """Hysteresis of irradiance and radiance."""
        return dr.select(self.light_left > 0, alpha * (1 - self.light_cut), alpha)

    def distance_kept(self, alpha: mi.Float) -> mi.Float:
        """Hysteresis of distances."""
        return dr.select(self.distance_left > 0, alpha * (1 - self.distance_cut), alpha)

    def passing(self) -> Haste:
        """What is left after an update."""
        return Haste(
            self.light_cut, _one_less(self.light_left), self.distance_cut, _one_less(self.distance_left)
        )


def _one_less(count: mi.UInt32) -> mi.UInt32:
    return dr.select(count > 0, count - 1, 0)
