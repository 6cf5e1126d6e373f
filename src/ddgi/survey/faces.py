"""What paths from the cameras meet: from which side, and how thick it is there.

No file says what is a wall and what is a sheet, or which faces are turned away; rays do. From where a
path meets a face another ray goes on, straight in: where it leaves through the back of a face, it has
come through a solid, that thick. A face seen from its own back, with nothing behind it, or with the
front of another one behind it, is a sheet without thickness.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi import sampling
from ddgi.own_memory import own
from ddgi.sampling import Clock
from ddgi.scene.camera import Camera, camera_rays
from ddgi.scene.scene import Scene
from ddgi.trace.materials import Materials
from ddgi.trace.surface import matt_bounce, offset_origin

PATHS = 16384
"""From every camera: shares of its picture are known to within 0.4 % (one standard deviation)."""
SURFACES = 4
"""That a path meets, as those that the region is found with (`probes/region.py`)."""


@dataclass(frozen=True)
class Faces:
    """What N rays met, as arrays of N."""

    hit: np.ndarray  # bool: something; the rest is meaningless where not
    position: np.ndarray  # (N, 3) in the coordinates of the scene's file [m]
    normal: np.ndarray  # (N, 3) unit, geometric, on the side the ray came from
    distance: np.ndarray  # along the ray [m]
    behind: np.ndarray  # bool: seen from behind, whether the material has two sides or not
    black: np.ndarray  # bool: seen from behind, and the material has one side
    matt: np.ndarray  # bool: reflects light and emits none, so that the picture shows the field there
    thickness: np.ndarray  # [m] of the solid that begins here, 0 of sheets

    def __len__(self) -> int:
        return len(self.hit)

    def where(self, which: np.ndarray | slice) -> Faces:
        """Some of them. which: (N,) bool, or from where to where."""
        return Faces(*(getattr(self, f.name)[which] for f in fields(self)))

    def of_camera(self, number: int) -> Faces:
        """What the paths of one camera met."""
        return self.where(slice(number * PATHS, (number + 1) * PATHS))


def joined(several: list[Faces]) -> Faces:
    """One after another."""
    return Faces(*(np.concatenate([getattr(s, f.name) for s in several]) for f in fields(Faces)))


def met(scene: Scene) -> list[Faces]:
    """What paths from a scene's cameras meet: first what pixels show, then what light came from there.

    Returns:
        `SURFACES` entries of `PATHS` rays for each camera, one camera after the other.
    """
    # All cameras at once: scenes with instances are slow to record, and need be only once.
    starts = [_pixel_rays(camera, scene.tracer.origin) for camera in scene.cameras]
    origin = mi.Point3f(np.concatenate([o for o, _ in starts], 1))
    direction = mi.Vector3f(np.concatenate([d for _, d in starts], 1))
    active = dr.opaque(mi.Bool, True, PATHS * len(starts))
    out = []
    for surface in range(SURFACES):
        dr.eval(origin, direction, active)  # so that all surfaces share one kernel
        found, origin, direction, active = _meet(scene, origin, direction, active, sampling.clock(0, surface))
        out.append(replace(found, position=found.position + np.array(scene.origin)))
    return out


def _pixel_rays(camera: Camera, origin: mi.Point3d) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions, (3, N), through pixels all over the picture."""
    lane = dr.arange(mi.UInt32, PATHS)
    along = sampling.low_discrepancy(sampling.clock(0, 0), sampling.SURVEY, mi.UInt32(0), lane)
    pixel = mi.UInt32(along * (camera.size[0] * camera.size[1]))
    start, direction = camera_rays(camera, origin, pixel, mi.Point2f(0.5))
    return np.array(start), np.array(direction)


def _meet(scene: Scene, origin, direction, active, time: Clock):
    """What rays meet, and the rays that go on from there as light leaves a matt surface."""
    turned = replace(scene.tracer, materials=_single_sided(scene.materials))
    stream = sampling.SURVEY_ALPHA
    surface = scene.tracer.intersect(origin, direction, active, time=time, stream=stream)
    behind = turned.intersect(origin, direction, active, time=time, stream=stream).back
    inwards = -mi.Vector3f(surface.geometric_normal)
    inside = offset_origin(surface, inwards)
    beyond = turned.intersect(inside, inwards, surface.valid, time=time, stream=stream)
    found = (
        surface.valid,
        surface.position,
        surface.geometric_normal,
        surface.distance,
        behind,
        surface.back,
        surface.lit & (dr.max(surface.albedo) > 0) & (dr.max(surface.emission) == 0),
        dr.select(beyond.back & ~behind, dr.norm(beyond.position - surface.position), 0),
    )
    lane = dr.arange(mi.UInt32, dr.width(origin))
    start, onward = matt_bounce(surface, sampling.uniform_2d(time, sampling.SURVEY, lane))
    dr.eval(found, start, onward, surface.lit)  # at once: each use alone would trace the rays again
    return Faces(*(_column(array, dr.width(origin)) for array in found)), start, onward, surface.lit


def _column(array, count: int) -> np.ndarray:
    """(N,) or (N, 3), of what is the same for all as well."""
    values = np.array(array).T
    return np.broadcast_to(values, (count, *values.shape[1:]))


def _single_sided(materials: Materials) -> Materials:
    """The same table, every material on the front of its faces alone: it tells fronts from backs."""
    surface = np.array(materials.surface).reshape(-1, 4)
    surface[:, 3] = 0
    return replace(materials, surface=own(surface), any_single_sided=True)
