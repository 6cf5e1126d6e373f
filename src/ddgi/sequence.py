"""Pictures one after the other, of a scene that moves, lit by one field that follows."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import drjit as dr

from ddgi.frame import Frame, render_frame, updated
from ddgi.probes.field import IrradianceField
from ddgi.scene.scene import Scene
from ddgi.settings import RenderSettings

MOMENTS = 64
"""At which it is asked where things will be, at most."""
REPLAYED = 512
"""Updates before the first picture that are made again where some are skipped: what lies before them is forgotten."""
SMOOTH = 32
"""Frames of which light of what is near, one random ray a pixel and frame, leaves no grain that flickers."""


def sequence(
    scene: Scene,
    s: RenderSettings,
    times: Sequence[float],
    clip: str | int | None = None,
    *,
    frames: int = 8,
    settle: int = 64,
    skip: int = 0,
    step: Callable[[], object] = lambda: None,
) -> Iterator[Frame]:
    """Render moments of an animation.

    Args:
        scene: What there is, and what moves in it.
        s: All settings.
        times: The moments [s], in order; one at least.
        clip: Name or number of the animation; by default the first.
        frames: Of each moment, added up to its picture; the field is updated as often. With fewer than `SMOOTH`,
            pixels do without light of what is near (`contact.pixels`), whose grain would flicker.
        settle: Updates before the first, at that moment.
        skip: Pictures that there are already; those after them are the same as without it, to the bit unless
            more than `REPLAYED` updates lie before.
        step: Called after each update before the first picture, after each moment that is skipped, and each picture.

    Raises:
        SceneError: Nothing in the scene is animated, or there is no such animation.
        SettingsError: The field cannot be laid out.
    """
    if frames < SMOOTH:
        s = replace(s, contact=replace(s.contact, pixels=0.0))
    now = scene.at(times[0], clip)
    passed = times[:: -(-len(times) // MOMENTS)]
    field = IrradianceField.fit(now, s, [box for time in passed for box in scene.at(time, clip).moving_boxes])
    first = max(0, skip - -(-REPLAYED // frames))
    tick, now = first * frames, scene.at(times[first], clip)
    for _ in range(settle):
        field = updated(now, field, tick, s)
        dr.eval(field)
        tick += 1
        step()
    for number, time in enumerate(times[first:], first):
        now = scene.at(time, clip)
        frame = Frame.empty(now.camera, s)
        for _ in range(frames):
            if number < skip:
                field = updated(now, field, tick, s)
                dr.eval(field)
            else:
                field, frame = render_frame(now, field, now.camera, tick, s, frame)
            tick += 1
        dr.eval(field, frame)
        step()
        if number >= skip:
            yield frame
