"""MFF's own measurements in kind: probes in beams (Table 4.2), and distances beyond what matters (Tables 4.3 and 4.4).

    python benchmarks/mff.py       # into docs/results/dead.json and rejection.json; a quarter of an hour on two cores

With the preset `mff` unless a row says otherwise. Its metric is ours, `mff_mean` (docs/judge.md).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import ddgi
from ddgi.config import override, parse_assignment
from ddgi.judge.compare import compare
from ddgi.judge.trial import Trial
from ddgi.scene.camera import look_at
from ddgi.scene.scene import Scene
from studies import RESULTS, SIZE, machine, trials
from volume_search import apartment

FRAMES, SECONDS = 48, 150
MOVES = "query.follow_moved=false; relocation.method=mff; relocation.iterations=50; relocation.clearance="
DEAD = (
    *trials("none: relocation.method=off", f"to the surface: {MOVES}0", f"off the surface: {MOVES}0.15", preset="mff"),
    *trials(f"and weights that follow: {MOVES}0.15; query.follow_moved=true", preset="mff"),
    *trials("default, probes in their places: relocation.method=off", "default"),
)  # fmt: skip
HALL = "gather.bounces=field; gather.path_length=1; blend.warm_up=12; grid.box=[[-5.5,0.1,-2.9],[6.5,2.9,2.9]]; grid.counts=[13,4,7]; grid.margin=0"
FAR = trials(
    *(f"{n}, {rule}: volume.distance_size={n}; blend.long_distances={rule}; {HALL}" for n in (8, 16, 32) for rule in ("off", "clamp", "reject")),
    f"64, off: volume.distance_size=64; blend.long_distances=off; {HALL}", preset="mff",
)  # fmt: skip


def block(low: Sequence[float], high: Sequence[float], reflectance: float = 0.6) -> dict[str, Any]:
    """A matt box."""
    from mitsuba import ScalarTransform4f

    middle = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
    half = [(b - a) / 2 for a, b in zip(low, high, strict=True)]
    return {
        "type": "cube", "to_world": ScalarTransform4f().translate(middle).scale(half),
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [reflectance] * 3}},
    }  # fmt: skip


def hall() -> Scene:
    """A partition in a hall of 40 m: behind it it is dark, and probes beside its edge look far past it."""
    description = {
        "type": "scene",
        "floor": block((-6, -0.2, -3.2), (34, 0, 3.2)), "ceiling": block((-6, 3, -3.2), (34, 3.2, 3.2)),
        "left": block((-6, 0, -3.2), (34, 3, -3)), "right": block((-6, 0, 3), (34, 3, 3.2)),
        "near end": block((-6.2, 0, -3), (-6, 3, 3)), "far end": block((34, 0, -3), (34.2, 3, 3), 0.1),
        "partition": block((0.2, 0, -3), (0.35, 3, 1.3)),
        "lamp": {"type": "point", "position": [-1.5, 2.2, -2.2], "intensity": {"type": "rgb", "value": [30.0] * 3}},
    }  # fmt: skip
    camera = look_at((4.5, 1.6, 1.0), (0.4, 1.4, -0.6), fov=70, size=SIZE)
    return ddgi.load_scene(description, camera=camera, materials="diffuse")


def attic() -> Scene:
    """A room under a roof with beams let into it, lit by a lamp behind a screen; probes stand in the beams."""
    beams = {f"beam {n}": block((n - 0.15, 2.6, -2), (n + 0.15, 3.3, 2), 0.35) for n in (-2, -1, 0, 1, 2)}
    description = {
        "type": "scene",
        "floor": block((-3.2, -0.2, -2.2), (3.2, 0, 2.2)), "roof": block((-3.2, 3, -2.2), (3.2, 3.3, 2.2)),
        "left": block((-3.2, 0, -2.2), (-3, 3, 2.2)), "right": block((3, 0, -2.2), (3.2, 3, 2.2)),
        "back": block((-3, 0, -2.2), (3, 3, -2)), "front": block((-3, 0, 2), (3, 3, 2.2)),
        "screen": block((0.9, 0, -1), (1.0, 1.6, 1)), **beams,
        "lamp": {"type": "point", "position": [2.2, 0.8, 0], "intensity": {"type": "rgb", "value": [12.0, 11.0, 9.0]}},
    }  # fmt: skip
    camera = look_at((-2.8, 1.2, 1.2), (0.4, 2.7, -0.6), fov=65, size=SIZE)
    return ddgi.load_scene(description, camera=camera, materials="diffuse")


def row(
    name: str, scene: Scene, ways: Sequence[Trial], target: float, seconds: float = SECONDS
) -> dict[str, Any]:
    """A scene under all configurations."""
    found = compare(scene, ways, frames=FRAMES, target=target, most_seconds=seconds, rivals=False)
    figures = found.figures()
    for configuration in figures["configurations"].values():
        del configuration["settings"]
    print(name, {j.outcome.trial.name: (round(j.difference.mff_mean, 4), round(j.difference.flip_mean, 4)) for j in found.judged}, found.valid, flush=True)  # fmt: skip
    return {"name": name} | figures


def main() -> None:
    """Both tables."""
    ddgi.use_backend()
    # One metre apart, planes at -0.4 ... 2.8 up, and in the beams across.
    beams = ["grid.box=[[-3.0,-0.2,-2.0],[3.0,2.8,2.0]]; grid.counts=[7,4,5]; grid.margin=0; "]
    in_beams = [Trial(t.name, _with(t, beams[0])) for t in DEAD]
    dead = [row("attic", attic(), in_beams, 0.1), row("dream-apartment, diffuse", _flat(), DEAD, 0.2)]
    _write("dead", dead)
    _write("rejection", [row("hall", hall(), FAR, 0.1)])


def _flat() -> Scene:
    return apartment(materials="diffuse", size=SIZE)


def _with(trial: Trial, changes: str) -> Any:
    settings = trial.settings
    for text in filter(None, map(str.strip, changes.split(";"))):
        settings = override(settings, parse_assignment(text))
    return settings


def _write(name: str, rows: list[dict[str, Any]]) -> None:
    (RESULTS / f"{name}.json").write_text(
        json.dumps({"machine": machine(), "rows": rows}, indent=1, allow_nan=False) + "\n"
    )


if __name__ == "__main__":
    main()
