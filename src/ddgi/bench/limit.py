"""The limit: the rays of one update traced and nothing else.

No update can be faster than finding its own closest hits and shadows; `update_over_limit` says how
far ours is from that.
"""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

import drjit as dr
import mitsuba as mi

from ddgi.lighting.lights import DeltaLights, delta_light, from_delta
from ddgi.probes.rays import ProbeRays, spawn
from ddgi.sampling import clock

if TYPE_CHECKING:
    from ddgi.probes.field import IrradianceField
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings

REPEATS = 6
ANYWHERE = (0.48, 0.64, 0.6)
"""Where shadow rays go in scenes without a point, spot or directional light; a unit vector."""


def limit_ms(scene: Scene, field: IrradianceField, s: RenderSettings) -> float:
    """Least time [ms] that the rays of one update take: closest hits, then one shadow ray per hit."""
    return min(_once(scene, field, s, tick) for tick in range(REPEATS))


def _once(scene: Scene, field: IrradianceField, s: RenderSettings, tick: int) -> float:
    total = 0.0
    for vol in field.volumes:
        ray = _probe_rays(spawn(vol.grid, vol.awake, clock(s.seed, tick), s.rays))
        start = _synced(ray)
        hit = scene.mi_scene.ray_intersect_preliminary(ray, coherent=True)
        total += _synced(hit) - start
        shadow, active = _shadow_rays(ray, hit, scene.lights.delta)
        start = _synced(shadow, active)
        total += _synced(scene.mi_scene.ray_test(shadow, active)) - start
    return total * 1e3


def _probe_rays(rays: ProbeRays) -> mi.Ray3f:
    return mi.Ray3f(rays.origin, rays.direction)


def _shadow_rays(
    ray: mi.Ray3f, hit: mi.PreliminaryIntersection3f, lights: DeltaLights
) -> tuple[mi.Ray3f, mi.Bool]:
    """A segment from every hit to the first delta light."""
    active = hit.is_valid()
    position = ray(dr.select(active, hit.t, 0))
    if lights.count:
        light = from_delta(delta_light(lights, mi.UInt32(0)), position)
        direction, distance = light.direction, light.distance
    else:
        direction, distance = mi.Vector3f(ANYWHERE), mi.Float(dr.inf)
    # Off the surface by a share of the scene's scale, so that no ray meets the one it starts on.
    origin = position + direction * 1e-3
    return mi.Ray3f(origin, direction, distance * (1 - 1e-3), 0.0, []), active


def _synced(*arrays: object) -> float:
    """The time when everything asked for is computed [s]."""
    dr.eval(*arrays)
    dr.sync_thread()
    return perf_counter()
