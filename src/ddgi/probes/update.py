"""One update of the field: spawn rays, send light from the lamps, gather it, blend."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ddgi.lighting.lights import Lights
from ddgi.probes import lamplit
from ddgi.probes.blend import blend
from ddgi.probes.bounce import Illumination, follows_lobes
from ddgi.probes.field import IrradianceField
from ddgi.probes.gather import gather
from ddgi.probes.lamplit import Sharing
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
        rays = spawn(vol.grid, vol.awake, time, s.rays)
        paths = lamplit.send(
            tracer, lights, vol.grid, s.rays.from_lamps, follows_lobes(tracer, s.gather), time
        )
        sharing = Sharing(paths.aim, rays.count) if paths else None
        by = Illumination(tracer, lights, vol, time, s.gather, s.direct, s.query, s.volume, sharing)
        found = gather(by, rays, s.contact)
        points = lamplit.seen(tracer, vol.grid, vol.awake, paths, rays.count, time) if paths else None
        volumes.append(blend(vol, found, points, time, s.volume, s.blend, s.query))
        non_finite = non_finite + found.non_finite + (points.non_finite if points else 0)
    return replace(field, volumes=volumes, non_finite=non_finite)
