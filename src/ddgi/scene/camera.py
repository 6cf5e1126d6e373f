"""A pinhole or orthographic camera; every number that moves is an opaque array."""

from __future__ import annotations

from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np
import numpy.typing as npt

from ddgi.box import Point
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
    position: mi.Point3d  # (1,) in the coordinates of the scene's file [m]
    forward: mi.Vector3f  # (1,) unit
    right: mi.Vector3f  # (1,) half width of the picture at distance one
    up: mi.Vector3f  # (1,) half height of the picture at distance one
    near: mi.Float  # (1,) [m] the camera alone sees nothing closer, along `forward`
    size: tuple[int, int]  # (width, height) [pixels]
    orthographic: bool = False

    def same_view(self, other: Camera) -> bool:
        """Whether another camera takes the same picture. Waits for the device unless it is this very one."""
        return self is other or (
            (self.size, self.orthographic) == (other.size, other.orthographic)
            and np.array_equal(self._numbers(), other._numbers())
        )

    def fingerprint(self, origin: Point) -> str:
        """The same for cameras that take the same picture of a scene with this origin, in every process."""
        numbers = self._numbers()
        numbers[:3] -= origin
        return f"{self.size} {self.orthographic} {numbers.astype(np.float32).tobytes().hex()}"

    def eye(self, origin: mi.Point3d) -> mi.Point3f:
        """(1,) its position as counted from the origin of a scene (`Tracer.origin`) [m]."""
        return mi.Point3f(self.position - origin)

    def _numbers(self) -> np.ndarray:
        parts = (self.position, self.forward, self.right, self.up, self.near)
        return np.concatenate([np.ravel(p) for p in parts])


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
        return dr.opaque(kind, np.asarray(values, np.float64).tolist())

    return Camera(
        name=name,
        position=opaque(mi.Point3d, position),
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
    origin, target, up = (
        _vector(v, name) for v, name in ((origin, "origin"), (target, "target"), (up, "up"))
    )
    forward = target - origin
    right = np.cross(forward, up)
    if not np.linalg.norm(forward) > 0:
        raise SettingsError(f"a camera cannot look at where it stands: {_written(origin)}")
    if not np.linalg.norm(right) > 1e-6 * np.linalg.norm(forward) * np.linalg.norm(up):
        raise SettingsError(
            f"the camera looks along its up, {_written(up)}: choose another up (--up on the command line)"
        )
    if not 0 < fov < 180:
        raise SettingsError(f"the field of view must lie between 0 and 180 degrees, not {fov}")
    _check_size(size)
    forward = forward / np.linalg.norm(forward)
    right = right / np.linalg.norm(right)
    half = np.tan(0.5 * np.radians(fov))
    upward = np.cross(right, forward) * half * size[1] / size[0]
    return make_camera(name, origin, forward, right * half, upward, size, near=near)


def with_size(camera: Camera, size: tuple[int, int]) -> Camera:
    """The same camera with another picture size (width, height).

    What was in the picture stays in it: of another shape it shows more, to the sides or above and below.

    Raises:
        SettingsError: The size is not positive.
    """
    _check_size(size)
    taller = (size[1] / size[0]) / (camera.size[1] / camera.size[0])
    return replace(
        camera,
        right=camera.right * dr.opaque(mi.Float, max(1 / taller, 1.0)),
        up=camera.up * dr.opaque(mi.Float, max(taller, 1.0)),
        size=(int(size[0]), int(size[1])),
    )


def with_near(camera: Camera, near: float) -> Camera:
    """The same camera that sees nothing closer than `near` [m] along its view.

    Raises:
        SettingsError: The distance is negative or not finite.
    """
    if not 0 <= near < float("inf"):
        raise SettingsError(f"near must be a finite distance of 0 m or more, not {near}")
    return replace(camera, near=dr.opaque(mi.Float, float(near)))


def turned(camera: Camera, pivot: npt.ArrayLike, axis: npt.ArrayLike, degrees: float) -> Camera:
    """The same camera carried around an axis.

    Args:
        camera: The camera.
        pivot: (3,) a point on the axis [m].
        axis: (3,) unit.
        degrees: How far, anticlockwise as seen against the axis.
    """
    axis, pivot = np.asarray(axis, np.float64), np.asarray(pivot, np.float64)
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))

    def turn(vector: npt.ArrayLike) -> np.ndarray:  # Rodrigues' formula
        v = np.array(vector, np.float64).ravel()
        return v * cos + np.cross(axis, v) * sin + axis * (axis @ v) * (1 - cos)

    return make_camera(
        camera.name,
        pivot + turn(np.ravel(camera.position) - pivot),
        turn(camera.forward),
        turn(camera.right),
        turn(camera.up),
        camera.size,
        near=float(np.ravel(camera.near)[0]),
        orthographic=camera.orthographic,
    )


