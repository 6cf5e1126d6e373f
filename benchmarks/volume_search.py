"""How good are the volumes that fit by themselves? Against other boxes, cells and margins with as many probes.

    python benchmarks/volume_search.py                       # all scenes, into docs/results/volumes.json
    python benchmarks/volume_search.py veach-ajar classroom  # some; the others' results are kept

Nothing is told to `IrradianceField.fit`; every other candidate names a box, counts or a margin. All are
rendered alike and held against one path-traced reference by mean FLIP, with materials in full. What
noise is left in the reference is denoised: it would make all volumes more alike.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import click
import numpy as np

import ddgi
from ddgi.box import Box, moved
from ddgi.judge.denoiser import denoise
from ddgi.judge.metrics import difference
from ddgi.judge.reference import make_reference
from ddgi.judge.trial import Trial, run
from ddgi.judge.view import look
from ddgi.probes import grid, region
from ddgi.scene.camera import Camera, look_at
from ddgi.settings import RenderSettings
from studies import FILES, RESULTS, machine

SIZE = (128, 72)
FRAMES = 32
TARGET, SECONDS = 0.02, 300
"""Of the reference: noise in FLIP is at most half of the target, unless it takes too long."""
PANES = ("material_17", "Translucent_Glass_Blue_1", "Translucent_Glass_Blue")
"""Materials of the window panes of `dream-apartment`, which its file has opaque."""


def from_file(name: str) -> ddgi.Scene:
    """One of the Mitsuba scenes, seen by its own camera."""
    return ddgi.load_scene(FILES / name / "scene_mi3.xml", size=SIZE)


def cornell_box() -> ddgi.Scene:
    """The glTF Cornell box, 556 units wide, from outside its open front."""
    camera = look_at((-278, 273, 800), (-278, 273, -280), fov=60, size=SIZE)
    return only(camera, ddgi.load_scene(FILES / "bevy-gi/CornellBox/CornellBox.glb"))


def mixed_lighting() -> ddgi.Scene:
    """Things on a disc under a sun."""
    camera = look_at((0.6, 0.5, 1.5), (-0.2, 0.1, 0), fov=60, size=SIZE)
    return only(camera, ddgi.load_scene(FILES / "bevy-gi/MixedLightingExample/MixedLightingExample.gltf"))


def apartment(size: tuple[int, int] = SIZE, **options: Any) -> ddgi.Scene:
    """The kitchen of the flat, with a ceiling, its panes clear, and the sun in its window."""
    camera = look_at((7.1, 1.6, -7.0), (10.8, 0.9, -4.8), fov=75, size=size)
    path = FILES / "dream-apartment/decoded.glb"
    scene = ddgi.load_scene(path, clear=PANES, ceiling="auto", sun=(100, 30, 20), sky="sunsky", **options)
    return only(camera, scene)


def only(camera: Camera, scene: ddgi.Scene) -> ddgi.Scene:
    """The scene with that camera in place of the one made up for it."""
    return replace(scene, cameras=(camera,))


@dataclass(frozen=True)
class Case:
    """A scene, and the box that somebody who knows it would name."""

    load: Callable[[], ddgi.Scene]
    by_hand: Box | None = None


CASES = {
    "dream-apartment": Case(apartment, ((6.8, 0.0, -7.7), (12.35, 2.68, -2.66))),
    "bevy-gi/CornellBox": Case(cornell_box, ((-556.0, 0.0, -559.2), (0.0, 548.8, 0.0))),
    "bevy-gi/MixedLightingExample": Case(mixed_lighting, ((-1.0, 0.0, -1.0), (1.0, 0.7, 1.0))),
    "classroom": Case(partial(from_file, "classroom"), ((-4.3, 0.0, -6.0), (4.1, 3.05, 6.0))),
    "veach-ajar": Case(partial(from_file, "veach-ajar"), ((-4.0, 0.0, -7.6), (7.43, 3.8, 0.6))),
    "staircase2": Case(partial(from_file, "staircase2"), ((-4.0, -0.1, -3.0), (7.16, 11.4, 7.0))),
}


def candidates(
    own: Box, bounds: Box, by_hand: Box | None, counts: tuple[int, int, int]
) -> Iterator[tuple[str, grid.Settings]]:
    """Other volumes of as many probes.

    Args:
        own: The box that was found.
        bounds: That around all geometry.
        by_hand: That of somebody who knows.
        counts: Of the volume that was fitted.
    """
    budget = int(np.prod(counts))
    low, high = np.array(own[0]), np.array(own[1])
    middle, half = (low + high) / 2, (high - low) / 2

    def boxed(box: Any) -> grid.Settings:
        corners = tuple(tuple(float(x) for x in corner) for corner in box)
        return grid.Settings(box=corners, budget=budget)  # type: ignore[arg-type]

    yield "bounding box", boxed(bounds)
    if by_hand is not None:
        yield "by hand", boxed(by_hand)
    for scale in (0.75, 0.9, 1.1, 1.25):
        yield f"scaled by {scale:g}", boxed((middle - scale * half, middle + scale * half))
    for axis, name in enumerate("xyz"):
        for share in (-0.25, 0.25):
            moved = share * 2 * half * (np.arange(3) == axis)
            yield f"{name} low side {-share:+.0%}", boxed((low - moved, high))
            yield f"{name} high side {share:+.0%}", boxed((low, high + moved))
    for axis, name in enumerate("xyz"):
        for factor in (0.7, 1.4):
            other = stretched(counts, axis, factor)
            yield f"{name} cells x {factor:g}", grid.Settings(box=own, counts=other)
    for margin in (-0.1, 0.0, 0.25, 0.45):
        yield f"margin {margin:g}", grid.Settings(box=own, counts=counts, margin=margin)


def stretched(counts: tuple[int, int, int], axis: int, factor: float) -> tuple[int, int, int]:
    """About as many probes, with cells longer along an axis by a factor and shorter across it."""
    cells = np.array(counts) - 1.0
    cells *= np.where(np.arange(3) == axis, 1 / factor, factor**0.5)
    best = np.maximum(2, np.round(cells).astype(int) + 1)
    while np.prod(best) > np.prod(counts):  # take a plane where it is missed least
        shares = np.where(best > 2, best / (cells + 1), 0)
        best[shares.argmax()] -= 1
    return int(best[0]), int(best[1]), int(best[2])


def found_box(scene: ddgi.Scene) -> Box:
    """The box that probes are laid over where nothing is said."""
    x, y, z = scene.origin
    seen = region.look(scene.tracer, scene.cameras)
    return moved(region.find(scene.tracer, seen, moved(scene.bounds, (-x, -y, -z))), scene.origin)


def search(name: str, case: Case) -> dict[str, Any]:
    """Score our volume and all others."""
    scene = case.load()
    reference = make_reference(scene, scene.camera, TARGET, SECONDS)
    guides = look(scene).guides
    truth, *halves = (denoise(picture, guides)[0] for picture in (reference.picture, *reference.halves))
    noise = difference(*halves).flip_mean
    settings = RenderSettings.preset("default")

    def score(label: str, layout: grid.Settings) -> dict[str, Any]:
        outcome = run(scene, Trial(label, replace(settings, grid=layout)), FRAMES)
        found = difference(outcome.picture, truth)
        print(
            f"  {label:<24}{outcome.probes:>6} {found.flip_mean:.4f} {100 * found.luminance_error:+.1f} %",
            flush=True,
        )
        return {
            "flip_mean": found.flip_mean,
            "luminance_error": found.luminance_error,
            "probes": outcome.probes,
        }

    print(f"{name}: {noise:.4f} between halves of the reference, {reference.spp} samples a pixel", flush=True)
    box = scene.box or found_box(scene)
    counts = ddgi.IrradianceField.fit(scene, settings).volumes[0].grid.counts
    trials = {"automatic": score("automatic", settings.grid)}
    for label, layout in candidates(box, scene.bounds, case.by_hand, counts):
        trials[label] = score(label, layout)
    best = min(trials, key=lambda label: trials[label]["flip_mean"])
    ratio = trials["automatic"]["flip_mean"] / trials[best]["flip_mean"]
    print(f"{name}: {ratio:.3f} times the best of {len(trials)}, {best}", flush=True)
    return {
        "name": name, "size": list(SIZE), "frames": FRAMES, "reference_flip": noise, "reference_spp": reference.spp,
        "box": box, "counts": counts, "best": best, "ratio": ratio, "trials": trials,
    }  # fmt: skip


@click.command()
@click.argument("names", nargs=-1)
def main(names: tuple[str, ...]) -> None:
    """Search for better volumes, scene by scene."""
    ddgi.use_backend()
    path = RESULTS / "volumes.json"
    rows = {r["name"]: r for r in json.loads(path.read_text())["rows"]} if path.exists() else {}
    for name in names or CASES:
        if name not in CASES:
            raise click.UsageError(f"no scene {name!r}: there are {', '.join(CASES)}")
        rows[name] = search(name, CASES[name])
        found = {"machine": machine(), "rows": [rows[n] for n in CASES if n in rows]}
        path.write_text(json.dumps(found, indent=1, allow_nan=False) + "\n")


if __name__ == "__main__":
    main()
