"""Mitsuba's sun-and-sky model, split: the sky as a picture, the sun as parallel light.

A sun half a degree wide is noise to whoever samples the sky; as a directional light it is exact.
"""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

SKY_SIZE = (512, 256)
"""(width, height) of the baked sky [texels]."""
SUN_SAMPLES = 1 << 16


def bake_sky(emitter: mi.Emitter) -> mi.Emitter:
    """The sky of a `sunsky`, without its sun, as an `envmap` in world space."""
    parameters = mi.traverse(emitter)
    scale = parameters["sun_scale"]
    parameters["sun_scale"] = 0.0
    parameters.update()
    try:
        return bake(emitter)
    finally:
        parameters["sun_scale"] = scale
        parameters.update()


def bake(emitter: mi.Emitter) -> mi.Emitter:
    """Any environment emitter as an `envmap` in world space."""
    width, height = SKY_SIZE
    column, row = np.meshgrid(np.arange(width), np.arange(height))
    # As Mitsuba's envmap reads its texels: columns at centres, first and last row at the poles.
    around = 2 * np.pi * (column.ravel() + 0.5) / width
    down = np.pi * row.ravel() / (height - 1)
    direction = [np.sin(around) * np.sin(down), np.cos(down), -np.cos(around) * np.sin(down)]
    radiance = _radiance(emitter, mi.Vector3f(np.array(direction, np.float32)))
    texels = np.array(radiance).T.reshape(height, width, 3)
    return mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(np.ascontiguousarray(texels, np.float32))})


def sun(emitter: mi.Emitter) -> tuple[np.ndarray, np.ndarray]:
    """The sun of a `sunsky`: (3,) direction its light travels, (3,) irradiance facing it [W/m^2]."""
    parameters = mi.traverse(emitter)
    towards = np.array(parameters["sun_direction"], np.float64).ravel()
    scale = parameters["sky_scale"]
    parameters["sky_scale"] = 0.0
    parameters.update()
    try:
        random = mi.PCG32(SUN_SAMPLES)
        u = random.next_float32()
        point = mi.Point2f(u, random.next_float32())
        interaction = dr.zeros(mi.Interaction3f, SUN_SAMPLES)
        sample, weight = emitter.sample_direction(interaction, point)
        weight = dr.select((sample.pdf > 0) & dr.all(dr.isfinite(weight)), weight, 0)
        irradiance = np.array(dr.mean(weight, axis=1), np.float64).ravel()
        if irradiance.any():
            towards = np.array(dr.sum(sample.d * dr.mean(weight), axis=1), np.float64).ravel()
    finally:
        parameters["sky_scale"] = scale
        parameters.update()
    return -towards / np.linalg.norm(towards), irradiance


def _radiance(emitter: mi.Emitter, direction: mi.Vector3f) -> mi.Color3f:
    """What arrives from where `direction` points."""
    si = dr.zeros(mi.SurfaceInteraction3f, dr.width(direction))
    si.wi = -direction
    return emitter.eval(si)
