"""The debugging views of a scene, by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi import sampling
from ddgi.debug.atlas import distance_atlas, irradiance_atlas
from ddgi.debug.spheres import RADIUS, Hits, meet
from ddgi.judge.false_colour import INFERNO, coloured, false_colour, scale_top
from ddgi.judge.leak import leaked
from ddgi.judge.lettering import text_width, written
from ddgi.judge.watch import NOBODY, Watch
from ddgi.passes import tone
from ddgi.probes import query
from ddgi.probes.awake import NAMES, VIGILANT
from ddgi.scene.camera import camera_rays
from ddgi.scene.scene import Scene
from ddgi.settings import RenderSettings
from ddgi.still import Still, still
from ddgi.trace.surface import Surface

AS_IT_IS = tone.Settings(exposure=0.0, curve="linear")
DIMMED = 0.35
"""What is left of the picture behind what is drawn on it."""
UNMOVED = (0.25, 0.35, 0.45)
LEAST_MOVED = 0.3
"""Where on the scale of colours the least move is: below, they are too dark to be seen."""
STATES = (
    (0.9, 0.1, 0.1),  # off
    (0.25, 0.35, 0.75),  # sleeping
    (1.0, 0.8, 0.1),  # newly awake
    (0.75, 1.0, 0.3),  # newly vigilant
    (1.0, 0.5, 0.0),  # awake
    (0.1, 0.8, 0.2),  # vigilant
)
"""Colours of the states of probes, by their code; sRGB."""
SWATCH = 20
"""Height of a line of the legend [pixels]."""
PLACE = (1.0, 1.0, 1.0)
"""Colours of a probe in its place, and of the place of one that was moved; sRGB."""


@dataclass(frozen=True)
class Seen:
    """A scene through its camera: one frame's rays, what they meet, and the field that lights it."""

    scene: Scene
    settings: RenderSettings
    done: Still
    origin: mi.Point3f  # (N,) of the rays through the middles of the pixels [m]
    direction: mi.Vector3f  # (N,) unit
    surface: Surface  # (N,)

    def picture(self, lanes) -> np.ndarray:
        """(N,) or 3 x (N,) numbers as (H, W) or (H, W, 3)."""
        width, height = self.scene.camera.size
        values = np.array(lanes)
        return values.reshape(height, width) if values.ndim == 1 else values.T.reshape(height, width, 3)

    @property
    def volume(self):
        """The first of the field's."""
        return self.done.field.volumes[0]


def look(scene: Scene, settings: RenderSettings, frames: int, watch: Watch = NOBODY) -> Seen:
    """Render frames, so that the field has its light."""
    done = still(scene, settings, frames, watch.step)
    width, height = scene.camera.size
    pixel = dr.arange(mi.UInt32, width * height)
    origin, direction = camera_rays(scene.camera, scene.tracer.origin, pixel, mi.Point2f(0.5))
    surface = scene.tracer.intersect(
        origin, direction, mi.Bool(True), time=sampling.clock(settings.seed, 0), stream=sampling.PIXEL_ALPHA
    )
    return Seen(scene, settings, done, origin, direction, surface)


def probes(seen: Seen) -> np.ndarray:
    """The picture with its probes as white spheres, lit by what they hold."""
    hits, in_front = _visible(seen, RADIUS)
    # Those that give none hold nothing, or what is long over.
    gives_light = mi.Float(np.ascontiguousarray(seen.volume.grid.packets()[:, 3]))
    in_front &= dr.gather(mi.Float, gives_light, hits.probe) > 0
    at = query.Receiver(seen.surface.position, hits.normal, hits.normal, in_front, seen.surface.position)
    alone = [(hits.probe, mi.Float(1))]
    (light,) = query.alone(seen.volume, at, alone, seen.settings.volume, seen.settings.query)
    held = seen.picture(light) / np.pi
    whole = seen.done.frame.numpy()
    shown = seen.settings.tone
    if shown.exposure is None:
        shown = tone.Settings(exposure=tone.automatic_exposure(whole), curve=shown.curve)
    return _display(np.where(seen.picture(in_front)[..., None], held, whole), shown)


def offsets(seen: Seen) -> np.ndarray:
    """The picture, dimmed, with probes coloured by how far they were moved, and white dots in the places of those.

    Raises:
        DDGIError: Pillow is not installed.
    """
    grid, limit = seen.volume.grid, seen.settings.relocation.limit
    colour = np.broadcast_to(np.array(UNMOVED), (grid.size, 3)).copy()
    moved = np.zeros(grid.size, bool)
    if grid.offset is not None:
        apart = np.abs(grid.offsets()) / np.ravel(grid.spacing)
        moved = apart.any(-1)
        shares = LEAST_MOVED + (1 - LEAST_MOVED) * np.clip(apart.max(-1) / limit, 0, 1)
        colour[moved] = coloured(shares[None, moved], INFERNO)[0]
    hits, in_front = _visible(seen, RADIUS)
    picture, there = _spheres(seen, hits, in_front, colour), seen.picture(in_front)
    dots, before = _visible(seen, RADIUS / 3, places=True)
    left = seen.picture(before) & moved[seen.picture(dots.probe)]
    left &= ~(there & (seen.picture(hits.distance) < seen.picture(dots.distance)))
    picture[left] = PLACE
    lines = [(UNMOVED, f"in their places: {(~moved).sum():,}")]
    if moved.any():
        little, far = (coloured(np.array([[share]]), INFERNO)[0, 0] for share in (LEAST_MOVED, 1.0))
        lines += [
            (little, f"moved a little; all that were moved: {moved.sum():,}"),
            (far, f"moved to the limit, {limit:g} spacings along an axis"),
            (PLACE, "the places that they left"),
        ]
    return _with_legend(picture, lines)


