"""One update of the field: spawn rays, gather light, blend."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ddgi.lighting.lights import Lights
from ddgi.probes.blend import blend
from ddgi.probes.bounce import Illumination
from ddgi.probes.field import IrradianceField
from ddgi.probes.gather import gather
from ddgi.probes.rays import spawn
from ddgi.sampling import Clock
from ddgi.trace.tracer import Tracer

if TYPE_CHECKING:
    from ddgi.settings import RenderSettings


def update(
    tracer: Tracer, lights: Lights, field: IrradianceField, time: Clock, s: RenderSettings
) -> IrradianceField:
    """Advance every volume by one update; light travels one bounce further."""
    volumes, non_finite = [], field.non_finite
    for vol in field.volumes:
        rays = spawn(vol.grid, time, s.rays)
        by = Illumination(tracer, lights, vol, time, s.gather, s.direct, s.query, s.volume)
        found = gather(by, rays, s.contact)
        volumes.append(blend(vol, found, time, s.volume, s.blend, s.query))
        non_finite = non_finite + found.non_finite
    return replace(field, volumes=volumes, non_finite=non_finite)
