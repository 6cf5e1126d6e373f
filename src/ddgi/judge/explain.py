"""A pixel explained: the eight probes that light it, factor by factor, and where the error comes from.

One ingredient after the other is exchanged for its exact value: the probes' maps for such of many rays;
what they stand for, by rays from the probes; who sees the point, by rays; then the probes themselves, by
rays from the point to what lights it, which the field lights in turn; then all of it, by path tracing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from time import perf_counter
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi import sampling
from ddgi.box import Point
from ddgi.errors import SettingsError
from ddgi.frame import updated
from ddgi.judge.path_tracer import PathTracer
from ddgi.judge.watch import NOBODY, Watch
from ddgi.luminance import LUMINANCE
from ddgi.probes import glossy, query
from ddgi.probes.awake import NAMES, OFF, SLEEPING, Awake
from ddgi.probes.bounce import Illumination, around, arriving, from_field, from_lamps, reflected
from ddgi.probes.field import IrradianceField
from ddgi.probes.sight import FOLDED
from ddgi.probes.update import update
from ddgi.probes.volume import ProbeVolume
from ddgi.sampling import Clock
from ddgi.scene.camera import Camera, camera_rays
from ddgi.scene.scene import Scene
from ddgi.settings import RenderSettings
from ddgi.trace.surface import Surface, matt_bounce
from ddgi.trace.tracer import Tracer

GATHERED = 1 << 16
"""Rays from the point, and from the probes together."""
MANY = 4096
"""Rays of each probe for maps without noise."""
WITHIN = 4
"""Side of the path-traced picture of the pixel's middle, in its own pixels."""
NARROW = 1e-4
"""How wide that picture is, in pixels: the whole pixel may show an edge, or several colours, and its middle is explained."""
ANEW = 4
"""Times the probes' maps are made anew: what these differ by tells how exact their mean is."""
BATCH = 256
"""Samples of each of those at a time; batches tell their noise."""
BATCHES = (4, 4096)
"""Fewest and most of them."""
ASLEEP = (NAMES[OFF], NAMES[SLEEPING])
SHINES = 0.3
"""GGX roughness below which the share of light that mirrors is said to be in the reference."""
LATER = 1 << 20
"""Tick of the rays here: long after those of the field."""
SEED = 1 << 28
"""First seed of the path tracer."""
EXCHANGED = {
    "many rays": "noise of the probes' maps",
    "exact maps": "angular resolution of the probes' maps",
    "true visibility": "which probes see the point",
    "no probes between": "interpolation between probes",
    "path traced": "bounces beyond the first, and materials taken as matt",
}
"""What the error is that goes away with each step."""


@dataclass(frozen=True)
class ProbeShare:
    """One of the eight probes, and what it adds to the point."""

    number: int
    coordinates: tuple[int, int, int]  # in the grid
    position: Point  # where it stands, in the coordinates of the scene's file [m]
    moved: Point  # from its place in the grid [m]
    state: str  # what it is doing (`ddgi.probes.awake.NAMES`)
    trilinear: (
        float | None
    )  # factors of the weight, in [0, 1]; None for probes of another cell than the point's
    wrap: float | None
    visible: float | None  # what its distance map says (Chebyshev)
    crushed: float | None  # the product, small ones crushed
    believed: float | None  # and after `query.sight`: the shares are in proportion to these
    sees: bool  # what a ray says
    share: float  # in what is read; those of the eight add up to one
    irradiance: Point  # R, G, B of the map, for the point's normal [W/m^2]
    quiet: Point  # of its map made anew, of many rays
    exact: Point  # by rays from the probe; the field lights what they meet
    quiet_noise: float  # standard error of the luminance of `quiet` [W/m^2]
    exact_noise: float  # and of `exact`

    @property
    def weight_seen(self) -> float:
        """By all factors but visibility, if a ray sees it."""
        own = self.share if self.trilinear is None or self.wrap is None else self.trilinear * self.wrap
        return own * self.sees


