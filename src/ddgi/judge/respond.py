"""Response: frames until the field's light has covered 90 % of a step, when a light is switched.

What is timed is the mean luminance of the picture's indirect layer. Of one bounce, blended linearly,
(1 - hysteresis^n) of a step is covered after n frames: 76 frames for a hysteresis of 0.97. Every
further bounce waits for the one before.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.errors import SceneError
from ddgi.frame import render_frame, updated
from ddgi.judge.watch import NOBODY, Watch
from ddgi.luminance import LUMINANCE
from ddgi.passes.picture import Picture
from ddgi.probes.field import IrradianceField
from ddgi.scene.named_lights import find_light

if TYPE_CHECKING:
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings

SHARE = 0.9
"""Of a step, that must be covered."""
CONVERGE = 200
"""Frames in which a field converges."""
FULL_BOUNCES = 40
"""Least number of first updates that keep nothing old: what 40 bounces leave out is nothing."""
MEASURED = 50
"""The last frames of them, whose mean is the steady level."""
AGED = 1 << 20
"""Updates after which the running mean is longer than any hysteresis remembers."""
LIMIT = 600
"""Frames after which a step counts as never covered."""
LEAST_SHARE = 1e-3
"""Of the direct light: less indirect light than that is the field's own error and no bounce."""
LEAST_STEP = 50
"""Of the steady level's spread between frames: 90 % of a smaller step drowns in the noise."""


@dataclass(frozen=True)
class Response:
    """How the indirect layer follows one switch."""

    frames: int | None  # until 90 % of the step was covered; None: not within the limit
    curve: tuple[float, ...]  # mean luminance [W/(m^2 sr)] before the switch, then after each frame


@dataclass(frozen=True)
class Responses:
    """How the indirect layer follows a light, both ways."""

    light: str | None  # its name; None: all of them
    off: Response
    on: Response
    noise: float  # spread of the steady level between frames, over the step

    def figures(self) -> dict[str, Any]:
        """By name, as `docs/results.md` explains them."""
        return {
            "light": self.light,
            "off_frames": self.off.frames,
            "on_frames": self.on.frames,
            "off_curve": list(self.off.curve),
            "on_curve": list(self.on.curve),
            "noise": self.noise,
        }


@dataclass(frozen=True)
class _Steady:
    """A scene whose field has converged."""

    scene: Scene
    field: IrradianceField
    levels: np.ndarray  # mean luminance of the last frames [W/(m^2 sr)]
    direct: float  # median luminance of direct light where there is some [W/(m^2 sr)]

    @property
    def level(self) -> float:
        return float(self.levels.mean())


def respond(
    scene: Scene,
    s: RenderSettings,
    light: str | int | None = None,
    *,
    limit: int = LIMIT,
    watch: Watch = NOBODY,
) -> Responses:
    """Switch a light off, and on again, and count the frames until the field has followed.

    The field is not reset at the switch. Each way starts from a field that has converged by itself,
    and ends at the level of the other.

    Args:
        scene: What to look at, with its first camera.
        s: Settings. Jitter is switched off, and after the switch there is no warm-up.
        light: Its name, or its number in `scene.named_lights`; None for all of them.
        limit: Frames to wait at most, 1 or more.
        watch: Told how far it is.

    Raises:
        SceneError: There is no such light; or the picture has no indirect light; or the light does
            not change it, or so little that the step drowns in the noise.
        SettingsError: The field cannot be laid out.
    """
    s = replace(s, gbuffer=replace(s.gbuffer, antialias=False))
    s = replace(s, direct=replace(s.direct, camera_samples=1))  # nobody looks at direct light
    name = None if light is None else find_light(scene.named_lights, light).name
    dark = scene.dimmed(light, 0)
    lit = _converge(scene, s, "on", watch)
    _check_bounces(lit)
    unlit = _converge(dark, s, "off", watch)
    noise = _noise(lit, unlit, name)
    off = _follow(lit, unlit, s, limit, "off", watch)
    on = _follow(unlit, lit, s, limit, "on", watch)
    return Responses(name, off, on, noise)


