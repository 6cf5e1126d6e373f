"""Indirect light traced from the lamps: where few paths from the eye find the light, most from the lamps do.

A spot on the floor that lights a room is a rare find for paths from the camera, and noise where it
is found. Paths from the lamp all go through it, and leave some light in the picture at every bounce
(Dutre, Lafortune, Willems: "Monte Carlo light tracing with direct computation of pixel intensities", 1993).
"""

from __future__ import annotations

from time import perf_counter

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.judge.path_tracer import Samples
from ddgi.scene.camera import Camera

MOST_LANES = 2**21
"""Paths traced at once: bounds memory."""
ROULETTE_FROM = 5
"""Bounces after which paths may end by chance, as in Mitsuba's path tracer."""
MOST_SURVIVAL = 0.95


def suits(scene: mi.Scene, camera: Camera) -> bool:
    """Whether paths from the lamps reach all that the camera sees.

    They find no way to it over mirrors and glass, and too seldom one from a whole sky.
    """
    matt = int(mi.BSDFFlags.Diffuse)
    return (
        not camera.orthographic
        and scene.environment() is None
        and not any(int(shape.bsdf().flags()) & int(mi.BSDFFlags.All) & ~matt for shape in scene.shapes())
    )


class LightTracer:
    """Light that bounces at least twice between lamp and eye, without end to the bounces, box filter."""

    def __init__(self, scene: mi.Scene, origin: mi.Point3d) -> None:
        """Trace in Mitsuba's scene, whose coordinates count from `origin`."""
        self._scene, self._origin = scene, origin

    def render(self, camera: Camera, spp: int, seed: int) -> Samples:
        """Indirect light alone, from `spp` paths for every pixel. Equal seeds give equal paths."""
        width, height = camera.size
        total, start = np.zeros((height, width, 3)), perf_counter()
        paths, done = spp * width * height, 0
        while done < paths:
            count = min(MOST_LANES, paths - done)
            total += self._pass(camera, count, seed + done // MOST_LANES)
            done += count
        return Samples((total / paths).astype(np.float32), spp, (perf_counter() - start) * 1e3)

    def _pass(self, camera: Camera, count: int, seed: int) -> np.ndarray:
        """Sum of what `count` paths leave in the picture, (H, W, 3)."""
        width, height = camera.size
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, count)
        film = dr.zeros(mi.Float, 3 * width * height)
        ray, power, _ = self._scene.sample_emitter_ray(
            0.0, sampler.next_1d(), sampler.next_2d(), sampler.next_2d(), True
        )
        eye = camera.eye(self._origin)
        _walk(self._scene, camera, eye, sampler, mi.Ray3f(ray), mi.Color3f(power), film)
        return np.array(film, np.float64).reshape(height, width, 3)


@dr.syntax
def _walk(
    scene: mi.Scene,
    camera: Camera,
    eye: mi.Point3f,
    sampler: mi.Sampler,
    ray: mi.Ray3f,
    power: mi.Color3f,
    film: mi.Float,
):
    """Follow paths; every surface but the first shows what it reflects to the camera."""
    context = mi.BSDFContext(mi.TransportMode.Importance)
    depth, active = mi.UInt32(0), dr.any(power > 0)
    while active:
        found = scene.ray_intersect(ray, active)
        active &= found.is_valid()
        bsdf = found.bsdf()
        _show(scene, camera, eye, context, found, bsdf, power, film, active & (depth > 0))
        sample, weight = bsdf.sample(context, found, sampler.next_1d(active), sampler.next_2d(active), active)
        power *= mi.Color3f(weight) * _adjoint(found, sample.wo)
        ray = found.spawn_ray(found.to_world(sample.wo))
        depth += 1
        survival = dr.select(
            depth >= ROULETTE_FROM, dr.minimum(dr.max(mi.Color3f(weight)), MOST_SURVIVAL), 1.0
        )
        active &= dr.any(power > 0) & (sampler.next_1d(active) < survival)
        power *= dr.rcp(dr.maximum(survival, 1e-6))
    dr.eval(film)


def _show(
    scene, camera: Camera, eye, context, found, bsdf, power: mi.Color3f, film: mi.Float, active: mi.Bool
) -> None:
    """Add to the pixel that sees a surface what it reflects there of `power` [W]."""
    width, height = camera.size
    toward = eye - found.p
    x, y, ahead = _coordinates(camera, -toward)
    active &= (ahead > camera.near) & (x > -1) & (x < 1) & (y > -1) & (y < 1)
    distance = dr.norm(toward)
    wo = found.to_local(toward / distance)
    value = mi.Color3f(bsdf.eval(context, found, wo, active)) * _adjoint(found, wo)
    shadow = found.spawn_ray_to(eye)
    shadow.maxt *= 1 - camera.near / ahead  # what is nearer is cut away
    active &= dr.any(value > 0)
    active &= ~scene.ray_test(shadow, active)
    value *= power * _pixels_per_area(camera, toward, distance)
    pixel = mi.UInt32((1 - y) / 2 * height) * width + mi.UInt32((x + 1) / 2 * width)
    for channel in range(3):
        dr.scatter_reduce(dr.ReduceOp.Add, film, value[channel], 3 * pixel + channel, active)


def _coordinates(camera: Camera, aside: mi.Vector3f) -> tuple[mi.Float, mi.Float, mi.Float]:
    """Solve aside = ahead (forward + x right + y up), by Cramer's rule."""
    normal = dr.cross(camera.right, camera.up)
    volume = dr.dot(camera.forward, normal)
    ahead = dr.dot(aside, normal) / volume
    x = dr.dot(aside, dr.cross(camera.up, camera.forward)) / (volume * ahead)
    y = dr.dot(aside, dr.cross(camera.forward, camera.right)) / (volume * ahead)
    return x, y, ahead


def _pixels_per_area(camera: Camera, toward: mi.Vector3f, distance: mi.Float) -> mi.Float:
    """Pixels that a surface's projected area of one square metre covers, per cosine towards the camera.

    A pixel of the plane at distance one, of area A and with unit normal n, has the solid angle A (n.d)^3.
    """
    width, height = camera.size
    normal = dr.cross(camera.right, camera.up)
    area = 4 * dr.norm(normal) / (width * height)
    lens = dr.abs(dr.dot(dr.normalize(normal), camera.forward))  # distance of the picture's plane
    cosine = dr.abs(dr.dot(dr.normalize(normal), toward)) / distance
    return lens * lens / (area * dr.square(distance) * cosine * cosine * cosine)


def _adjoint(found: mi.SurfaceInteraction3f, wo: mi.Vector3f) -> mi.Float:
    """What makes light that runs backwards weigh the same with shading normals (Veach 1997, eq. 5.19)."""
    wi_n, wo_n = (dr.dot(found.n, found.to_world(w)) for w in (found.wi, wo))
    wi_s, wo_s = mi.Frame3f.cos_theta(found.wi), mi.Frame3f.cos_theta(wo)
    seen = (wi_n * wi_s > 0) & (wo_n * wo_s > 0)
    return dr.select(seen, dr.abs(wi_s * wo_n / (wi_n * wo_s)), 0)