@dataclass(frozen=True)
class Explanation:
    """What lights a pixel indirectly. Irradiances are R, G, B [W/m^2]."""

    pixel: tuple[int, int]
    position: Point  # of the surface at its middle, in the coordinates of the scene's file [m]
    normal: Point
    albedo: Point
    probes: list[ProbeShare]
    field: Point  # as the query gives it
    quiet: Point  # the same shares of the probes' maps made anew, of many rays
    exact: Point  # and of what rays from the probes find
    seen: Point  # of that, from the probes that a ray sees, by all factors but visibility
    gathered: Point  # by rays from the point; the field lights what they meet
    reference: Point  # by path tracing
    noise: float  # standard error of the reference's luminance [W/m^2]
    gathered_noise: float  # and of `gathered`
    notes: list[str]

    @property
    def steps(self) -> dict[str, Point]:
        """From the field's answer to the true one, by what is exchanged."""
        return {
            "field": self.field,
            "many rays": self.quiet,
            "exact maps": self.exact,
            "true visibility": self.seen,
            "no probes between": self.gathered,
            "path traced": self.reference,
        }

    @property
    def noises(self) -> dict[str, float]:
        """Standard error of the luminance of each step [W/m^2]. The field's own noise is what the first exchange shows."""
        shares, seen = [p.share for p in self.probes], [p.weight_seen for p in self.probes]
        exact = [p.exact_noise for p in self.probes]
        return {
            "field": 0.0,
            "many rays": _error_of_mean(shares, [p.quiet_noise for p in self.probes]),
            "exact maps": _error_of_mean(shares, exact),
            "true visibility": _error_of_mean(seen, exact),
            "no probes between": self.gathered_noise,
            "path traced": self.noise,
        }

    @property
    def errors(self) -> dict[str, float | None]:
        """By how much each step is off in the light that the surface reflects; None where it reflects none.

        Irradiance alone would let channels count that a saturated surface swallows, which the reference tells
        only by dividing by next to nothing.
        """
        sent = {name: luminance(np.multiply(light, self.albedo)) for name, light in self.steps.items()}
        truth = sent["path traced"]
        return {name: y / truth - 1 if truth > 0 else None for name, y in sent.items()}

    @property
    def largest_step(self) -> str:
        """Which exchange changes most, and what that is the error of, in a sentence."""
        light = [luminance(step) for step in self.steps.values()]
        dark = self.errors["field"] is None
        if dark and not any(light):
            return "the path tracer finds no indirect light here, nor is there any"
        sent = [luminance(np.multiply(step, self.albedo)) for step in self.steps.values()]
        changes = np.abs(np.diff(light if dark else sent))
        noise = np.array(list(self.noises.values())) * (1 if dark else luminance(self.albedo))
        told = changes >= 2 * np.hypot(noise[:-1], noise[1:])
        if not told.any():
            return "no step is larger than what so many rays can tell"
        number = int(np.where(told, changes, 0).argmax())
        before, after = list(self.steps)[number : number + 2]
        found = f"the largest step is from {before} to {after}: {EXCHANGED[after]}"
        return f"the path tracer finds no indirect light here; {found}" if dark else found

    def figures(self) -> dict[str, Any]:
        """All of it by name."""
        return asdict(self) | {
            "errors": self.errors, "noises": self.noises, "largest_step": self.largest_step,
        }  # fmt: skip


def luminance(light: Point | np.ndarray) -> float:
    """Luminance of R, G, B."""
    return float(np.dot(light, LUMINANCE))


