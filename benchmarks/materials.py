"""What materials cost: updates of 262,144 rays in a room of 40 textured materials, and of a single plain one.

    python benchmarks/materials.py           # five runs, into docs/results/materials.json

Both rooms have the same 40 shapes, and every ray hits one. Their updates take turns, so that both see the
same minutes of the machine; what the textured ones take more is the evaluation of materials, texture
coordinates included.
"""

from __future__ import annotations

import json
from statistics import median
from time import perf_counter
from typing import Any

import ddgi  # isort: skip  # before Dr.Jit: it loads LLVM once

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.config import load_settings
from ddgi.frame import updated
from ddgi.probes.field import IrradianceField
from studies import RESULTS, machine

MATERIALS, TEXELS = 40, 256
SETTINGS = ("grid.counts=[16,8,16]", "rays.per_probe=128", "grid.box=[[-3.9,0.1,-3.9],[3.9,3.9,3.9]]")
WARM_UP, ROUNDS, RUNS = 16, 40, 5
MOST = 0.15
"""Share of the update that materials may take."""


def room(textured: bool) -> ddgi.Scene:
    """A closed room, 8 x 4 x 8 m, of six walls and 34 blocks, lit by one point light."""
    chance = np.random.default_rng(4)
    walls = [
        ((0, 0, 0), (1, 0, 0), -90, (4, 4)), ((0, 4, 0), (1, 0, 0), 90, (4, 4)),
        ((0, 2, -4), (1, 0, 0), 0, (4, 2)), ((0, 2, 4), (0, 1, 0), 180, (4, 2)),
        ((-4, 2, 0), (0, 1, 0), 90, (4, 2)), ((4, 2, 0), (0, 1, 0), -90, (4, 2)),
    ]  # fmt: skip
    place = mi.ScalarTransform4f
    shapes: list[dict[str, Any]] = [
        {"type": "rectangle", "to_world": place().translate(at).rotate(axis, angle).scale([*half, 1])}
        for at, axis, angle, half in walls
    ]
    while len(shapes) < MATERIALS:
        at, half = chance.uniform([-3.5, 0, -3.5], [3.5, 3.5, 3.5]), chance.uniform(0.1, 0.45, 3)
        shapes.append({"type": "cube", "to_world": place().translate(at).scale(half)})
    for shape in shapes:
        texels = chance.uniform(0.1, 0.9, (TEXELS, TEXELS, 3)).astype(np.float32)
        picture = {"type": "bitmap", "bitmap": mi.Bitmap(texels), "raw": True}
        grey = {"type": "rgb", "value": 0.5}
        reflectance = picture if textured else grey
        shape["bsdf"] = {"type": "twosided", "nested": {"type": "diffuse", "reflectance": reflectance}}
    lamp = {"type": "point", "position": [0, 3.6, 0], "intensity": {"type": "rgb", "value": 10.0}}
    named = {f"shape-{number}": shape for number, shape in enumerate(shapes)}
    return ddgi.load_scene({"type": "scene", "lamp": lamp, **named})


class Updates:
    """A field that is updated again and again."""

    def __init__(self, scene: ddgi.Scene, s: ddgi.RenderSettings) -> None:
        self._scene, self._s, self._tick = scene, s, 0
        self.field = IrradianceField.fit(scene, s)

    def timed(self) -> float:
        """Milliseconds of one update."""
        self._tick += 1
        dr.sync_thread()
        start = perf_counter()
        self.field = updated(self._scene, self.field, self._tick, self._s)
        dr.sync_thread()
        return (perf_counter() - start) * 1e3


def run(textured: Updates, plain: Updates) -> dict[str, float]:
    """One run: medians of updates that took turns."""
    pairs = [(textured.timed(), plain.timed()) for _ in range(ROUNDS)]
    ours, bare = median(t for t, _ in pairs), median(p for _, p in pairs)
    return {"textured_ms": round(ours, 2), "plain_ms": round(bare, 2), "share": round(1 - bare / ours, 4)}


def main() -> None:
    """Run, print, and write down."""
    ddgi.use_backend()
    settings = load_settings("default", None, SETTINGS)
    updates = [Updates(room(textured), settings) for textured in (True, False)]
    for _ in range(WARM_UP):
        for one in updates:
            one.timed()
    rows = []
    for _ in range(RUNS):
        rows.append(run(*updates))
        print(rows[-1], flush=True)
    text = json.dumps({"machine": machine(), "rows": rows}, indent=1)
    (RESULTS / "materials.json").write_text(text + "\n")


if __name__ == "__main__":
    main()
