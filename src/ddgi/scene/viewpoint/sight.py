"""What rays see, for whoever has to choose where to stand: geometry, and a first guess of the light."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi import sampling
from ddgi.lighting import direct
from ddgi.lighting.lights import Lights, environment_radiance
from ddgi.luminance import LUMINANCE
from ddgi.trace.surface import Surface, matt_bounce
from ddgi.trace.tracer import Tracer

BOUNCES = 3
"""Surfaces along a path of the guess: behind a door, light from the next room arrives with the third."""


@dataclass(frozen=True)
class Sight:
    """What rays met; arrays have the rays' shape, those of vectors (..., 3)."""

    distance: np.ndarray  # [m], infinite where nothing was met
    front: np.ndarray  # bool, met on the side that its normals look to
    black: np.ndarray  # bool, a single-sided surface from behind
    position: np.ndarray  # [m]
    normal: np.ndarray  # unit, towards the viewer
    albedo: np.ndarray  # RGB

    @property
    def hit(self) -> np.ndarray:
        """Whether anything was met."""
        return np.isfinite(self.distance)


def see(tracer: Tracer, origin: np.ndarray, direction: np.ndarray) -> Sight:
    """Trace rays. origin: (..., 3) [m], direction: (..., 3) unit; the two are broadcast."""
    origin, direction = np.broadcast_arrays(origin, direction)
    shape = direction.shape[:-1]
    surface = tracer.intersect(
        mi.Point3f(_columns(origin)), mi.Vector3f(_columns(direction)), mi.Bool(True),
        time=sampling.clock(0, 0), stream=sampling.VIEWPOINT,
    )  # fmt: skip
    dr.eval(surface)
    valid, front, black = (_lanes(x, shape) for x in (surface.valid, surface.front, surface.back))
    distance = np.where(valid, _lanes(surface.distance, shape), np.inf)
    vectors = (surface.position, surface.geometric_normal, surface.albedo)
    return Sight(distance, front, black, *(np.stack([_lanes(c, shape) for c in v], -1) for v in vectors))


def brightness(tracer: Tracer, lights: Lights, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Luminance that arrives along rays, by one path of a few bounces each: noisy. Arguments as of `see`."""
    origin, direction = np.broadcast_arrays(origin, direction)
    time, lane = sampling.clock(0, 0), dr.arange(mi.UInt32, direction[..., 0].size)
    at, along = mi.Point3f(_columns(origin)), mi.Vector3f(_columns(direction))
    seen, throughput, active = mi.Color3f(0), mi.Color3f(1), mi.Bool(True)
    for bounce in range(BOUNCES):
        time = sampling.clock(0, bounce)
        surface = tracer.intersect(at, along, active, time=time, stream=sampling.VIEWPOINT)
        arriving = environment_radiance(lights, along, active & ~surface.valid)
        if bounce == 0:  # later on, area lights were sampled already
            arriving += surface.emission
        seen += throughput * (arriving + _reflected(tracer, lights, surface, time))
        throughput *= surface.albedo
        active = active & surface.lit
        at, along = matt_bounce(surface, sampling.uniform_2d(time, sampling.VIEWPOINT, lane))
        dr.eval(seen, throughput, active, at, along)
    return (np.nan_to_num(np.array(seen).T, posinf=0) @ LUMINANCE).reshape(direction.shape[:-1])


def _reflected(tracer: Tracer, lights: Lights, surface: Surface, time: sampling.Clock) -> mi.Color3f:
    found = direct.direct_light(
        tracer, lights, surface, direct.Settings(),
        time=time, stream=sampling.VIEWPOINT, samples=1, specular=False,
    )  # fmt: skip
    return dr.select(surface.lit, surface.albedo * found.irradiance * dr.inv_pi, 0)


def _columns(vectors: np.ndarray) -> list[mi.Float]:
    """(..., 3) to three arrays in Dr.Jit's own memory: kernels are compiled per alignment."""
    columns = [
        mi.Float(np.array(c, np.float32).ravel()) * dr.opaque(mi.Float, 1)
        for c in np.moveaxis(vectors, -1, 0)
    ]
    dr.eval(columns)
    return columns


def _lanes(values, shape: tuple[int, ...]) -> np.ndarray:
    """One value a ray; Dr.Jit keeps what is the same for all as one."""
    found = np.array(values)
    return np.broadcast_to(
        found.astype(np.float64) if found.dtype == np.float32 else found, int(np.prod(shape))
    ).reshape(shape)
