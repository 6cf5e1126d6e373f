"""What moving things cost: `beach-balls` beside `courtyard`, which is the same without the balls.

    python benchmarks/movers.py     # into docs/results/movers.json; two minutes, alone on the machine

Medians of frames at 640x360, in turns, with all probes awake, so that both update as many. "added" is what a frame takes
more with a hundred balls that move, posing included; "rebuild" what building all of the courtyard anew takes, which
is what moving things in it would cost each frame if they were part of it.
"""

from __future__ import annotations

import json
from statistics import median
from time import perf_counter

from ddgi.config import load_settings

from ddgi.frame import render_frame  # isort: skip  # before Dr.Jit: it loads LLVM once

import drjit as dr
import mitsuba as mi

import ddgi
from ddgi.own_memory import own
from ddgi.scene.mesh_keys import POSITIONS
from studies import RESULTS, machine

TURNS, FRAMES, FIRST = 4, 12, 8
RATE = 30.0


def frames(scene: ddgi.Scene, field: ddgi.IrradianceField, tick: int, s: ddgi.RenderSettings):
    """Milliseconds of frames, and of posing in them; the field after."""
    whole, posing = [], []
    for number in range(tick, tick + FRAMES):
        start = perf_counter()
        now = scene if scene.rig is None else scene.at(number / RATE)
        _ = now.tracer  # shows the pose
        dr.sync_thread()
        posed = perf_counter()
        field, frame = render_frame(now, field, now.camera, number, s)
        dr.eval(frame.image)
        dr.sync_thread()
        whole.append((perf_counter() - start) * 1e3)
        posing.append((posed - start) * 1e3)
    return whole, posing, field


def rebuild(scene: ddgi.Scene) -> float:
    """Milliseconds to build all that stays anew, as after one of its meshes has moved."""
    parameters = mi.traverse(scene.mi_scene)
    key = next(key for key in parameters.keys() if key.endswith(POSITIONS))  # noqa: SIM118, not a dict
    took = []
    for _ in range(5):
        parameters[key] = own(parameters[key].numpy())
        dr.sync_thread()
        start = perf_counter()
        parameters.update()
        dr.sync_thread()
        took.append((perf_counter() - start) * 1e3)
    return median(took)


def main() -> None:
    """Measure, and write what came out."""
    s = load_settings("default", None, ["states.method=off"])
    scenes = {name: ddgi.load_scene(name, size=(640, 360)) for name in ("courtyard", "beach-balls")}
    fields = {name: ddgi.IrradianceField.fit(scene, s) for name, scene in scenes.items()}
    took: dict[str, list[float]] = {name: [] for name in scenes}
    posing: list[float] = []
    for turn in range(TURNS):
        for name, scene in scenes.items():
            whole, posed, fields[name] = frames(scene, fields[name], turn * FRAMES, s)
            took[name] += whole[FIRST:] if turn == 0 else whole[1:]
            posing += posed[FIRST:] if name == "beach-balls" else []
    still, moving = (median(took[name]) for name in scenes)
    found = {
        "machine": machine(),
        "static_triangles": scenes["courtyard"].triangles,
        "moving_triangles": scenes["beach-balls"].triangles - scenes["courtyard"].triangles,
        "still_ms": still,
        "moving_ms": moving,
        "added_ms": moving - still,
        "posing_ms": median(posing),
        "rebuild_ms": rebuild(scenes["courtyard"]),
    }
    found["added_over_rebuild"] = found["added_ms"] / found["rebuild_ms"]
    (RESULTS / "movers.json").write_text(json.dumps(found, indent=1) + "\n")
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
