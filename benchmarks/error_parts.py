"""Take the error of the default apart: what remains as one part after another is made ideal.

    python benchmarks/error_parts.py         # into docs/results/parts.json

Each row keeps the ideal parts of the rows above it:

- noise: 1,024 rays and 128 light paths a probe;
- near: light from what is near in every pixel and hit, not in one of four;
- angles: 32 x 32 irradiance and 64 x 64 distance texels;
- feedback: full paths of 12 surfaces per probe ray, in place of last frame's field;
- visibility: a ray from every probe to every pixel's point, in place of the Chebyshev bound;
- space: eight times the probes, of 512 rays.

Encoding is judged against the row before: the maps' formats and γ, made worse one by one. Takes minutes on a GPU, hours on a CPU.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager

from ddgi import frame  # isort: skip  # before Dr.Jit: it loads LLVM once

import drjit as dr

from ddgi.probes import query
from studies import RESULTS, View, judged, machine, trials

VIEWS = tuple(
    View(name, materials="diffuse")
    for name in ("cornell-point", "statue-box", "color-boxes", "ceiling-hole", "dragon-box")
)
FRAMES = 64
NOISE = "rays.per_probe=1024; rays.from_lamps=128"
NEAR = f"{NOISE}; contact.every=1"
ANGLES = f"{NEAR}; volume.irradiance_size=32; volume.distance_size=64"
PATHS = f"{ANGLES}; gather.bounces=path; gather.path_length=12"
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


def main() -> None:
    """Measure all views."""
    rows = []
    for view in VIEWS:
        steps = judged([view], trials(*(f"{name}: {sets}" for name, sets in STEPS.items())), frames=FRAMES)[0]
        parts = {name: steps["configurations"][name] for name in STEPS}
        with traced_visibility():
            exact = judged(
                [view],
                trials(f"visibility: {PATHS}", f"space: {PATHS}; rays.per_probe=512; grid.budget=16384"),
                frames=FRAMES,
            )[0]["configurations"]
        encoded = judged([view], trials(*(f"{n}: {s}" for n, s in ENCODINGS.items())), frames=FRAMES)[0]
        rows.append(
            {
                "name": view.name,
                "reference_flip": steps["reference_flip"],
                "parts": parts | exact,
                "encodings": encoded["configurations"],
            }
        )
    found = {"machine": machine(), "rows": rows}
    (RESULTS / "parts.json").write_text(json.dumps(found, indent=1, allow_nan=False) + "\n")


if __name__ == "__main__":
    main()
