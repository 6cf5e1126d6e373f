"""Probe states: how many probes are awake, what that saves, and whether the picture stays the same.

    python benchmarks/states.py       # into docs/results/states.json and states-counts.json; twenty minutes on two cores

States by density are CTU Table 7.9 in kind; time saved is SCALE Fig. 8: updates with all probes beside updates of those awake, in turns,
on one machine. Pictures are those of fields that average 300 updates, as noise would hide what differs; `flip_same_maps` is of
pictures lit by the same maps, but for those of sleepers.
"""

from __future__ import annotations

import json
from dataclasses import replace
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

import ddgi  # isort: skip  # before Dr.Jit: it loads LLVM once

import drjit as dr

from ddgi.bench.steady import _Run
from ddgi.config import load_settings
from ddgi.frame import Frame, render_view, updated
from ddgi.judge.metrics import difference
from ddgi.probes import states
from ddgi.probes.awake import States
from ddgi.probes.field import IrradianceField
from ddgi.settings import RenderSettings
from studies import FILES, RESULTS, SIZE, machine
from volume_search import apartment

DENSITIES = ((16, 16, 16), (32, 16, 32), (32, 32, 32))
METHODS = ("ctu", "scale", "cells")
TURNS = 15
"""Updates timed of each."""
UPDATES, FRAMES = 300, 32
"""Of a field whose picture is compared, and frames of that."""
LONG = ["blend.hysteresis=0.9999", "blend.recency=2"]


def built_in(name: str) -> ddgi.Scene:
    """A scene of the package."""
    return ddgi.load_scene(name, size=SIZE)


def counts() -> list[dict[str, Any]]:
    """Probes by their states."""
    rows = []
    for name in ("color-boxes", "courtyard", "cathedral", "forest", "dream-apartment"):
        scene = apartment() if name == "dream-apartment" else built_in(name)
        for density in DENSITIES:
            row: dict[str, Any] = {"scene": name, "counts": density}
            for method in METHODS:
                changes = [f"states.method={method}", f"grid.counts={list(density)}", "relocation.method=off"]
                vol = IrradianceField.fit(scene, load_settings("default", None, changes)).volumes[0]
                assert vol.states is not None
                row[method] = vol.states.counts()
            rows.append(row)
            print(row, flush=True)
    return rows


def saved(name: str, scene: ddgi.Scene, changes: list[str], *, shown: bool = False) -> dict[str, Any]:
    """Updates of all probes, and of those that are awake; shown: pictures too, and what they differ by."""
    ways = {m: load_settings("default", None, [*changes, f"states.method={m}"]) for m in ("off", *METHODS)}
    runs = {m: _Run(scene, s) for m, s in ways.items()}
    times: dict[str, list[float]] = {m: [] for m in ways}
    for turn in range(12 + TURNS):
        for method, run in runs.items():
            dr.sync_thread()
            start = perf_counter()
            run.update()
            dr.sync_thread()
            if turn >= 12:
                times[method].append((perf_counter() - start) * 1e3)
    found: dict[str, Any] = {"scene": name, "probes": runs["cells"].field.probes}
    found["look_share"] = looks(scene, runs["cells"], ways["cells"]) / median(times["cells"])
    for method, spent in times.items():
        ratio = median(a / b for a, b in zip(spent, times["off"], strict=True))
        awake = runs[method].field.volumes[0].awake.count
        found[method] = {"awake": awake, "update_ms": median(spent), "saved": 1 - ratio}
    if shown:
        everyone, field = picture(scene, changes, "off")
        other, _ = picture(scene, [*changes, "seed=1"], "off")
        found["noise"] = difference(other, everyone).flip_mean
        for method in ("scale", "cells"):
            some, with_states = picture(scene, changes, method)
            # The same maps, with sleepers' light and without: that differs by nothing else, noise included.
            vol, asleep = field.volumes[0], with_states.volumes[0]
            alike = replace(field, volumes=[replace(vol, grid=asleep.grid, states=asleep.states)])
            without = exposed(scene, alike, load_settings("default", None, changes))
            found[method] |= {
                "flip_mean": difference(some, everyone).flip_mean,
                "flip_same_maps": difference(without, everyone).flip_mean,
                "luminance": difference(some, everyone).luminance_error,
            }
    print(found, flush=True)
    return found


def picture(scene: ddgi.Scene, changes: list[str], method: str) -> tuple[np.ndarray, IrradianceField]:
    """That of a field which has averaged many updates, and the field."""
    s = load_settings("default", None, [*changes, *LONG, f"states.method={method}"])
    field = IrradianceField.fit(scene, s)
    for tick in range(UPDATES):
        field = updated(scene, field, tick, s)
        dr.eval(field)
    return exposed(scene, field, replace(s, seed=0)), field


def exposed(scene: ddgi.Scene, field: IrradianceField, s: RenderSettings) -> np.ndarray:
    """The mean of some frames that a field lights."""
    frame = Frame.empty(scene.camera, s)
    for tick in range(FRAMES):
        frame = render_view(scene, field, scene.camera, tick, s, frame)
    return frame.numpy()


def looks(scene: ddgi.Scene, run: Any, s: RenderSettings) -> float:
    """What sleepers cost that look around: milliseconds a frame, on average."""
    vol, total = run.field.volumes[0], []
    for tick in range(4 * s.states.every):
        start = perf_counter()
        states.attend(vol, scene.tracer, tick, s)
        dr.sync_thread()
        total.append((perf_counter() - start) * 1e3)
    return float(np.mean(total[s.states.every :]))


def flips() -> dict[str, int]:
    """Changes of states in 200 updates of `courtyard`, after 100."""
    found = {}
    for method in METHODS:
        scene, s = built_in("courtyard"), load_settings("default", None, [f"states.method={method}"])
        vol, many = IrradianceField.fit(scene, s).volumes[0], 0
        for tick in range(300):
            before = np.array(vol.states and vol.states.code)
            vol = states.attend(vol, scene.tracer, tick, s)
            now: States = vol.states  # type: ignore[assignment]
            vol = replace(vol, states=now.updated())
            many += int((np.array(now.code) != before).sum()) if tick >= 100 else 0
        found[method] = many
    return found


def main() -> None:
    """Count, time and compare."""
    ddgi.use_backend()
    yard = built_in("courtyard")
    vol = IrradianceField.fit(yard, RenderSettings.preset("default")).volumes[0]
    place = vol.grid.place
    low, high = (
        np.ravel(np.array(place(dr.arange(dr.leaf_t(vol.age), vol.grid.size))).T[i]) for i in (0, -1)
    )
    twice = [
        f"grid.box=[{list(map(float, low))},{[float(high[0]), float(2 * high[1] - low[1]), float(high[2])]}]"
    ]
    both = [
        saved("courtyard, a volume twice its height", yard, twice, shown=True),
        saved("dream-apartment", apartment(), [], shown=True),
        saved("courtyard", yard, []),
        *(
            saved(n, ddgi.load_scene(FILES / n / "scene_mi3.xml", size=SIZE), [])
            for n in ("staircase2", "veach-ajar")
        ),
    ]
    write("states", {"machine": machine(), "rows": both, "flips": flips()})
    write("states-counts", {"machine": machine(), "rows": counts()})


def write(name: str, found: dict[str, Any]) -> None:
    """Keep what was found."""
    (RESULTS / f"{name}.json").write_text(json.dumps(found, indent=1, allow_nan=False) + "\n")


if __name__ == "__main__":
    main()
