"""Things that move in built-in scenes: a rig of one clip, whose nodes carry shapes and lights from where they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ddgi.scene.library.geometry import Array
from ddgi.scene.rig import Channel, Clip, Rig, RigNode

STILL = (0.0, 0.0, 0.0, 1.0)
"""The rotation that is none."""


@dataclass(frozen=True)
class Carried:
    """What is carried, and how. T moments."""

    name: str
    times: npt.ArrayLike  # (T,) [s]
    places: npt.ArrayLike  # (T, 3) of its pivot [m]; the first is where that rests
    turns: npt.ArrayLike | None = None  # (T, 4) rotations about the pivot, unit quaternions x, y, z, w
    shapes: tuple[str, ...] = ()
    light: str | None = None


def rig(clip: str, carried: Sequence[Carried]) -> Rig:
    """A rig of things that move by themselves, in straight lines from moment to moment."""
    nodes, channels = [], []
    for number, thing in enumerate(carried):
        places = np.asarray(thing.places, np.float64)
        local = np.eye(4)
        local[:3, 3] = places[0]
        nodes.append(
            RigNode(
                thing.name,
                None,
                (),
                local,
                places[0],
                np.array(STILL),
                np.ones(3),
                None,
                (),
                thing.shapes,
                thing.light,
                None,
            )
        )
        moves = {"translation": places, "rotation": thing.turns}
        channels += [
            Channel(
                number, path, "LINEAR", np.asarray(thing.times, np.float64), np.asarray(values, np.float64)
            )
            for path, values in moves.items()
            if values is not None
        ]
    return Rig(tuple(nodes), clips=(Clip(clip, tuple(channels)),))


def turns_about(axis: tuple[float, float, float], degrees: npt.ArrayLike) -> Array:
    """(T, 4) rotations about an axis of length one, by some angles each."""
    half = np.radians(np.asarray(degrees, np.float64))[:, None] / 2
    return np.concatenate([np.sin(half) * np.asarray(axis), np.cos(half)], 1)
