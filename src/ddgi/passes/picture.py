"""The picture that frames add up to while nothing moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import drjit as dr
import mitsuba as mi
from typing_extensions import Doc

from ddgi.extrema import at_least
from ddgi.lighting.guard import finite
from ddgi.passes.shade import Shaded
from ddgi.settings_group import settings_group
from ddgi.trace.surface import Surface


@settings_group("picture")
class Settings:
    """What a frame keeps."""

    layers: Annotated[
        bool, Doc("keep direct, indirect, emission, irradiance, albedo, normal and depth beside the picture")
    ] = False


CHANNELS = {"direct": 3, "indirect": 3, "emission": 3, "irradiance": 3, "albedo": 3, "normal": 3, "depth": 1}
"""Layers and their channels. irradiance: indirect E [W/m^2]; normal: world space; depth: metres along the ray."""

FROM_FIELD = ("indirect", "irradiance")


@dataclass
class Picture:
    """Means over the frames so far. Lanes are pixels, row by row from the top left."""

    immediate: mi.Color3f  # (N,) direct light and emission [W/(m^2 sr)]
    indirect: (
        mi.Color3f
    )  # (N,) light from the field [W/(m^2 sr)]; samples of what is near may take it below zero
    layers: dict[str, mi.Color3f | mi.Float]  # by name, empty unless asked for
    weight: mi.Float  # (1,) sum of the weights of the frames in the field's mean
    frames: mi.UInt32  # (1,) number of frames in the mean
    non_finite: mi.UInt32  # (1,) pixel values that were not numbers, taken as black

    @property
    def radiance(self) -> mi.Color3f:
        """All light towards the camera, (N,) [W/(m^2 sr)]."""
        return self.immediate + at_least(self.indirect, 0)


def empty(size: tuple[int, int], s: Settings) -> Picture:
    """A picture of no frames. size: (width, height) [pixels]."""
    pixels = size[0] * size[1]
    kinds = {3: mi.Color3f, 1: mi.Float}
    layers = {name: dr.opaque(kinds[n], 0, pixels) for name, n in CHANNELS.items()} if s.layers else {}
    return Picture(
        dr.opaque(mi.Color3f, 0, pixels),
        dr.opaque(mi.Color3f, 0, pixels),
        layers,
        weight=dr.opaque(mi.Float, 0),
        frames=dr.opaque(mi.UInt32, 0),
        non_finite=dr.opaque(mi.UInt32, 0),
    )


def accumulate(previous: Picture, surface: Surface, shaded: Shaded, s: Settings) -> Picture:
    """Add a frame to the means.

    Direct light, right from the first frame, enters with equal weights. Of the field's light the
    n-th frame weighs n^3: while the field converges, the early, too dark frames fade from the
    mean by themselves (the first quarter of them weighs 0.4 %), and of n frames 7/16 n still
    count against noise and jagged edges.
    """
    frames = previous.frames + 1
    count = mi.Float(frames)
    added = count * count * count
    weight = previous.weight + added
    even, late = dr.rcp(count), added / weight
    shown, bad = finite(shaded.direct + shaded.emission)
    ambient, worse = finite(shaded.indirect)
    immediate = dr.lerp(previous.immediate, shown, even)
    indirect = dr.lerp(previous.indirect, ambient, late)
    layers = {
        name: dr.lerp(previous.layers[name], new, late if name in FROM_FIELD else even)
        for name, new in (_layers(surface, shaded) if s.layers else {}).items()
    }
    dr.eval(immediate, indirect, layers, bad, worse)  # one kernel: a count alone would trace the pixels again
    return Picture(immediate, indirect, layers, weight, frames, previous.non_finite + bad + worse)


def _layers(surface: Surface, shaded: Shaded) -> dict:
    keep = lambda x: dr.select(dr.isfinite(x), x, 0)  # noqa: E731
    return {
        "direct": keep(shaded.direct),
        "indirect": keep(shaded.indirect),
        "emission": keep(shaded.emission),
        "irradiance": keep(shaded.irradiance),
        "albedo": mi.Color3f(surface.albedo),
        "normal": dr.select(surface.valid, mi.Color3f(surface.normal), mi.Color3f(0)),
        "depth": dr.select(surface.valid, surface.distance, 0),
    }
