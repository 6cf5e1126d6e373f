"""All figures of one scene, in this process."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ddgi.bench import memory, stages, steady
from ddgi.bench.limit import limit_ms

if TYPE_CHECKING:
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings


def measure(scene: Scene, s: RenderSettings) -> dict[str, Any]:
    """Figures by name, as `docs/results.md` explains them. Times in milliseconds."""
    run = steady.measure(scene, s)
    limit = limit_ms(scene, run.field, s)
    watch = stages.time_stages(scene, run, s)
    update, picture = run.recordings[-1]
    return {
        "triangles": scene.triangles,
        "probes": run.field.probes,
        "counts": list(run.field.volumes[0].grid.counts),
        "rays_per_probe": s.rays.per_probe,
        "size": list(run.frame.size),
        "update_ms": run.update_ms,
        "limit_ms": limit,
        "update_over_limit": run.update_ms / limit,
        "camera_ms": run.camera_ms,
        "frame_ms": run.frame_ms,
        "overhead_ms": run.overhead_ms,
        "stages": watch.milliseconds,
        "launches": watch.launches,
        "frame_launches": run.launches,
        "recordings": max(update, picture),
        "recordings_update": update,
        "recordings_picture": picture,
        "recordings_constant_from": steady.constant_from(run.recordings),
        "bytes_per_probe": memory.state_bytes(run.field) / run.field.probes,
        "peak_rss_mb": memory.peak_rss_mb(),
    }
