"""The figures as a table for people."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

ROWS = {
    "update_ms": "update [ms]",
    "limit_ms": "limit [ms]",
    "update_over_limit": "update / limit",
    "camera_ms": "camera [ms]",
    "frame_ms": "frame [ms]",
    "overhead_ms": "outside kernels [ms]",
    "frame_launches": "kernel launches",
    "recordings": "recordings",
    "bytes_per_probe": "bytes per probe",
    "peak_rss_mb": "peak memory [MB]",
    "cold_start_s": "cold start [s]",
    "warm_start_s": "warm start [s]",
}
TERMS = (
    "update: the field moved on by one frame; camera: the picture; limit: the update's rays and shadow rays, nothing else",
    "outside kernels: Python and Dr.Jit between launches; recordings: how often the stages were compiled over all frames",
    "cold, warm start: a new process up to its first picture, without and with kernels kept from before",
)


def table(scenes: Mapping[str, Mapping[str, Any]]) -> str:
    """A column for each scene, a row for each figure, then the stages."""
    lines = [_row("", list(scenes)), _row("probes", [_work(f) for f in scenes.values()])]
    lines += [_row(title, [_number(f.get(name)) for f in scenes.values()]) for name, title in ROWS.items()]
    lines += ["", "stages one by one: ms (launches); a frame fuses some, so it takes less than their sum"]
    lines += [*_stage_rows(scenes), "", *TERMS]
    return "\n".join(lines)


def _stage_rows(scenes: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    names = dict.fromkeys(stage for f in scenes.values() for stage in f["stages"])
    for name in names:
        cells = [
            f"{f['stages'][name]:.2f} ({f['launches'][name]})" if name in f["stages"] else "-"
            for f in scenes.values()
        ]
        yield _row(name, cells)


def _row(title: str, cells: list[str]) -> str:
    return f"{title:<22}" + "".join(f"{cell:>18}" for cell in cells)


def _work(figures: Mapping[str, Any]) -> str:
    return f"{figures['probes']:,} x {figures['rays_per_probe']}"


def _number(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:,}" if isinstance(value, int) else f"{value:,.2f}"
