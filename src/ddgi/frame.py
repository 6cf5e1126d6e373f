"""One frame, top to bottom."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.errors import SettingsError
from ddgi.extrema import at_least
from ddgi.lighting.lights import Lights
from ddgi.passes import picture as pictures
from ddgi.passes.gbuffer import gbuffer
from ddgi.passes.gloss import mirrored
from ddgi.passes.nearby import nearby
from ddgi.passes.picture import Picture, accumulate
from ddgi.passes.shade import shade
from ddgi.probes import query, states
from ddgi.probes.bounce import Illumination, around
from ddgi.probes.field import IrradianceField
from ddgi.probes.update import update
from ddgi.replay import Replayed
from ddgi.sampling import Clock, clock
from ddgi.scene.camera import Camera
from ddgi.scene.scene import Scene
from ddgi.settings import RenderSettings
from ddgi.trace.mesh import MeshTracer


@dataclass
class Frame:
    """What one call of `render_frame` shows: the mean of the frames handed on to it."""

    camera: Camera
    picture: Picture

    @staticmethod
    def empty(camera: Camera, settings: RenderSettings) -> Frame:
        """A picture of nothing yet: what is handed on as `previous` of the first frame of a still."""
        return Frame(camera, pictures.empty(camera.size, settings.picture))

    def __repr__(self) -> str:
        return f"Frame({self.size[0]}x{self.size[1]}, camera {self.camera.name!r})"

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) [pixels]."""
        return self.camera.size

    @property
    def image(self) -> mi.TensorXf:
        """Radiance (H, W, 3), linear Rec.709 [W/(m^2 sr)]."""
        return self._tensor(self.picture.radiance, 3)

    @property
    def layers(self) -> dict[str, mi.TensorXf]:
        """The layers by name, (H, W, channels); empty unless `picture.layers` is set."""
        shown = {n: at_least(x, 0) if n in pictures.FROM_FIELD else x for n, x in self.picture.layers.items()}
        return {name: self._tensor(x, pictures.CHANNELS[name]) for name, x in shown.items()}

    @property
    def non_finite(self) -> int:
        """Pixel values so far that were not numbers and are shown black."""
        return int(self.picture.non_finite[0])

    def numpy(self) -> np.ndarray:
        """The image as a NumPy array, (H, W, 3) float32."""
        return np.array(self.image)

    def _tensor(self, x, channels: int) -> mi.TensorXf:
        return mi.TensorXf(dr.ravel(x), (self.size[1], self.size[0], channels))


def render_frame(
    scene: Scene,
    field: IrradianceField,
    camera: Camera,
    tick: int,
    settings: RenderSettings,
    previous: Frame | None = None,
) -> tuple[IrradianceField, Frame]:
    """Render one frame: advance the field by one update, then light the camera's pixels with it.

    Args:
        scene: What there is.
        field: The field so far; not changed.
        camera: Where the picture is taken from.
        tick: Number of the frame; with `settings.seed` the only source of randomness.
        settings: Constants of every stage. New values compile anew once.
        previous: The frame before, while the scene stays as it is: pictures then average, which
            smooths edges and noise, and light of what is near can be looked for (`contact.pixels`).
            `Frame.empty` starts such a still; None, and a frame of another camera, a picture by itself.

    Returns:
        The field after the update, and the frame.

    Raises:
        SettingsError: The field was fitted for other `volume` settings or another
            `query.sqrt_blending`, or `tick` is no whole number from 0 to 2^32 - 1.
    """
    time = _time(field, tick, settings)
    field = updated(scene, field, tick, settings)
    return field, _exposed(scene, field, camera, time, settings, previous)


def render_view(
    scene: Scene,
    field: IrradianceField,
    camera: Camera,
    tick: int,
    settings: RenderSettings,
    previous: Frame | None = None,
) -> Frame:
    """Light a camera's pixels with a field as it is. Arguments and errors as of `render_frame`."""
    return _exposed(scene, field, camera, _time(field, tick, settings), settings, previous)


def _time(field: IrradianceField, tick: int, settings: RenderSettings) -> Clock:
    """The clock of a frame; a tick that is none is refused."""
    if not isinstance(tick, int) or not 0 <= tick < 2**32:
        raise SettingsError(f"tick must be a whole number from 0 to 2^32 - 1, not {tick!r}")
    field.check(settings)
    return clock(settings.seed, tick)


def _exposed(
    scene: Scene,
    field: IrradianceField,
    camera: Camera,
    time: Clock,
    settings: RenderSettings,
    previous: Frame | None,
) -> Frame:
    if previous is None or not _goes_on(previous, camera, settings):
        previous, settings = Frame.empty(camera, settings), by_itself(settings)
    before = previous.picture
    return Frame(camera, expose()(settings, scene.tracer, scene.lights, field, camera, time, before))


def by_itself(settings: RenderSettings) -> RenderSettings:
    """The settings of a frame that no others are added to: without what only their mean can show."""
    return replace(
        settings, contact=replace(settings.contact, pixels=0.0), gloss=replace(settings.gloss, bounces=0)
    )


def _goes_on(previous: Frame, camera: Camera, settings: RenderSettings) -> bool:
    """Whether a frame shows what the next one will, so that they may be averaged."""
    return previous.camera.same_view(camera) and bool(previous.picture.layers) == settings.picture.layers


def updated(scene: Scene, field: IrradianceField, tick: int, settings: RenderSettings) -> IrradianceField:
    """The field after an update, without a picture. Arguments as of `render_frame`.

    Probes around what can move are awake (SCALE 6.3), wherever that is now.
    """
    if boxes := scene.moving_boxes:
        field = field.wake(scene, boxes, settings)
    volumes = [states.attend(vol, scene.tracer, tick, settings) for vol in field.volumes]
    field = replace(field, volumes=volumes)
    return advance()(settings, scene.tracer, scene.lights, field, clock(settings.seed, tick))


@cache
def advance() -> Replayed:
    """The update of the field, recorded once and replayed."""
    return Replayed(update)


@cache
def expose() -> Replayed:
    """The picture, recorded once and replayed."""
    return Replayed(take_picture)


def take_picture(
    tracer: MeshTracer,
    lights: Lights,
    field: IrradianceField,
    camera: Camera,
    time: Clock,
    previous: Picture,
    s: RenderSettings,
) -> Picture:
    """Light what the camera sees, and add it to the picture so far."""
    surface = gbuffer(tracer, camera, time, s.gbuffer)
    by = Illumination(tracer, lights, field.volumes[0], time, s.gather, s.direct, s.query, s.volume)
    there = around(by, surface, whole=True)
    ambient = query.irradiance_by(by.vol, there.at, there.probes, s.volume, s.query)
    near = nearby(by, surface, there, s.contact)
    reflections = mirrored(by, surface, ambient, s.gloss) if tracer.shining else None
    shaded = shade(tracer, lights, surface, tracer.shining, time, s.direct, ambient + near, reflections)
    return accumulate(previous, surface, shaded, s.picture)