def carried(camera: Camera, matrix: np.ndarray, origin: Point, size: tuple[int, int]) -> Camera:
    """The same camera moved by a matrix, whose scale only says where it stands; with pictures of another size.

    Args:
        camera: The camera.
        matrix: (4, 4) what moves it, in coordinates that count from `origin`.
        origin: (3,) in the camera's coordinates [m].
        size: (width, height) [pixels].
    """
    linear, here = matrix[:3, :3], np.asarray(origin)

    def turn(vector: npt.ArrayLike) -> np.ndarray:
        v = np.array(vector, np.float64).ravel()
        out = linear @ v
        return out * (np.linalg.norm(v) / max(float(np.linalg.norm(out)), 1e-30))

    position = linear @ (np.ravel(camera.position) - here) + matrix[:3, 3] + here
    near = float(np.ravel(camera.near)[0])
    moved = make_camera(
        camera.name, position, turn(camera.forward), turn(camera.right), turn(camera.up), camera.size,
        near=near, orthographic=camera.orthographic,
    )  # fmt: skip
    return moved if size == camera.size else with_size(moved, size)


def _written(vector: np.ndarray) -> str:
    return ", ".join(f"{x:g}" for x in vector)


def _vector(values: npt.ArrayLike, name: str) -> np.ndarray:
    vector = np.asarray(values, np.float64)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise SettingsError(f"the camera's {name} must be three finite numbers, not {vector}")
    return vector


MOST_PIXELS = 2**28
"""In one picture: their arrays stay addressable, and within tens of gigabytes."""


def _check_size(size: tuple[int, int]) -> None:
    if not (size[0] >= 1 and size[1] >= 1):
        raise SettingsError(f"a picture must be at least 1 x 1 pixels, not {size[0]} x {size[1]}")
    if size[0] * size[1] > MOST_PIXELS:
        raise SettingsError(f"a picture of {size[0]} x {size[1]} has more than {MOST_PIXELS:,} pixels")


def camera_rays(
    camera: Camera, origin: mi.Point3d, pixel: mi.UInt32, within: mi.Point2f
) -> tuple[mi.Point3f, mi.Vector3f]:
    """Start [m], from the scene's origin, and unit direction of rays through pixels.

    Args:
        camera: Where the picture is taken from.
        origin: (1,) of the scene, as its tracer has it.
        pixel: (N,) numbers of pixels, row by row from the top left.
        within: Place within the pixel in [0, 1)^2, (N,) or (1,).
    """
    width, height = camera.size
    row = pixel // width
    x = (mi.Float(pixel - row * width) + within.x) * (2 / width) - 1
    y = 1 - (mi.Float(row) + within.y) * (2 / height)
    aside, eye = x * camera.right + y * camera.up, camera.eye(origin)
    if camera.orthographic:
        return eye + aside + camera.near * camera.forward, camera.forward + aside * 0
    reach = camera.forward + aside
    return eye + camera.near * reach, dr.normalize(reach)
