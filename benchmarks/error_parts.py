"""Take the error of the default apart: what remains as one part after another is made ideal.

    python benchmarks/error_parts.py                            # all views, into docs/results/parts.json
    python benchmarks/error_parts.py statue-box ceiling-hole    # some

Each row keeps the ideal parts of the rows above it:

- noise: 512 rays and 64 light paths a probe;
- near: light from what is near in every pixel and hit, not in one of four;
- angles: 24 x 24 irradiance and 32 x 32 distance texels;
- visibility: a ray from every probe to every pixel's point, in place of the Chebyshev bound;
- space: four times the probes, of 256 rays;
- feedback, held against `angles`: full paths of 8 surfaces per probe ray, in place of last frame's field.

Encoding is judged against `default`: the maps' formats and γ, made worse one by one. Takes minutes on a GPU, ten
a view on two cores.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ddgi import frame  # isort: skip  # before Dr.Jit: it loads LLVM once

import drjit as dr

from ddgi.probes import query
from studies import RESULTS, View, judged, machine, trials

VIEWS = tuple(
    View(name, materials="diffuse")
    for name in ("cornell-point", "statue-box", "color-boxes", "ceiling-hole", "dragon-box")
)
FRAMES = 48
NOISE = "rays.per_probe=512; rays.from_lamps=64"
NEAR = f"{NOISE}; contact.every=1"
ANGLES = f"{NEAR}; volume.irradiance_size=24; volume.distance_size=32"
PATHS = f"{ANGLES}; gather.bounces=path; gather.path_length=8"
STEPS = {
    "default": "",
    "noise": NOISE,
    "near": NEAR,
    "angles": ANGLES,
    "feedback": PATHS,
}
ENCODINGS = {
    "γ = 5": "blend.gamma=5",
    "16 bit": "volume.irradiance_format=float16; volume.distance_format=float16",
    "r11g11b10 and 8 bit distances": "volume.irradiance_format=r11g11b10; volume.distance_format=unorm8",
}


@contextmanager
def traced_visibility() -> Iterator[None]:
    """Every pixel asks a ray whether a probe sees its point."""
    bound, recorded = query._visibility, frame.expose

    def visible_by(tracer, vol, probe, from_probe, active):
        start = vol.grid.position(probe)
        length = dr.norm(from_probe)
        direction = from_probe / dr.maximum(length, 1e-9)
        origin = dr.fma(direction, length * 1e-3, start)
        return tracer.visible(origin, direction, length * (1 - 2e-3), active)

    def picture(settings, tracer, *arguments):
        # Not replayed: a recording would have to know the tracer.
        query._visibility = lambda vol, probe, from_probe, unit, active, *_: visible_by(
            tracer, vol, probe, from_probe, active
        )
        try:
            return frame.take_picture(tracer, *arguments, settings)
        finally:
            query._visibility = bound

    frame.expose = lambda: picture  # type: ignore[assignment,return-value]
    try:
        yield
    finally:
        frame.expose = recorded


def apart(view: View) -> dict[str, Any]:
    """One view's rows."""
    steps = judged([view], trials(*(f"{name}: {sets}" for name, sets in STEPS.items())), frames=FRAMES)[0]
    done = steps["configurations"]
    with traced_visibility():
        finer = f"{ANGLES}; rays.per_probe=256; grid.budget=8192"
        exact = judged([view], trials(f"visibility: {ANGLES}", f"space: {finer}"), frames=FRAMES)[0]
    encoded = judged([view], trials(*(f"{n}: {s}" for n, s in ENCODINGS.items())), frames=FRAMES)[0]
    chain = {name: done[name] for name in STEPS if name != "feedback"}
    return {
        "name": view.name,
        "reference_flip": steps["reference_flip"],
        "parts": chain | exact["configurations"] | {"feedback": done["feedback"]},
        "encodings": encoded["configurations"],
    }


def main(names: Sequence[str]) -> None:
    """Measure views, all without a name."""
    rows = []
    for view in VIEWS:
        if names and view.name not in names:
            continue
        rows.append(apart(view))
        found = {"machine": machine(), "rows": rows}  # after each: the next may take long
        (RESULTS / "parts.json").write_text(json.dumps(found, indent=1, allow_nan=False) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
