"""The other side of every comparison: Mitsuba's path tracer on the same scene, camera and lights.

It renders Mitsuba's own scene, built from what was parsed, with its BSDFs and emitters; of ours it
takes only the rays of the camera.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.scene.camera import Camera, camera_rays
from ddgi.scene.scene import Scene

MOST_LANES = 2**22
"""Rays traced at once: bounds memory."""


@dataclass(frozen=True)
class Samples:
    """The mean of some samples per pixel."""

    picture: np.ndarray  # (H, W, 3) radiance [W/(m^2 sr)]
    spp: int
    ms: float


class PathTracer:
    """Path tracing without end to the bounces, box filter."""

    def __init__(self, scene: Scene) -> None:
        """Build Mitsuba's scene."""
        self.scene = mi.parser.instantiate(mi.parser.ParserConfig(mi.variant()), scene.source)
        self.origin = scene.tracer.origin
        # Only `volpath` lets light pass where surfaces are open: `path` casts full shadows there.
        kind = "volpath" if any(map(_may_be_open, self.scene.shapes())) else "path"
        self._all = mi.load_dict({"type": kind, "max_depth": -1})
        self._direct = mi.load_dict({"type": kind, "max_depth": 2})  # one surface between lamp and eye

    def render(self, camera: Camera, spp: int, seed: int) -> Samples:
        """All light. Equal seeds give equal samples."""
        return self._render(self._all, camera, spp, seed)

    def render_direct(self, camera: Camera, spp: int, seed: int) -> Samples:
        """Emission, and what surfaces reflect of lamps and surroundings."""
        return self._render(self._direct, camera, spp, seed)

    def _render(self, integrator: mi.Integrator, camera: Camera, spp: int, seed: int) -> Samples:
        width, height = camera.size
        per_pass = max(1, min(spp, MOST_LANES // (width * height)))
        total, done, start = np.zeros((height, width, 3)), 0, perf_counter()
        while done < spp:
            count = min(per_pass, spp - done)
            total += count * self._pass(integrator, camera, count, seed + done)
            done += count
        ms = (perf_counter() - start) * 1e3
        return Samples((total / spp).astype(np.float32), spp, ms)

    def _pass(self, integrator: mi.Integrator, camera: Camera, count: int, seed: int) -> np.ndarray:
        """Mean of `count` samples per pixel."""
        width, height = camera.size
        lanes = width * height * count
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, lanes)
        pixel = dr.arange(mi.UInt32, lanes) // dr.opaque(mi.UInt32, count)  # one kernel for all counts
        origin, direction = camera_rays(camera, self.origin, pixel, mi.Point2f(sampler.next_2d()))
        ray = mi.RayDifferential3f(mi.Ray3f(origin, direction))
        radiance, _, _ = integrator.sample(self.scene, sampler, ray)
        dr.eval(radiance)  # once: each sum alone would trace the paths again
        sums = [dr.block_sum(mi.Float(c), count) for c in mi.Color3f(radiance)]
        return np.stack([np.array(s) for s in sums], -1).reshape(height, width, 3) / count


def _may_be_open(shape: mi.Shape) -> bool:
    bsdf = shape.bsdf()
    return bsdf is not None and mi.has_flag(bsdf.flags(), mi.BSDFFlags.Null)
