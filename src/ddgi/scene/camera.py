"""A pinhole or orthographic camera; every number that moves is an opaque array."""

from __future__ import annotations

from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np
import numpy.typing as npt

from ddgi.errors import SettingsError


@dataclass
class Camera:
    """Where a picture is taken from. Looks along `forward`; right = forward x up.

    A pixel (x, y), from (0, 0) at the top left to (1, 1), lies on the ray from `position`
    (pinhole) through position + forward + (2 x - 1) right + (1 - 2 y) up, with `right` and `up`
    carrying the half extents of the picture at distance one. Orthographic: the ray starts at
    position + (2 x - 1) right + (1 - 2 y) up and runs along `forward`. Of a camera whose optical
    axis is off the picture's middle, `forward` is the ray through the middle.
    """

    name: str
    position: mi.Point3f  # (1,) [m]
    forward: mi.Vector3f  # (1,) unit
    right: mi.Vector3f  # (1,) half width of the picture at distance one
    up: mi.Vector3f  # (1,) half height of the picture at distance one
    near: mi.Float  # (1,) [m] the camera alone sees nothing closer, along `forward`
    size: tuple[int, int]  # (width, height) [pixels]
    orthographic: bool = False


def make_camera(
    name: str,
    position: npt.ArrayLike,
    forward: npt.ArrayLike,
    right: npt.ArrayLike,
    up: npt.ArrayLike,
    size: tuple[int, int],
    *,
    near: float = 0.0,
    orthographic: bool = False,
) -> Camera:
    """A camera from plain numbers; see `Camera` for their meaning and units."""

    def opaque(kind: type, values: npt.ArrayLike):
        x, y, z = (dr.opaque(mi.Float, float(v)) for v in np.asarray(values, np.float64))
        return kind(x, y, z)

    return Camera(
        name=name,
        position=opaque(mi.Point3f, position),
        forward=opaque(mi.Vector3f, forward),
        right=opaque(mi.Vector3f, right),
        up=opaque(mi.Vector3f, up),
        near=dr.opaque(mi.Float, float(near)),
        size=(int(size[0]), int(size[1])),
        orthographic=orthographic,
    )


def look_at(
    origin: npt.ArrayLike,
    target: npt.ArrayLike,
    up: npt.ArrayLike = (0.0, 1.0, 0.0),
    *,
    fov: float = 60.0,
    size: tuple[int, int] = (640, 360),
    near: float = 0.0,
    name: str = "camera",
) -> Camera:
    """A pinhole camera at `origin` that looks at `target`.

    Args:
        origin: Where it stands [m].
        target: The point in the middle of the picture [m].
        up: What is up in the picture; any vector not along the view.
        fov: Horizontal field of view [degrees], in (0, 180).
        size: (width, height) [pixels].
        near: It sees nothing closer than this along the view [m].
        name: Its name.

    Raises:
        SettingsError: The numbers describe no camera.
    """
    origin, target, up = (np.asarray(v, np.float64) for v in (origin, target, up))
    forward = target - origin
    right = np.cross(forward, up)
    if not np.isfinite([*origin, *target, *up]).all() or not np.linalg.norm(right) > 0:
        raise SettingsError("a camera needs finite points, a target apart from its origin, up not along view")
    if not 0 < fov < 180:
        raise SettingsError(f"the field of view must lie between 0 and 180 degrees, not {fov}")
    _check_size(size)
    forward = forward / np.linalg.norm(forward)
    right = right / np.linalg.norm(right)
    half = np.tan(0.5 * np.radians(fov))
    upward = np.cross(right, forward) * half * size[1] / size[0]
    return make_camera(name, origin, forward, right * half, upward, size, near=near)


def with_size(camera: Camera, size: tuple[int, int]) -> Camera:
    """The same camera with another picture size (width, height); the horizontal field of view stays.

    Raises:
        SettingsError: The size is not positive.
    """
    _check_size(size)
    ratio = (size[1] / size[0]) / (camera.size[1] / camera.size[0])
    return replace(camera, up=camera.up * dr.opaque(mi.Float, ratio), size=(int(size[0]), int(size[1])))


def with_near(camera: Camera, near: float) -> Camera:
    """The same camera that sees nothing closer than `near` [m] along its view.

    Raises:
        SettingsError: The distance is negative or not finite.
    """
    if not 0 <= near < float("inf"):
        raise SettingsError(f"near must be a finite distance of 0 m or more, not {near}")
    return replace(camera, near=dr.opaque(mi.Float, float(near)))


def _check_size(size: tuple[int, int]) -> None:
    if not (size[0] >= 1 and size[1] >= 1):
        raise SettingsError(f"a picture must be at least 1 x 1 pixels, not {size[0]} x {size[1]}")