def states(seen: Seen) -> np.ndarray:
    """The picture, dimmed, with probes coloured by their states, and a legend that counts them.

    Raises:
        DDGIError: Pillow is not installed.
    """
    vol = seen.volume
    code = np.full(vol.grid.size, VIGILANT) if vol.states is None else np.array(vol.states.code)
    picture = _spheres(seen, *_visible(seen, RADIUS), np.array(STATES)[code])
    all_are = " (states.method is off: all probes are updated)" if vol.states is None else ""
    counts = [int((code == c).sum()) for c in range(len(NAMES))]
    return _with_legend(
        picture, [(STATES[c], f"{NAMES[c]}: {n:,}{all_are}") for c, n in enumerate(counts) if n]
    )


def _with_legend(picture: np.ndarray, lines: Sequence[tuple[Sequence[float], str]]) -> np.ndarray:
    """A picture, (H, W, 3) sRGB, with a swatch and a text for each line below it, as wide as those need; uint8."""
    texts = [text for _, text in lines]
    width = max(picture.shape[1], SWATCH + 10 + max(map(text_width, texts)))
    whole = np.zeros((len(picture) + SWATCH * len(lines), width, 3))
    whole[: len(picture), : picture.shape[1]] = picture
    for number, (colour, _) in enumerate(lines):
        top = len(picture) + number * SWATCH
        whole[top + 3 : top + SWATCH - 3, 4:SWATCH] = colour
    places = [(SWATCH + 6, len(picture) + number * SWATCH + 2, text) for number, text in enumerate(texts)]
    return written(np.rint(whole * 255).astype(np.uint8), places, (255, 255, 255))


def weights(seen: Seen) -> np.ndarray:
    """Every probe has a colour, and every pixel those of its eight probes, mixed by their shares."""
    grid = seen.volume.grid
    rng = np.random.default_rng(7)
    colour = rng.uniform(0.1, 1, (grid.size, 3)).astype(np.float32)
    table = [mi.Float(np.ascontiguousarray(colour[:, c])) for c in range(3)]
    mixed = [mi.Float(0)] * 3
    for probe, share in query.shares(
        seen.volume, query.Receiver.on(seen.surface), seen.settings.volume, seen.settings.query,
        seen.scene.tracer,
    ):  # fmt: skip
        mixed = [m + share * dr.gather(mi.Float, t, probe) for m, t in zip(mixed, table, strict=True)]
    lit = dr.select(seen.surface.lit, mi.Color3f(*mixed), mi.Color3f(0))
    return _display(seen.picture(lit), AS_IT_IS)


def leak(seen: Seen) -> np.ndarray:
    """Irradiance that pixels take from probes hidden from them, in false colours with their scale."""
    hidden = leaked(seen.scene, seen.done.field, seen.settings)
    return _display(false_colour(hidden, scale_top(hidden)), AS_IT_IS)


def irradiance(seen: Seen) -> np.ndarray:
    """The irradiance maps of all probes."""
    return _display(irradiance_atlas(seen.done.field, seen.settings), seen.settings.tone)


def distance(seen: Seen) -> np.ndarray:
    """The mean distances of all probes, white where nothing is near."""
    return _display(distance_atlas(seen.done.field, seen.settings), AS_IT_IS)


VIEWS: dict[str, Callable[[Seen], np.ndarray]] = {
    "probes": probes,
    "offsets": offsets,
    "states": states,
    "weights": weights,
    "leak": leak,
    "irradiance-atlas": irradiance,
    "distance-atlas": distance,
}
"""By name; each gives a picture (H, W, 3) uint8."""


def _visible(seen: Seen, radius: float, *, places: bool = False) -> tuple[Hits, mi.Bool]:
    """The spheres in the picture, and where they are in front of what it shows."""
    hits = meet(seen.volume.grid, seen.origin, seen.direction, radius, places=places)
    wall = dr.select(seen.surface.valid, seen.surface.distance, dr.inf)
    in_front = dr.isfinite(hits.distance) & (hits.distance < wall)
    dr.eval(hits, in_front)
    return hits, in_front


def _spheres(seen: Seen, hits: Hits, in_front: mi.Bool, colour: np.ndarray) -> np.ndarray:
    """The picture, dimmed, with probes in their colours. colour: (P, 3) sRGB; result: (H, W, 3) sRGB in [0, 1]."""
    shade = 0.5 + 0.5 * seen.picture(-dr.dot(hits.normal, seen.direction))[..., None]
    there = seen.picture(in_front)[..., None]
    return np.where(there, colour[seen.picture(hits.probe)] * shade, _dimmed(seen))


def _dimmed(seen: Seen) -> np.ndarray:
    """The picture in dark grey, (H, W, 3) sRGB in [0, 1]."""
    grey = tone.tone_map(seen.done.frame.numpy(), seen.settings.tone).mean(-1, keepdims=True)
    return np.repeat(DIMMED * grey, 3, -1)


def _display(radiance: np.ndarray, shown: tone.Settings) -> np.ndarray:
    return np.rint(tone.tone_map(radiance.astype(np.float32), shown) * 255).astype(np.uint8)
