"""Time of each stage by itself.

Stages run one by one here, each frozen and synced, where a frame fuses neighbours into common
kernels; so their times add up to more than a frame's, and show where to look rather than what it costs.
"""

from __future__ import annotations

from collections.abc import Callable
from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING, Any

import drjit as dr

from ddgi.passes.gbuffer import gbuffer
from ddgi.passes.picture import accumulate
from ddgi.passes.shade import shade
from ddgi.probes import blend as blending
from ddgi.probes import lamplit, query
from ddgi.probes.bounce import Illumination, follows_lobes
from ddgi.probes.field import irradiance
from ddgi.probes.gather import gather
from ddgi.probes.rays import spawn
from ddgi.sampling import clock

if TYPE_CHECKING:
    from ddgi.bench.steady import Steady
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings

REPEATS = 9


class Stopwatch:
    """Times functions of Dr.Jit arrays, and counts their kernel launches."""

    def __init__(self) -> None:
        self.milliseconds: dict[str, float] = {}
        self.launches: dict[str, int] = {}

    def __call__(self, name: str, stage: Callable[..., Any], *arguments: Any) -> Any:
        """The stage's result, evaluated; adds to the time under its name."""
        dr.eval(*arguments)
        frozen = dr.freeze(stage)
        result = frozen(*arguments)  # records
        times = []
        for _ in range(REPEATS):
            dr.sync_thread()
            start = perf_counter()
            frozen(*arguments)
            dr.sync_thread()
            times.append((perf_counter() - start) * 1e3)
        self.milliseconds[name] = self.milliseconds.get(name, 0.0) + median(times)
        self.launches[name] = self.launches.get(name, 0) + _launches(frozen, arguments)
        return result


def time_stages(scene: Scene, steady: Steady, s: RenderSettings) -> Stopwatch:
    """Every stage of one frame, on a field in its steady state."""
    watch, time = Stopwatch(), clock(s.seed, 10_000)
    tracer, lights = scene.tracer, scene.lights
    for vol in steady.field.volumes:
        rays = watch("spawn rays", spawn, vol.grid, vol.awake, time, s.rays)
        paths = sharing = points = None
        if s.rays.from_lamps and lights.delta.count:
            paths = watch(
                "light paths", lamplit.send,
                tracer, lights, vol.grid, s.rays.from_lamps, follows_lobes(tracer, s.gather), time,
            )  # fmt: skip
            sharing = lamplit.Sharing(paths.aim, rays.count)
        found = watch(
            "trace and shade", gather,
            Illumination(tracer, lights, vol, time, s.gather, s.direct, s.query, s.volume, sharing), rays, s.contact,
        )  # fmt: skip
        if paths:
            points = watch(
                "see lamplit points", lamplit.seen, tracer, vol.grid, vol.awake, paths, rays.count, time
            )
        watch(
            "blend irradiance", blending._blend_irradiance,
            vol, found, points, time, s.volume, s.blend, s.query,
        )  # fmt: skip
        if s.volume.radiance_size:
            watch(
                "blend radiance", blending._blend_radiance, vol, found, points, None, time, s.volume, s.blend
            )
        watch("blend distance", blending._blend_distance, vol, found, time, s.volume, s.blend)
    surface = watch("camera rays", gbuffer, tracer, scene.camera, time, s.gbuffer)
    ambient = watch(
        "field in pixels", irradiance,
        steady.field, query.Receiver.on(surface), s.volume, s.query, tracer,
    )  # fmt: skip
    shaded = watch(
        "light pixels", shade, tracer, lights, surface, tracer.shining, time, s.direct, ambient, None
    )
    watch("add to picture", accumulate, steady.frame.picture, surface, shaded, s.picture)
    return watch


def _launches(frozen: Callable[..., Any], arguments: tuple[Any, ...]) -> int:
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        frozen(*arguments)
        dr.sync_thread()
        dr.kernel_history_clear()
        frozen(*arguments)
        dr.sync_thread()
        return len(dr.kernel_history())
