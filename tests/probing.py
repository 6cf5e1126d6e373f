"""What the tests of the probe core share: small scenes, fields made by hand, and readers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.probes import formats, grid, query
from ddgi.probes.awake import Awake
from ddgi.probes.field import IrradianceField
from ddgi.probes.texel_fit import texel_fit
from ddgi.probes.update import update
from ddgi.probes.volume import ProbeVolume
from ddgi.sampling import WALLS, Clock, clock
from ddgi.settings import RenderSettings
from ddgi.trace.surface import Surface, slack

# ---- settings --------------------------------------------------------------------------------------


def changed(settings: RenderSettings, **values: Any) -> RenderSettings:
    """Settings with other values; `blend_gamma=1.0` means blend.gamma, as no group's name has a "_"."""
    for name, value in values.items():
        group, _, field = name.partition("_")
        if not field:
            settings = replace(settings, **{group: value})
        else:
            settings = replace(settings, **{group: replace(getattr(settings, group), **{field: value})})
    return settings


def small(**values: Any) -> RenderSettings:
    """The default preset with few probes, rays, texels and samples."""
    few = {
        "grid_counts": (4, 4, 4), "rays_per_probe": 64, "volume_distance_size": 8, "volume_irradiance_size": 6,
        "direct_camera_samples": 1, "direct_probe_samples": 1,
    }  # fmt: skip
    return changed(RenderSettings.preset("default"), **(few | values))


# ---- scenes ----------------------------------------------------------------------------------------


def load(source: Any, **options: Any):
    from ddgi.scene.load import load_scene

    return load_scene(source, **options)


def rgb(*value: float) -> dict[str, Any]:
    return {"type": "rgb", "value": list(value if len(value) == 3 else value * 3)}


def diffuse(albedo: float, *, two_sided: bool = False) -> dict[str, Any]:
    bsdf = {"type": "diffuse", "reflectance": rgb(albedo)}
    return {"type": "twosided", "bsdf": bsdf} if two_sided else bsdf


def dark_light() -> dict[str, Any]:
    """A light that gives none: a scene without any light would be given a sky."""
    return {"type": "point", "position": [0.0, 0.0, 0.0], "intensity": rgb(0.0)}


def room(bsdf: dict[str, Any], half: float = 1.0, **more: Any) -> dict[str, Any]:
    """A closed cube seen from inside (its faces look inwards)."""
    to_world = mi.ScalarTransform4f().scale(half)
    return {
        "type": "scene",
        "room": {"type": "cube", "to_world": to_world, "flip_normals": True, "bsdf": bsdf},
        **more,
    }


def camera_in(size: tuple[int, int] = (32, 24)):
    """A camera near the +z end of a room of half size 1, looking down -z."""
    from ddgi.scene.camera import look_at

    return look_at((0.05, 0.1, 0.8), (0.1, -0.1, -1.0), fov=75.0, size=size)


# ---- fields ----------------------------------------------------------------------------------------


def lattice(counts=(3, 3, 3), origin=(0.0, 0.0, 0.0), spacing=(1.0, 1.0, 1.0)) -> grid.ProbeGrid:
    return grid.ProbeGrid(
        tuple(counts), dr.opaque(mi.Point3f, list(origin)), dr.opaque(mi.Vector3f, list(spacing))
    )


def with_gutter(maps: np.ndarray) -> np.ndarray:
    """(P, n, n, C) maps with their border: an edge texel's neighbour beyond the edge is its mirror image."""
    wide = np.pad(maps, ((0, 0), (1, 1), (1, 1), (0, 0)), mode="edge")
    wide[:, 0], wide[:, -1] = wide[:, 0, ::-1].copy(), wide[:, -1, ::-1].copy()
    wide[:, :, 0], wide[:, :, -1] = wide[:, ::-1, 0].copy(), wide[:, ::-1, -1].copy()
    for y in (0, -1):  # beyond a corner lies the opposite one
        for x in (0, -1):
            wide[:, y, x] = maps[:, -1 - y, -1 - x]
    return wide


def hand_made(
    layout: grid.ProbeGrid, settings: RenderSettings, radiance: np.ndarray, moments: np.ndarray | None = None
) -> ProbeVolume:
    """A volume that stores given maps.

    Args:
        radiance: S, (P, 3) one value in all directions, or (P, n, n, 3).
        moments: Mean and mean square of distance in reach units, (P, 2) or (P, n, n, 2); by
            default everything is visible.
    """
    s = settings.volume
    count = layout.size
    if moments is None:
        moments = np.ones((count, 2))
    whole = lambda a, n: a if a.ndim == 4 else np.broadcast_to(a[:, None, None], (count, n, n, a.shape[-1]))  # noqa: E731
    stored = with_gutter(whole(np.asarray(radiance, np.float64), s.irradiance_size)) ** query.lookup_exponent(
        settings.query
    )
    distances = with_gutter(whole(np.asarray(moments, np.float64), s.distance_size))
    return ProbeVolume(
        layout,
        Awake(layout.size),
        formats.pack(formats.IRRADIANCE[s.irradiance_format], mi.Color3f(*_lanes(stored)), mi.Float(0.5)),
        formats.pack(formats.DISTANCE[s.distance_format], mi.Vector2f(*_lanes(distances)), mi.Float(0.5)),
        _radiance(np.asarray(radiance, np.float64), s),
        dr.opaque(mi.UInt32, 1, count),
        texel_fit(s.irradiance_size),
    )