def explain(
    scene: Scene,
    settings: RenderSettings,
    pixel: tuple[int, int],
    *,
    frames: int = 48,
    seconds: float = 10.0,
    watch: Watch = NOBODY,
) -> Explanation:
    """Explain a pixel of the scene's camera.

    Args:
        scene: What there is.
        settings: The configuration.
        pixel: Column and row, from (0, 0) at the top left.
        frames: Of the field, before it is read.
        seconds: Time for path tracing, about.
        watch: Told of every frame.

    Raises:
        SettingsError: The pixel lies outside the picture, shows no surface that reflects light, or the
            configuration's volume is impossible.
    """
    camera = scene.camera
    width, height = camera.size
    if not (0 <= pixel[0] < width and 0 <= pixel[1] < height):
        raise SettingsError(f"pixel {pixel[0]},{pixel[1]} lies outside the picture of {width}x{height}")
    surface = _surface(scene, camera, pixel)
    watch.phase("updating the field", frames)
    field = _updated(scene, settings, frames, watch)
    at, vol = query.Receiver.on(surface), field.volumes[0]
    probes = _probes(scene, field, at, surface, settings)
    field_light = query.irradiance(vol, at, settings.volume, settings.query, scene.tracer)
    watch.phase("path tracing the pixel")
    albedo = _point(surface.albedo)
    reference, noise = _path_traced(scene, camera, pixel, np.maximum(albedo, 1e-3), seconds)
    # The path tracer's indirect light is without emitters seen from the point, such as a sky, which the field may have.
    numbers = sampling.uniform_2d(_time(settings), sampling.PROBE_PATH, dr.arange(mi.UInt32, GATHERED))
    by_rays = _gathered(scene, field, *matt_bounce(surface, numbers), settings)
    return Explanation(
        pixel=pixel,
        position=_point(surface.position, scene.origin),
        normal=_point(surface.normal),
        albedo=albedo,
        probes=probes,
        field=_point(field_light),
        quiet=_point(np.sum([np.multiply(p.share, p.quiet) for p in probes], 0)),
        exact=_point(np.sum([np.multiply(p.share, p.exact) for p in probes], 0)),
        seen=_mean([p.exact for p in probes], [p.weight_seen for p in probes]),
        gathered=by_rays.whole,
        reference=_point(np.add(reference, by_rays.emitted)),
        noise=noise,
        gathered_noise=by_rays.noise,
        notes=list(_notes(surface, probes, vol, settings)),
    )


def _updated(scene: Scene, settings: RenderSettings, frames: int, watch: Watch) -> IrradianceField:
    """The field after some updates; nobody looks at pictures."""
    field = IrradianceField.fit(scene, settings)
    for tick in range(frames):
        field = updated(scene, field, tick, settings)
        dr.eval(field)
        watch.step()
    return field


def _surface(scene: Scene, camera: Camera, pixel: tuple[int, int]) -> Surface:
    """What the middle of the pixel shows. (1,)."""
    number = mi.UInt32(pixel[0] + pixel[1] * camera.size[0])
    origin, direction = camera_rays(camera, scene.tracer.origin, number, mi.Point2f(0.5))
    surface: Surface = scene.tracer.intersect(
        origin, direction, mi.Bool(True), time=sampling.clock(0, 0), stream=sampling.PIXEL_ALPHA
    )
    dr.eval(surface)
    if not surface.lit[0]:
        seen = "a surface that is black from behind" if surface.valid[0] else "nothing of the scene"
        raise SettingsError(f"pixel {pixel[0]},{pixel[1]} shows {seen}: choose another")
    return surface


