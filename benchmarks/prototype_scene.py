"""Our frame on the prototype's scene and volume, and the prototype's own frame in the same minute.

    python benchmarks/prototype_scene.py [PATH/TO/PROTOTYPE/frame.py]

A Cornell box that holds a blob of 123k triangles, lit by one point light; 16x8x16 probes of 128
rays; 640x360 pixels. Times differ between machines and minutes, so only the ratio means something.
"""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import ddgi
from ddgi.bench.steady import Steady, measure
from ddgi.scene.mesh_keys import mesh

SIZE, COUNTS, RAYS = (640, 360), (16, 8, 16), 128
INSET = 0.05
"""How far inside the box's walls the outer probes stand [m]."""
SETTLED = 5
"""Frames of the prototype before its times count: the first ones compile."""


def blob(n: int = 248) -> Any:
    """A sphere with waves on it: 2 (n - 1)^2 triangles."""
    u, v = np.meshgrid(np.linspace(0, np.pi, n), np.linspace(0, 2 * np.pi, n), indexing="ij")
    r = 0.28 + 0.05 * np.sin(9 * u) * np.cos(11 * v)
    positions = np.stack([r * np.sin(u) * np.cos(v), r * np.cos(u) - 0.1, r * np.sin(u) * np.sin(v)], -1)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel()
    faces = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    return mesh("blob", positions.reshape(-1, 3), faces, bsdf={"type": "diffuse"})


def scene() -> ddgi.Scene:
    """The prototype's scene: its luminaire is plain geometry, the light a point."""
    import mitsuba as mi

    box = mi.cornell_box()
    del box["light"]["emitter"]
    bulb = {"type": "point", "position": [0, 0.7, 0], "intensity": {"type": "rgb", "value": 1.0}}
    return ddgi.load_scene(box | {"blob": blob(), "bulb": bulb}, size=SIZE)


def settings(box: Any) -> ddgi.RenderSettings:
    """Ours, on the prototype's volume."""
    s = ddgi.RenderSettings.preset("default")
    low, high = (tuple(x + INSET for x in box[0]), tuple(x - INSET for x in box[1]))
    grid = replace(s.grid, box=(low, high), counts=COUNTS, margin=0.0)
    return replace(s, grid=grid, rays=replace(s.rays, per_probe=RAYS))


def ours() -> Steady:
    """Measured as `ddgi bench` does."""
    room = scene()
    return measure(room, settings(room.bounds))


def theirs(script: Path) -> float:
    """Median time of the prototype's frames [ms]."""
    command = [
        sys.executable,
        "frame.py",
        "x".join(map(str, COUNTS)),
        str(RAYS),
        "x".join(map(str, SIZE)),
    ]
    with TemporaryDirectory() as folder:  # it writes a picture where it runs
        # Pixels that see nothing have no normal; on some processors it would look their light up out of bounds.
        safe = "irradiance(dr.select(valid, si.p, Point3f(0)), dr.select(valid, n, mi.Normal3f(0, 0, 1)),"
        source = script.read_text().replace("irradiance(si.p, n,", safe)
        Path(folder, "frame.py").write_text(source)
        out = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout
    frames = [float(ms) for ms in re.findall(r"all +([\d.]+) ms", out)]
    return median(frames[SETTLED:])


def main() -> None:
    """Print our times and, given the prototype, the ratio: before and after ours, as machines drift."""
    ddgi.use_backend("llvm")  # also points the prototype, which inherits our environment, at the same LLVM
    script = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    before = theirs(script) if script else None
    run = ours()
    print(
        f"frame {run.frame_ms:.1f} ms, update {run.update_ms:.1f}, camera {run.camera_ms:.1f}, outside kernels {run.overhead_ms:.2f}"
    )
    if script and before:
        after = theirs(script)
        prototype = (before + after) / 2
        print(
            f"prototype {prototype:.1f} ms ({before:.1f} before, {after:.1f} after): ratio {run.frame_ms / prototype:.2f}"
        )


if __name__ == "__main__":
    main()
