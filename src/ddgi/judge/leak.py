"""Leak and dark: light that comes from probes that cannot see what they light, and light that is missing.

Both are irradiance of the indirect light, over the mean of the reference's.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.judge.reference import Reference
from ddgi.luminance import LUMINANCE
from ddgi.passes.gbuffer import gbuffer
from ddgi.probes import query
from ddgi.probes.field import IrradianceField
from ddgi.sampling import clock
from ddgi.scene.scene import Scene
from ddgi.settings import RenderSettings

DARKEST_ALBEDO = 0.05
"""Pixels of a darker surface say nothing of the light on it."""
NEIGHBOURS = 5
"""Side of the squares of pixels that share an estimate of the reference's noise."""
SURE = 3.0
"""Standard deviations of the reference that missing light must exceed."""


@dataclass(frozen=True)
class Share:
    """Light in shares of the reference's mean indirect irradiance."""

    mean: float
    max: float  # 99.9th percentile of the pixels

    def figures(self) -> dict[str, float]:
        """Both by name."""
        return {"mean": self.mean, "max": self.max}


def leaked(scene: Scene, field: IrradianceField, settings: RenderSettings) -> np.ndarray:
    """Luminance of the irradiance that pixels take from probes hidden from them [W/m^2], (H, W).

    A ray from each point to where each of its eight probes stands says which; middles of pixels.
    """
    width, height = scene.camera.size
    by = replace(settings.gbuffer, antialias=False)
    at = query.Receiver.on(gbuffer(scene.tracer, scene.camera, clock(settings.seed, 0), by))
    vol, hidden = field.volumes[0], mi.Float(0)
    probes = query.shares(vol, at, settings.volume, settings.query, scene.tracer)
    lights = query.alone(vol, at, probes, settings.volume, settings.query)
    for (probe, share), light in zip(probes, lights, strict=True):
        way = vol.grid.position(probe) - at.start
        length = dr.norm(way)
        seen = scene.tracer.visible(at.start, way / length, length, at.active)
        hidden += share * mi.luminance(light) * (1 - seen)
    return np.array(hidden).reshape(height, width)


def leak(hidden: np.ndarray, truth: Reference, albedo: np.ndarray) -> Share:
    """How much light is `leaked`. hidden: (H, W); albedo: (H, W, 3) of what pixels see."""
    there, whole = _known(truth, albedo)
    return _share(np.where(there, hidden, 0), whole)


def dark(indirect: np.ndarray, truth: Reference, albedo: np.ndarray) -> Share:
    """How much indirect light is missing, beyond what noise of the reference explains.

    Args:
        indirect: (H, W, 3) radiance of a picture, its part from the field [W/(m^2 sr)].
        truth: What it should be.
        albedo: (H, W, 3) of what pixels see.
    """
    there, whole = _known(truth, albedo)
    missing = whole - _irradiance(indirect, albedo) - SURE * _deviation(truth, albedo)
    return _share(np.where(there, np.maximum(missing, 0), 0), whole)


def _known(truth: Reference, albedo: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which pixels tell the light on them, and the reference's irradiance there, 0 elsewhere. (H, W)."""
    there = np.all(albedo > DARKEST_ALBEDO, axis=-1)
    return there, np.where(there, _irradiance(truth.indirect, albedo), 0)


def _irradiance(radiance: np.ndarray, albedo: np.ndarray) -> np.ndarray:
    """Luminance of the irradiance of matt surfaces [W/m^2], (H, W)."""
    light: np.ndarray = np.pi * (radiance / np.maximum(albedo, DARKEST_ALBEDO)) @ LUMINANCE
    return light


def _deviation(truth: Reference, albedo: np.ndarray) -> np.ndarray:
    """Standard deviation of the reference's irradiance, as its halves differ around each pixel. (H, W)."""
    squared = np.square(_irradiance(truth.halves[0] - truth.halves[1], albedo))
    for axis in (0, 1):
        wide = np.pad(squared, [(NEIGHBOURS // 2,) * 2 if a == axis else (0, 0) for a in (0, 1)], mode="edge")
        squared = np.lib.stride_tricks.sliding_window_view(wide, NEIGHBOURS, axis).mean(-1)
    deviation: np.ndarray = np.sqrt(squared) / 2
    return deviation


def _share(light: np.ndarray, whole: np.ndarray) -> Share:
    mean = whole.mean()
    if mean <= 0:  # nothing bounces: there is nothing to leak or to miss
        return Share(0.0, 0.0)
    return Share(float(light.mean() / mean), float(np.percentile(light, 99.9) / mean))
