"""Light that passes closed walls: BLOG's house, its sealed room, a sun of 10,000 W/m^2 outside.

    python benchmarks/leaks.py      # into docs/results/leaks.json; minutes on two cores

Irradiance at 4,096 fixed points of surfaces in the sealed room, as the points' finders see them, over the
irradiance of what faces up in the sun: mean, and the 99.9th percentile. The right answer is 0.
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ddgi import frame  # isort: skip  # before Dr.Jit: it loads LLVM once

import drjit as dr
import mitsuba as mi

from ddgi import IrradianceField
from ddgi.backend import use_backend
from ddgi.config import load_settings
from ddgi.judge.compare import compare
from ddgi.judge.sheet import sheet
from ddgi.judge.trial import Trial
from ddgi.output import save_display
from ddgi.probes import query
from ddgi.probes.field import irradiance
from ddgi.scene.camera import with_near
from ddgi.scene.library.house import house, sealed_room
from ddgi.scene.load import load_scene
from ddgi.scene.scene import Scene
from ddgi.settings import RenderSettings
from studies import PICTURES, RESULTS, machine

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from probing import surfaces_in

SUN, WAY = 1e4, (-0.45, -1.0, -0.6)
WALLS = (0.3, 0.1, 0.02, 0.001)
SPACINGS = (0.5, 1.0)
UPDATES = 24
ABOVE, NEAR = (0, 14, 0.1, 0, 0, 0), 11.5
SHOWN = {"default": "and relocation", "scale": "scale", "classic": "classic"}
"""Names in the picture, and of their configurations."""
CONFIGURATIONS = {
    "maps alone": ("default", ["query.sight=maps", "relocation.method=off"]),
    "and cells": ("default", ["query.sight=cells", "relocation.method=off"]),
    "and rays": ("default", ["relocation.method=off"]),
    "and relocation": ("default", []),
    "scale": ("scale", ["blend.warm_up=12"]),
    "classic": ("classic", ["blend.warm_up=12"]),
}


def leak(scene: Scene, wall: float, settings: RenderSettings) -> tuple[float, float]:
    """Mean and 99.9th percentile, over the sun's irradiance outside."""
    field = IrradianceField.fit(scene, settings)
    for tick in range(UPDATES):
        field = frame.updated(scene, field, tick, settings)
        dr.eval(field)
    found = surfaces_in(scene, *sealed_room(wall))
    e = irradiance(field, query.Receiver.on(found), settings.volume, settings.query, scene.tracer)
    y = np.array(mi.luminance(e))[np.array(found.lit)] * np.linalg.norm(WAY) / SUN
    return float(y.mean()), float(np.percentile(y, 99.9))


def measured() -> list[dict[str, Any]]:
    """A row for each thickness and spacing."""
    rows = []
    for wall in WALLS:
        blueprint = house(wall=wall, sun_direction=WAY, sun_irradiance=SUN)
        scene = load_scene(blueprint.description, camera="sealed", size=(64, 36))
        for spacing in SPACINGS:
            row: dict[str, Any] = {"wall": wall, "spacing": spacing}
            for name, (preset, sets) in CONFIGURATIONS.items():
                settings = load_settings(preset, None, [f"grid.spacing={spacing}", *sets])
                mean, most = leak(scene, wall, settings)
                row[name] = {"mean": mean, "max": most}
            rows.append(row)
            print(row, flush=True)
    return rows


def picture() -> None:
    """BLOG's comparison: the house from above, its roof cut away for the camera; the room on the left is sealed."""
    scene = load_scene("house", look=ABOVE, size=(320, 180))
    scene = replace(scene, cameras=tuple(with_near(camera, NEAR) for camera in scene.cameras))
    trials = [
        Trial(name, load_settings(preset, None, sets))
        for name, (preset, sets) in ((n, CONFIGURATIONS[c]) for n, c in SHOWN.items())
    ]
    found = compare(scene, trials, frames=64, target=0.2, most_seconds=120, rivals=False)
    save_display(PICTURES / "leaks-house.png", sheet(found))


def main() -> None:
    """Measure and write."""
    use_backend()
    picture()
    found = {"machine": machine(), "rows": measured()}
    (RESULTS / "leaks.json").write_text(json.dumps(found, indent=1, allow_nan=False) + "\n")


if __name__ == "__main__":
    main()
