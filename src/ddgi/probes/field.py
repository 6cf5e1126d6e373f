"""The irradiance field: all volumes, and the light anywhere in them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.backend import use_backend
from ddgi.box import Box, around, moved
from ddgi.errors import SettingsError
from ddgi.probes import formats, grid, query, region, relocation, sight, states, volume, walls
from ddgi.probes.awake import NAMES, VIGILANT
from ddgi.probes.change import Change
from ddgi.probes.haste import Event
from ddgi.probes.volume import ProbeVolume
from ddgi.trace.tracer import Tracer

if TYPE_CHECKING:
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings


@dataclass
class IrradianceField:
    """The probe field: state that `render_frame` advances."""

    volumes: list[ProbeVolume]  # one; fine to coarse when there are several
    non_finite: mi.UInt32  # (1,) rays so far whose light was not a number

    def __repr__(self) -> str:
        return f"IrradianceField({', '.join('x'.join(map(str, v.grid.counts)) for v in self.volumes)} probes)"

    @staticmethod
    def fit(scene: Scene, settings: RenderSettings, reach: Sequence[Box] = ()) -> IrradianceField:
        """An empty field over a box: `grid.box`, else the scene's own, else where its cameras' light is.

        Args:
            scene: What to light.
            settings: Of the frames to come.
            reach: Boxes that the last of these is to cover too, as where things will move, in the coordinates of
                the scene's file [m]; where things that can move are now it covers anyway.

        Raises:
            SettingsError: The volume is impossible, lies wholly outside the scene, or needs more
                memory than `grid.memory_limit`; or `contact` is on without maps of radiance.
        """
        use_backend()
        _check_contact(settings)
        asked = settings.grid.box or scene.box
        if asked and not all(a <= d and c <= b for a, b, c, d in zip(*asked, *scene.bounds, strict=True)):
            asked_for, all_there = _in_short(asked), _in_short(scene.bounds)
            raise SettingsError(f"grid.box, {asked_for}, lies wholly outside the scene, {all_there} [m]")
        here = -scene.origin[0], -scene.origin[1], -scene.origin[2]
        tracer = scene.still_tracer
        seen = region.look(tracer, scene.cameras)
        if asked:
            box = moved(asked, here)
            found = walls.find(tracer, box)
        else:
            box = region.find(tracer, seen, moved(scene.bounds, here))
            box = _covering(
                box, [moved(b, here) for b in (*scene.moving_boxes, *reach)], settings.grid.budget
            )
            found = _walls(scene, seen, box)
        layout = grid.fit(box, replace(settings.grid, box=None), found)
        vol = volume.allocate(layout, settings.volume, settings.rays.per_probe, settings.grid.memory_limit)
        vol = replace(vol, exponent=query.lookup_exponent(settings.query))
        return IrradianceField([_placed(vol, scene, seen, settings)], dr.opaque(mi.UInt32, 0))

    def check(self, settings: RenderSettings) -> None:
        """See that the maps are what the settings say; read otherwise they would show nonsense.

        Raises:
            SettingsError: The field was fitted with other settings; says which.
        """
        _check_contact(settings)
        for vol in self.volumes:
            if vol.made_for not in (None, repr(settings.volume)):
                raise SettingsError("the field was fitted with other `volume` settings: fit a new one")
            if vol.exponent is not None and vol.exponent != query.lookup_exponent(settings.query):
                raise SettingsError("the field was fitted with another `query.sqrt_blending`: fit a new one")

    @property
    def probes(self) -> int:
        """Number of probes in all volumes."""
        return sum(v.grid.size for v in self.volumes)

    def wake(self, scene: Scene, boxes: Sequence[Box], settings: RenderSettings) -> IrradianceField:
        """The field with the probes around things that move awake; those that woke for what is not there sleep again.

        For shapes that a scene can move itself (`Scene.moving_boxes`) every update does it.

        Args:
            scene: That the field was fitted for.
            boxes: Low and high corners around the things [m], in the coordinates of the scene's file; each is enlarged
                by a cell. All that move at the time: those that woke for others go back to sleep.
            settings: Those of the frames.

        Raises:
            SettingsError: A box is none: not two corners of three finite numbers, the low one first.
        """
        for box in boxes:
            _check_box(box)
        x, y, z = scene.origin
        here = [moved(box, (-x, -y, -z)) for box in boxes]
        return replace(self, volumes=[states.wake(vol, here, settings) for vol in self.volumes])

    def relocate(self, scene: Scene, settings: RenderSettings) -> IrradianceField:
        """The field with its probes placed anew, as `fit` places them in the same grid, for the scene as it is now.

        After what stands in it has changed, or `relocation` and `states` settings. Which probes see one another and
        which are asleep is found anew too. Probes keep what they gathered, but those that are moved farther than
        `relocation.rejects`.

        Args:
            scene: The scene, with the cameras that are to be served.
            settings: Those of the frames to come.
        """
        seen = region.look(scene.still_tracer, scene.cameras)
        return replace(self, volumes=[_placed(vol, scene, seen, settings) for vol in self.volumes])

    def after(self, event: Event) -> IrradianceField:
        """The field that knows of a change of the scene, and keeps less of what it has in the next updates (SCALE 4.3).

        Args:
            event: "small light", such as a flashlight switched on: 15 % less of old light for 4 updates; "large light",
                such as a jump in the time of day: 50 % less for 10; "large object", such as a ceiling that caves in:
                the same, and 50 % less of old distances for 7.

        Raises:
            SettingsError: There is no such event.
        """
        return replace(self, volumes=[replace(v, haste=v.haste.after(event)) for v in self.volumes])

    def reset(self) -> IrradianceField:
        """The same field warming up again: after a change too large for hysteresis to follow.

        Old light stays visible until the first update replaces it.
        """
        volumes = [
            replace(v, age=dr.opaque(mi.UInt32, 0, v.grid.size), change=Change.none(v.grid.size))
            for v in self.volumes
        ]
        return replace(self, volumes=volumes)


def _covering(box: Box, things: Sequence[Box], budget: int) -> Box:
    """The box enlarged to hold others too, and about a spacing around them: what is lit needs probes in front of it."""
    low, high = np.array(around([box, *things]))
    step = float(np.prod(high - low) / budget) ** (1 / 3)
    wide = [(tuple((np.array(a) - step).tolist()), tuple((np.array(b) + step).tolist())) for a, b in things]
    return around([box, *wide])


def _in_short(box: Box) -> str:
    """A box as messages have it: to a thousandth of its size, however far out it lies."""
    low, high = np.array(box)
    size = max(float((high - low).max()), np.finfo(float).tiny)
    decimals = 3 - math.ceil(math.log10(size))
    return " to ".join(
        f"({', '.join(f'{round(x, decimals):.15g}' for x in corner)})" for corner in (low, high)
    )


def _placed(vol: ProbeVolume, scene: Scene, seen: region.Seen, settings: RenderSettings) -> ProbeVolume:
    """The volume with its probes where they are to stand, what they see of one another, and what they are to do.

    By what stays where it is (SCALE 5): what moves is elsewhere soon.
    """
    before, s = vol.grid.offsets(), settings.relocation
    tracer = scene.still_tracer
    layout = relocation.relocate(tracer, replace(vol.grid, offset=None), seen, s)
    moved = np.abs(layout.offsets() - before) > s.rejects * np.ravel(layout.spacing)
    vol = replace(vol, grid=layout, sight=sight.look(tracer, layout))
    vol = vol.renewed(moved.any(-1), settings.blend.warm_up)
    return states.classify(vol, tracer, seen, settings.states, settings.blend.warm_up)


def _walls(scene: Scene, seen: region.Seen, box: Box) -> list[walls.Walls]:
    """Walls to fit planes of probes to: those seen from within the box, or, if all look at it from outside, by them."""
    low, high = np.array(moved(box, scene.origin))
    eyes = np.array([np.ravel(camera.position) for camera in scene.cameras])
    flat = (high - low).min() < grid.FLAT * (high - low).max()
    if flat or ((eyes >= low) & (eyes <= high)).all(-1).any() or not seen.weight.any():
        return walls.find(scene.still_tracer, box)
    return walls.among(seen.position, seen.normal, seen.weight, box)


def irradiance(
    field: IrradianceField,
    at: query.Receiver,
    layout: volume.Settings,
    s: query.Settings,
    tracer: Tracer | None = None,
) -> mi.Color3f:
    """Irradiance E [W/m^2] at oriented points; arguments as of `query.irradiance`."""
    return query.irradiance(field.volumes[0], at, layout, s, tracer)


def _check_box(box: Box) -> None:
    try:
        corners = np.asarray(box, float)
    except (TypeError, ValueError):
        corners = np.zeros(0)
    if corners.shape != (2, 3) or not np.isfinite(corners).all() or (corners[0] > corners[1]).any():
        raise SettingsError(f"{box!r} is no box: it takes a low and a high corner, three finite numbers each")


def probe_states(field: IrradianceField) -> list[str]:
    """What each probe is doing, by name (`ddgi.probes.awake.NAMES`), in the order of the maps. With states off all are vigilant."""
    vol = field.volumes[0]
    if vol.states is None:
        return [NAMES[VIGILANT]] * vol.grid.size
    return [NAMES[code] for code in np.array(vol.states.code)]


def _check_contact(settings: RenderSettings) -> None:
    on = [f"contact.{name}" for name in ("hits", "pixels") if getattr(settings.contact, name) > 0]
    if on and not settings.volume.radiance_size:
        off = " and ".join(f"{name}=0" for name in on)
        raise SettingsError(
            f"{' and '.join(on)} need the probes' radiance, and volume.radiance_size is 0: set {off}, or a radiance_size of 8"
        )


def irradiance_map(field: IrradianceField, settings: RenderSettings) -> np.ndarray:
    """The irradiance maps as an array, for notebooks: (P, n, n, 3) irradiance E [W/m^2], no borders.

    Probes that sleep hold zeros, or what they had (`probe_states`).
    """
    size = settings.volume.irradiance_size
    fmt = formats.IRRADIANCE[settings.volume.irradiance_format]
    stored = _texels(field.volumes[0].irradiance, fmt, size)
    return np.pi * stored ** (1 / query.lookup_exponent(settings.query))


def radiance_map(field: IrradianceField, settings: RenderSettings) -> np.ndarray:
    """The radiance maps as an array: (P, n, n, 3) radiance [W/(m^2 sr)], no borders.

    Raises:
        SettingsError: There are none: `volume.radiance_size` is 0.
    """
    size = settings.volume.radiance_size
    if not size:
        raise SettingsError("the field keeps no radiance: fit one with volume.radiance_size=8")
    return _texels(field.volumes[0].radiance, formats.IRRADIANCE[settings.volume.irradiance_format], size)


def distance_map(field: IrradianceField, settings: RenderSettings) -> np.ndarray:
    """The distance maps as an array: (P, n, n, 2) mean distance [m] and mean square [m^2], no borders."""
    vol, size = field.volumes[0], settings.volume.distance_size
    stored = _texels(vol.distance, formats.DISTANCE[settings.volume.distance_format], size)
    reach = float(vol.reach(settings.volume)[0])
    return stored * np.array([reach, reach * reach], np.float32)


def _texels(store, fmt: formats.Format, size: int) -> np.ndarray:
    count = dr.width(store) // dr.size_v(fmt.packet())
    value = formats.read(fmt, store, dr.arange(mi.UInt32, count), mi.Bool(True))
    return np.array(value).T.reshape(-1, size + 2, size + 2, len(value))[:, 1:-1, 1:-1]