def frames_to_cover(curve: np.ndarray, goal: float, share: float = SHARE) -> int | None:
    """The first frame by which a curve has covered a share of the way from its start to a goal.

    Args:
        curve: (N + 1,) the level before the switch, and after each of N frames.
        goal: The level it tends to, other than that at its start.
        share: Of the way, in (0, 1).
    """
    covered = (np.asarray(curve) - curve[0]) / (goal - curve[0])
    reached = np.flatnonzero(covered >= share)
    return int(reached[0]) if reached.size else None


def _converge(scene: Scene, s: RenderSettings, state: str, watch: Watch) -> _Steady:
    """A field of the scene, warmed up whatever the settings say, and its level."""
    watch.phase(f"converging with the light {state}", CONVERGE)
    s = replace(s, blend=replace(s.blend, warm_up=max(s.blend.warm_up, FULL_BOUNCES)))
    field = IrradianceField.fit(scene, s)
    for tick in range(CONVERGE - MEASURED):
        field = updated(scene, field, tick, s)
        watch.step()
    levels = []
    for tick in range(CONVERGE - MEASURED, CONVERGE):
        field, picture = _frame(scene, field, tick, s)
        levels.append(_level(picture))
        watch.step()
    return _Steady(scene, field, np.array(levels), _lit_median(picture))


def _follow(
    before: _Steady, after: _Steady, s: RenderSettings, limit: int, state: str, watch: Watch
) -> Response:
    """Light the field of one scene with the lights of the other until it has followed."""
    watch.phase(f"switching the light {state}", limit)
    field, curve = _old(before.field), [float(before.levels[-1])]
    for tick in range(CONVERGE, CONVERGE + limit):
        field, picture = _frame(after.scene, field, tick, s)
        curve.append(_level(picture))
        watch.step()
        if (frames := frames_to_cover(np.array(curve), after.level)) is not None:
            return Response(frames, tuple(curve))
    return Response(None, tuple(curve))


def _old(field: IrradianceField) -> IrradianceField:
    """The field whose warm-up is over for any hysteresis."""
    age = lambda vol: dr.opaque(mi.UInt32, AGED, vol.grid.size)  # noqa: E731
    volumes = [replace(v, age=age(v), change=replace(v.change, settled=age(v))) for v in field.volumes]
    return replace(field, volumes=volumes)


def _frame(
    scene: Scene, field: IrradianceField, tick: int, s: RenderSettings
) -> tuple[IrradianceField, Picture]:
    """The field after one frame, and that frame."""
    field, frame = render_frame(scene, field, scene.camera, tick, s)
    return field, frame.picture


def _level(picture: Picture) -> float:
    """Mean luminance of the indirect layer."""
    return float(LUMINANCE @ np.array(picture.indirect, np.float64).mean(axis=1))


def _lit_median(picture: Picture) -> float:
    """Median luminance of direct light over the pixels that have some: a lamp in view does not count for more."""
    luminance = LUMINANCE @ np.array(picture.immediate, np.float64)
    return float(np.median(luminance[luminance > 0])) if (luminance > 0).any() else 0.0


def _check_bounces(lit: _Steady) -> None:
    """Refuse a picture without indirect light.

    Raises:
        SceneError: It has none, or what it has is the field's own error.
    """
    if lit.level <= LEAST_SHARE * lit.direct:
        why = "it is black" if lit.direct == 0 else "all its light is direct"
        raise SceneError(
            f"nothing to follow: the picture has no indirect light ({why}): choose a camera that sees lit "
            "surfaces which light each other"
        )


def _noise(lit: _Steady, unlit: _Steady, light: str | None) -> float:
    """Spread of the levels between frames, over the step between them."""
    step = abs(lit.level - unlit.level)
    spread = float(max(lit.levels.std(), unlit.levels.std()))
    if step <= LEAST_STEP * spread or step <= 1e-6 * max(lit.level, unlit.level):
        what = "the lights together hardly change" if light is None else f"light {light!r} hardly changes"
        raise SceneError(
            f"{what} the indirect light that the camera sees (by {step:.2g} of {lit.level:.2g}, noise "
            f"{spread:.2g}): choose another light or camera, or raise rays.per_probe"
        )
    return spread / step
