"""The rays of one update: every probe looks in the same directions.

Lanes are laid out ray-major, (rays, probes that are awake): neighbouring lanes are neighbouring probes that look
the same way, which a packet tracer likes, and which makes blending a matrix product.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import drjit as dr
import mitsuba as mi
from annotated_types import Interval
from typing_extensions import Doc

from ddgi.probes.awake import Awake
from ddgi.probes.directions import frame_directions, picked
from ddgi.probes.grid import ProbeGrid
from ddgi.sampling import Clock
from ddgi.settings_group import settings_group


@settings_group("rays")
class Settings:
    """How probes look around."""

    per_probe: Annotated[int, Interval(ge=8, le=4096), Doc("rays per probe and update")] = 128
    from_lamps: Annotated[
        int,
        Interval(ge=0, le=1024),
        Doc(
            "paths from point, spot and directional lights that each probe sees land in an update: they find the small "
            "places that light a room; 0: none"
        ),
    ] = 16


@dataclass
class ProbeRays:
    """R rays from each of A probes that are awake; lane = ray * A + place in the list of them."""

    count: int  # R
    directions: mi.Vector3f  # (R,) unit
    origin: mi.Point3f  # (R A,) [m]
    direction: mi.Vector3f  # (R A,) unit


def spawn(layout: ProbeGrid, awake: Awake, time: Clock, s: Settings) -> ProbeRays:
    """This frame's rays: a Fibonacci set under one random rotation (SCALE 2.3)."""
    directions = frame_directions(s.per_probe, time)
    dr.eval(directions)  # into memory: every ray reads one of these few
    lane = dr.arange(mi.UInt32, s.per_probe * awake.count)
    ray = lane // awake.count
    origin = layout.position(awake.probe(lane - ray * awake.count))
    return ProbeRays(s.per_probe, directions, origin, picked(directions, ray))