def _probes(
    scene: Scene, field: IrradianceField, at: query.Receiver, surface: Surface, settings: RenderSettings
) -> list[ProbeShare]:
    vol, tracer = field.volumes[0], scene.tracer
    grid, s = vol.grid, settings.query
    codes = None if vol.states is None else np.array(vol.states.code)
    own = _factors(vol, at, settings, tracer)
    shares = query.shares(vol, at, settings.volume, s, tracer)
    light = query.alone(vol, at, shares, settings.volume, s)
    numbers = [int(number[0]) for number, _ in shares]
    anew = [
        query.alone(made, at, shares, settings.volume, s)
        for made in _anew(scene, field, sorted(set(numbers)), settings)
    ]
    lane = dr.arange(mi.UInt32, GATHERED // len(shares))
    ways = matt_bounce(surface, sampling.uniform_2d(_time(settings), sampling.PROBE_PATH, lane))[1]
    out = []
    for number in dict.fromkeys(numbers):  # stand-ins may be the same for several
        places = [k for k, other in enumerate(numbers) if other == number]
        k, probe = places[0], mi.UInt32(number)
        stands = grid.position(probe)
        way = stands - at.start
        length = dr.norm(way)
        sees = tracer.visible(at.start, way / length, length, at.active)
        quiet = np.array([_point(maps[k]) for maps in anew])
        by_rays = _gathered(scene, field, stands, ways, settings)
        out.append(
            ProbeShare(
                number=number,
                coordinates=tuple(int(c[0]) for c in grid.coordinates(probe)),  # type: ignore[arg-type]
                position=_point(stands, scene.origin),
                moved=_point(stands - grid.place(probe)),
                state="vigilant" if codes is None else NAMES[codes[number]],
                **own.get(number, dict.fromkeys(FACTORS)),
                sees=bool(_number(sees) > 0.5),
                share=sum(_number(shares[place][1]) for place in places),
                irradiance=_point(light[k]),
                quiet=_point(quiet.mean(0)),
                exact=by_rays.whole,
                quiet_noise=float(np.std(quiet @ LUMINANCE, ddof=1) / len(quiet) ** 0.5),
                exact_noise=by_rays.noise,
            )
        )
    return out


FACTORS = ("trilinear", "wrap", "visible", "crushed", "believed")


def _factors(
    vol: ProbeVolume, at: query.Receiver, settings: RenderSettings, tracer: Tracer
) -> dict[int, dict[str, float]]:
    """`FACTORS` of the eight probes of the cell that the point lies in, by their numbers."""
    found = query.factors(vol, at, settings.volume, settings.query)
    first, believed, _ = query.weighed(vol, at, settings.volume, settings.query, tracer, None)
    out = {}
    for k, (near, wrap, visible, weight) in enumerate(
        zip(found.near, found.wrap, found.visible, believed, strict=True)
    ):
        number = int(np.ravel(first + vol.grid.number(k & 1, k >> 1 & 1, k >> 2 & 1))[0])
        crushed = query.crushed(wrap * visible, settings.query) * near
        values = map(_number, (near, wrap, visible, crushed, weight))
        out[number] = dict(zip(FACTORS, values, strict=True))
    return out


def _anew(
    scene: Scene, field: IrradianceField, probes: list[int], settings: RenderSettings
) -> list[ProbeVolume]:
    """The volume with the maps of some probes made anew in one update, of many rays each, that keeps nothing old; `ANEW` times."""
    vol = field.volumes[0]
    awake = Awake(len(probes), mi.UInt32(probes))
    fresh = replace(vol, awake=awake, age=dr.zeros(mi.UInt32, vol.grid.size))
    s = replace(settings, rays=replace(settings.rays, per_probe=max(MANY, settings.rays.per_probe)))
    out = []
    for number in range(ANEW):
        time = sampling.clock(settings.seed, LATER + 1 + number)
        made = update(scene.tracer, scene.lights, replace(field, volumes=[fresh]), time, s)
        dr.eval(made)
        out.append(made.volumes[0])
    return out


def _time(settings: RenderSettings) -> Clock:
    """Of the rays here: long after those of the field."""
    return sampling.clock(settings.seed, LATER)


@dataclass(frozen=True)
class _ByRays:
    """Irradiance by rays [W/m^2]."""

    emitted: Point  # from emitters that are left to the field
    whole: Point  # and with what lamps and the field light
    noise: float  # standard error of its luminance


def _gathered(
    scene: Scene, field: IrradianceField, origin: mi.Point3f, direction: mi.Vector3f, settings: RenderSettings
) -> _ByRays:
    """Irradiance by rays that are distributed by the cosine. origin: (1,) or (N,) [m]; direction: (N,) unit."""
    time = _time(settings)
    by = Illumination(
        scene.tracer, scene.lights, field.volumes[0], time, settings.gather, settings.direct, settings.query,
        settings.volume,
    )  # fmt: skip
    met = scene.tracer.intersect(origin, direction, mi.Bool(True), time=time, stream=sampling.PROBE_ALPHA)
    emitted, on = arriving(by, met, direction), glossy.follow(by, met)
    light = from_lamps(by, on.surface, sampling.PROBE_LIGHT) + from_field(by, around(by, on.surface))
    whole = emitted + on.radiance + on.throughput * reflected(on.surface, light)
    dr.eval(emitted, whole)
    one, all_ = (np.pi * np.array(x, np.float64).reshape(3, -1) for x in (emitted, whole))
    noise = np.std(LUMINANCE @ all_) / all_.shape[1] ** 0.5
    return _ByRays(_point(one.mean(1)), _point(all_.mean(1)), float(noise))


def _path_traced(
    scene: Scene, camera: Camera, pixel: tuple[int, int], albedo: np.ndarray, seconds: float
) -> tuple[Point, float]:
    """Irradiance of the indirect light, path traced, and the standard error of its luminance."""
    tracer, view = PathTracer(scene), _only(camera, pixel)
    found: list[np.ndarray] = []
    start = perf_counter()
    while len(found) < BATCHES[0] or (len(found) < BATCHES[1] and perf_counter() - start < seconds):
        seed = SEED + len(found) * BATCH
        whole, direct = (f(view, BATCH, seed).picture for f in (tracer.render, tracer.render_direct))
        found.append(np.pi * (whole - direct).mean((0, 1)) / albedo)
    error = np.std(np.array(found) @ LUMINANCE, ddof=1) / len(found) ** 0.5
    return _point(np.mean(found, 0)), float(error)


def _only(camera: Camera, pixel: tuple[int, int]) -> Camera:
    """A camera that sees nothing but the middle of a pixel of another."""
    width, height = camera.size
    x, y = (2 * (pixel[0] + 0.5) / width - 1), (1 - 2 * (pixel[1] + 0.5) / height)
    aside = x * camera.right + y * camera.up
    right, up = camera.right * (NARROW / width), camera.up * (NARROW / height)
    if camera.orthographic:
        moved = camera.position + mi.Point3d(aside)
        return replace(camera, position=moved, right=right, up=up, size=(WITHIN, WITHIN))
    ahead = camera.forward + aside
    scale = dr.rcp(dr.norm(ahead))
    return replace(
        camera, forward=ahead * scale, right=right * scale, up=up * scale, near=camera.near / scale,
        size=(WITHIN, WITHIN),
    )  # fmt: skip


def _notes(
    surface: Surface, probes: list[ProbeShare], vol: ProbeVolume, settings: RenderSettings
) -> Iterator[str]:
    if not any(p.sees for p in probes):
        yield "none of the probes sees the point"
    if any(p.believed is None for p in probes):
        yield (
            "no probe of the point's own cell lights it: it is lit like the air in front of it, or by the nearest probes "
            "that are awake; the table lists those, to which the factors do not belong"
        )
    elif sum(p.believed or 0 for p in probes if p.sees) < FOLDED * sum(p.believed or 0 for p in probes):
        yield "rays from the point find next to no probe: those from the air in front of it decide (query.sight)"
    if vol.states is not None and settings.states.method != "off" and any(p.state in ASLEEP for p in probes):
        yield "probes that are asleep or off keep no light: the field found nothing near them that they could light"
    if surface.metallic[0] > 0 or (surface.specular[0] > 0 and surface.alpha[0] < SHINES):
        yield "the surface shines: the reference holds reflections too; --materials diffuse leaves them out"
    if settings.blend.warm_up == 0:
        yield "without a warm-up the field remembers the darkness it began with: ask for more --frames, or set blend.warm_up=16"


def _mean(light: list[Point], weights: list[float]) -> Point:
    total = sum(weights)
    if total <= 0:
        return 0.0, 0.0, 0.0
    return _point(np.average(light, axis=0, weights=weights))


def _error_of_mean(weights: list[float], errors: list[float]) -> float:
    """Standard error of a weighted mean."""
    total = sum(weights)
    return float(np.linalg.norm(np.multiply(weights, errors)) / total) if total > 0 else 0.0


def _number(x: Any) -> float:
    return float(np.ravel(x)[0])


def _point(x: Any, origin: Any = 0.0) -> Point:
    a, b, c = (float(v) for v in np.ravel(x) + np.ravel(origin))
    return a, b, c
