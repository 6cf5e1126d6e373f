"""Where probes stand: in their places, moved as published, or by their receivers. Error, leak and dark in real rooms.

    python benchmarks/relocation.py             # into docs/results/relocation.json; 40 minutes on two cores
    python benchmarks/relocation.py classroom   # some scenes; the others' results are kept

The views and references of `volume_search.py`, denoised; only the places of the probes differ. Where a grid
happens to have its probes moves the error as much as the rules do, so all figures are means over eight grids,
and what rules differ by has a standard error. Light has to be steady: before it is, rules are preferred that
happen to be too bright.
"""

from __future__ import annotations

import json
from dataclasses import replace
from statistics import mean
from typing import Any

import click
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

FRAMES = 64
SCENES = ("dream-apartment", "classroom", "veach-ajar", "staircase2")
BUILT_IN = (("courtyard", None), ("house", "open"))
BUDGETS = (1024, 1200, 1500, 1750, 2048, 2500, 3000, 3500)
"""Of probes; the grids fitted with them have no plane in common."""
METHODS = trials(
    "in their places: relocation.method=off",
    "SCALE: relocation.method=scale; relocation.iterations=5; relocation.clearance=0.15",
    "MFF: relocation.method=mff; relocation.iterations=50; relocation.clearance=0.15",
    "receivers",
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
    flip: dict[str, np.ndarray] = {}
    for trial in METHODS:
        grids = [
            figures(scene, with_budget(trial, budget), truth, reference, guides.albedo) for budget in BUDGETS
        ]
        found[trial.name] = {key: mean([grid[key] for grid in grids]) for key in grids[0]}
        flip[trial.name] = np.array([grid["flip_mean"] for grid in grids])
        print(name, trial.name, found[trial.name], flush=True)
    for trial in METHODS[:-1]:
        more = flip[trial.name] - flip[METHODS[-1].name]
        found[trial.name]["more"] = float(more.mean())
        found[trial.name]["more_error"] = float(more.std(ddof=1) / np.sqrt(len(more)))
    return found


def named(name: str) -> dict[str, Any]:
    """`row` of a scene by its name in the table."""
    if name in CASES:
        return row(name, CASES[name].load())
    scene, camera = next((scene, camera) for scene, camera in BUILT_IN if name == title(scene, camera))
    return row(name, load_scene(scene, camera=camera, size=SIZE))


def title(scene: str, camera: str | None) -> str:
    """What the table calls a view."""
    return scene if camera is None else f"{scene}, {camera}"


NAMES = (*SCENES, *(title(*view) for view in BUILT_IN))


@click.command()
@click.argument("names", nargs=-1, type=click.Choice(NAMES))
def main(names: tuple[str, ...]) -> None:
    """Measure and write."""
    ddgi.use_backend()
    path = RESULTS / "relocation.json"
    kept = {r["name"]: r for r in json.loads(path.read_text())["rows"]} if names and path.exists() else {}
    for name in names or NAMES:
        kept[name] = named(name)
        rows = [kept[n] for n in NAMES if n in kept]
        path.write_text(json.dumps({"machine": machine(), "rows": rows}, indent=1, allow_nan=False) + "\n")


if __name__ == "__main__":
    main()
