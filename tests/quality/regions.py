"""Means over regions of a picture: what the quality gate keeps of its path-traced references.

    python tests/quality/regions.py          # path traces the references anew, and notes today's errors

The numbers come from Mitsuba's path tracer, never from this package's own pictures.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

import ddgi
from ddgi.judge.metrics import difference
from ddgi.judge.trial import Trial, run

KEPT = Path(__file__).parent / "regions.json"
SIZE, REGION = (192, 108), 6
"""Pictures [pixels], and the side of a square region in them: 32 x 18 regions."""
FRAMES = 32
TARGET = 0.05
SCENES = {
    "cornell": {},
    "cornell-point": {},
    "two-rooms": {},
    "house": {"camera": "open"},
    "courtyard": {"camera": "gallery"},
}
"""Scenes of the gate, each with what `load_scene` is told."""


def load(name: str) -> ddgi.Scene:
    return ddgi.load_scene(name, size=SIZE, **SCENES[name])


def region_means(picture: np.ndarray) -> np.ndarray:
    """(H, W, 3) to (H / REGION, W / REGION, 3)."""
    height, width, channels = picture.shape
    cut = picture.reshape(height // REGION, REGION, width // REGION, REGION, channels)
    return cut.mean((1, 3), dtype=np.float64)


def error(name: str, means: np.ndarray) -> float:
    """Mean FLIP of what is rendered today against the region means of a reference."""
    outcome = run(load(name), Trial("default", ddgi.RenderSettings.preset("default")), FRAMES)
    return difference(region_means(outcome.picture).astype(np.float32), means.astype(np.float32)).flip_mean


def main() -> None:
    from ddgi.judge.reference import make_reference

    kept = {}
    for name in SCENES:
        scene = load(name)
        reference = make_reference(scene, scene.camera, TARGET, most_seconds=120)
        means = np.array(
            [[[float(f"{c:.5g}") for c in px] for px in row] for row in region_means(reference.picture)]
        )
        noise = difference(*(region_means(half).astype(np.float32) for half in reference.halves)).flip_mean
        kept[name] = {
            "spp": reference.spp,
            "noise": round(noise, 4),
            "flip_mean": round(error(name, means), 4),
            "means": means.tolist(),
        }
    KEPT.write_text(json.dumps(kept, separators=(",", ":")).replace('},"', '},\n"') + "\n")


if __name__ == "__main__":
    main()
