"""Where probes stand: in their places, moved as published, or by their receivers. Error, leak and dark in real rooms.

    python benchmarks/relocation.py       # into docs/results/relocation.json; a quarter of an hour on two cores

The views and references of `volume_search.py`, denoised; only the places of the probes differ. Where a grid
happens to have its probes moves the error as much as the rules do, so all figures are means over four grids.
"""

from __future__ import annotations

import json
from dataclasses import replace
from statistics import mean
from typing import Any

import numpy as np

import ddgi
from ddgi.judge.denoiser import denoise
from ddgi.judge.leak import dark, leak
from ddgi.judge.metrics import difference
from ddgi.judge.reference import Reference, make_reference
from ddgi.judge.trial import Trial, run
from ddgi.judge.view import look
from ddgi.scene.load import load_scene
from studies import RESULTS, machine, trials
from volume_search import CASES, SECONDS, SIZE, TARGET

FRAMES = 24
SCENES = ("dream-apartment", "classroom", "veach-ajar", "staircase2")
BUILT_IN = (("courtyard", None), ("house", "open"))
BUDGETS = (1024, 1500, 2048, 3000)
"""Of probes; the grids fitted with them have no plane in common."""
METHODS = trials(
    "in their places: relocation.method=off",
    "SCALE: relocation.method=scale; relocation.iterations=5; relocation.clearance=0.15",
    "MFF: relocation.method=mff; relocation.iterations=50; relocation.clearance=0.15",
    "MFF, weights follow: relocation.method=mff; relocation.iterations=50; relocation.clearance=0.15; query.follow_moved=true",
    "receivers",
    "receivers, weights follow: query.follow_moved=true",
)


def with_budget(trial: Trial, budget: int) -> Trial:
    """The same with so many probes at most."""
    grid = replace(trial.settings.grid, budget=budget)
    return replace(trial, settings=replace(trial.settings, grid=grid))


def figures(
    scene: ddgi.Scene, trial: Trial, truth: np.ndarray, reference: Reference, albedo: np.ndarray
) -> dict[str, float]:
    """One grid with its probes in all places. truth, albedo: (H, W, 3)."""
    outcome = run(scene, trial, FRAMES)
    apart = difference(outcome.picture, truth)
    offsets = ddgi.IrradianceField.fit(scene, trial.settings).volumes[0].grid.offsets()
    return {
        "flip_mean": apart.flip_mean,
        "luminance_error": apart.luminance_error,
        "leak": leak(outcome.leaked, reference, albedo).mean,
        "dark": dark(outcome.indirect, reference, albedo).mean,
        "moved": float((offsets != 0).any(-1).mean()),
    }


def row(name: str, scene: ddgi.Scene) -> dict[str, Any]:
    """One scene with probes in all places."""
    reference = make_reference(scene, scene.camera, TARGET, SECONDS)
    guides = look(scene).guides
    clean = [denoise(half, guides)[0] for half in reference.halves]
    truth = denoise(reference.picture, guides)[0]
    found: dict[str, Any] = {"name": name, "noise": difference(*clean).flip_mean}
    for trial in METHODS:
        grids = [
            figures(scene, with_budget(trial, budget), truth, reference, guides.albedo) for budget in BUDGETS
        ]
        found[trial.name] = {key: mean([grid[key] for grid in grids]) for key in grids[0]}
        print(name, trial.name, found[trial.name], flush=True)
    return found


def main() -> None:
    """Measure and write."""
    ddgi.use_backend()
    rows = [row(name, CASES[name].load()) for name in SCENES]
    for name, camera in BUILT_IN:
        scene = load_scene(name, camera=camera, size=SIZE)
        rows.append(row(name if camera is None else f"{name}, {camera}", scene))
    (RESULTS / "relocation.json").write_text(
        json.dumps({"machine": machine(), "rows": rows}, indent=1, allow_nan=False) + "\n"
    )


if __name__ == "__main__":
    main()