def _radiance(radiance: np.ndarray, s: Any):
    """Maps of radiance that show the same, texel for texel; None if there are to be none."""
    size = s.radiance_size
    if not size:
        return None
    if radiance.ndim == 2:
        radiance = radiance[:, None, None]
    nearest = np.arange(size) * radiance.shape[1] // size
    stored = with_gutter(radiance[:, nearest][:, :, nearest])
    return formats.pack(formats.IRRADIANCE[s.irradiance_format], mi.Color3f(*_lanes(stored)), mi.Float(0.5))


def _lanes(maps: np.ndarray) -> list[mi.Float]:
    return [floats(maps[..., c].ravel()) for c in range(maps.shape[-1])]


def floats(array) -> mi.Float:
    """NumPy to Dr.Jit, moved into Dr.Jit's own memory: kernels are compiled per alignment."""
    out = mi.Float(np.ascontiguousarray(array, np.float32)) * dr.opaque(mi.Float, 1)
    dr.eval(out)
    return out


def points(array) -> mi.Point3f:
    return mi.Point3f(*(floats(c) for c in np.asarray(array, np.float64).reshape(-1, 3).T))


def query_at(
    vol: ProbeVolume, settings: RenderSettings, position, normal, viewer=None, tap=None
) -> np.ndarray:
    """(N, 3) irradiance that the query returns."""
    position = np.asarray(position, np.float64).reshape(-1, 3)
    normal = np.broadcast_to(np.asarray(normal, np.float64), position.shape)
    viewer = normal if viewer is None else np.broadcast_to(np.asarray(viewer, np.float64), position.shape)
    at = receiver(position, normal, viewer, np.ones(len(position), bool))
    e = query.irradiance(vol, at, settings.volume, settings.query, None, tap)
    return np.array(e).T.reshape(-1, 3)


def receiver(position, normal, viewer, active) -> query.Receiver:
    """Points that ask for light. (N, 3) arrays; active: (N,)."""
    place = points(position)
    directions = (mi.Vector3f(points(v)) for v in (normal, viewer))
    return query.Receiver(place, *directions, floats(active) > 0.5, place)


def updated(
    scene, settings: RenderSettings, ticks: int, field: IrradianceField | None = None
) -> IrradianceField:
    """The field after updates; recorded and replayed if there are many."""
    field = IrradianceField.fit(scene, settings) if field is None else field
    step = dr.freeze(update) if ticks > 6 else update
    for tick in range(ticks):
        field = step(scene.tracer, scene.lights, field, clock(settings.seed, tick), settings)
        dr.eval(field)
    return field


# ---- directions and surfaces -----------------------------------------------------------------------


def sphere_points(count: int, seed: int = 1) -> np.ndarray:
    """(count, 3) uniformly distributed unit vectors."""
    v = np.random.default_rng(seed).normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def surface_at(
    position, normal, *, viewer=None, base=1.0, metallic=0.0, alpha=1.0, specular=0.0, disney=False
) -> Surface:
    """A front surface at each point."""
    position = np.asarray(position, np.float64).reshape(-1, 3)
    n = len(position)
    normal = np.broadcast_to(np.asarray(normal, np.float64), (n, 3))
    viewer = normal if viewer is None else np.broadcast_to(np.asarray(viewer, np.float64), (n, 3))
    return Surface(
        valid=dr.full(mi.Bool, True, n),
        front=dr.full(mi.Bool, True, n),
        back=dr.full(mi.Bool, False, n),
        distance=dr.full(mi.Float, 1, n),
        position=points(position),
        slack=slack(points(position), dr.opaque(mi.Float, 1)),
        normal=mi.Normal3f(points(normal)),
        geometric_normal=mi.Normal3f(points(normal)),
        to_viewer=mi.Vector3f(points(viewer)),
        base=mi.Color3f(dr.full(mi.Float, base, n)),
        metallic=dr.full(mi.Float, metallic, n),
        alpha=dr.full(mi.Float, alpha, n),
        specular=dr.full(mi.Float, specular, n),
        disney=dr.full(mi.Bool, disney, n),
        emission=mi.Color3f(dr.zeros(mi.Float, n)),
    )


def surfaces_in(scene, low, high, count: int = 4096) -> Surface:
    """Surfaces that random rays meet, from random places in a box: the same at every call."""
    rng = np.random.default_rng(1)
    place = rng.uniform(np.array(low) + 0.01, np.array(high) - 0.01, (count, 3))
    way = rng.normal(size=(count, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    return scene.tracer.intersect(
        mi.Point3f(place.T), mi.Vector3f(way.T), mi.Bool(True), time=clock(0, 0), stream=WALLS
    )


def many_ticks(count: int, seed: int = 0) -> Clock:
    """A clock whose lanes are successive ticks: statistics over frames in one go."""
    return Clock(dr.opaque(mi.UInt32, seed), dr.arange(mi.UInt32, count))
