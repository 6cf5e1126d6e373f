"""How the things of a scene that can move stand at one moment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

FARTHEST = 1e9
"""Beyond [m] a thing counts as gone astray: its distances' squares would leave single precision."""


@dataclass(frozen=True)
class Bent:
    """The V vertices of a shape that changes its form, in the order of the shape's own."""

    positions: np.ndarray  # (V, 3) [m]
    normals: np.ndarray | None = (
        None  # (V, 3) of any length; None: faces are flat, or smooth as they come out
    )


@dataclass(frozen=True)
class Pose:
    """Where things stand, against how they were loaded. In the coordinates of what is traced (`Scene.origin`)."""

    matrices: Mapping[str, np.ndarray] = field(
        default_factory=dict
    )  # (4, 4) by name of shape, light or camera
    bent: Mapping[str, Bent] = field(default_factory=dict)  # by name of shape; goes before a matrix

    def finite(self, before: Pose) -> tuple[Pose, tuple[str, ...]]:
        """The pose with what has gone astray where it was in the pose before, and the names of that.

        A thing is astray where a number of it is none, is infinite or lies beyond `FARTHEST`.
        """
        astray = tuple(
            name
            for things in (self.matrices, {name: b.positions for name, b in self.bent.items()})
            for name, numbers in things.items()
            if not (np.abs(numbers) < FARTHEST).all()
        )
        if not astray:
            return self, ()
        matrices = {
            n: before.matrices.get(n, np.eye(4)) if n in astray else m for n, m in self.matrices.items()
        }
        bent = {name: b for name, b in self.bent.items() if name not in astray}
        bent |= {name: before.bent[name] for name in astray if name in before.bent}
        return Pose(matrices, bent), astray
