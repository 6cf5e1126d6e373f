"""What a stage asks of anything that can trace rays: meshes today, distance fields later."""

from __future__ import annotations

from typing import Protocol

import mitsuba as mi

from ddgi.sampling import Clock
from ddgi.trace.surface import Surface


class Tracer(Protocol):
    """Closest hits and visibility."""

    origin: mi.Point3d  # (1,) what positions count from, in the coordinates of the scene's file [m]
    extent: mi.Float  # (1,) no coordinate in the scene is larger [m]

    @property
    def shining(self) -> bool:
        """Whether some surface is not matt as a whole."""
        ...

    def intersect(
        self,
        origin: mi.Point3f,
        direction: mi.Vector3f,
        active: mi.Bool,
        *,
        time: Clock,
        stream: int,
        coherent: bool = False,
        reach: mi.Float | None = None,
        bumps: bool = False,
    ) -> Surface:
        """Closest surface along each ray.

        Args:
            origin: (N,) [m], from the tracer's own `origin` like all positions here.
            direction: (N,) unit vectors.
            active: (N,) other lanes come back as misses.
            time: Random source for surfaces that let part of the light through.
            stream: Which stream of it (`ddgi.sampling`).
            coherent: Neighbouring lanes look alike; only a hint for speed.
            reach: (N,) or (1,) what lies farther is not met [m]; None: anything is.
            bumps: Shading normals follow normal maps; else surfaces are smooth.
        """
        ...

    def visible(
        self, origin: mi.Point3f, direction: mi.Vector3f, distance: mi.Float, active: mi.Bool
    ) -> mi.Float:
        """Share of light in [0, 1] that crosses each segment; 0 on inactive lanes."""
        ...
