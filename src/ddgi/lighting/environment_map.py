"""A picture of the surroundings, looked up and sampled by ourselves.

Mitsuba's `envmap` keeps its texels in a texture of the GPU, which no frozen kernel of Dr.Jit 1.5 can
read there: the process aborts ("unknown variable"). So what rays see of it comes from a plain array, and
so does the choice of directions.

Directions are picked by cells, one around each texel, from one row of texels to the next. A cell is picked
in proportion to its size and to the brightest texel that any place in it is mixed from; within it all
directions are alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.extrema import at_least, at_most, clamp
from ddgi.luminance import LUMINANCE
from ddgi.own_memory import own


@dataclass
class EnvironmentMap:
    """Radiance by direction, latitude by longitude: row 0 at the pole +y, columns from -z by way of +x."""

    width: int
    height: int
    texels: mi.Float  # (4 W H,) r g b, unused [W/(m^2 sr)]
    to_local: mi.Float  # (9,) rotation from the world to the picture's axes, row by row
    rows: mi.Float  # (H - 1,) share of the cells up to the end of each row, the last 1
    columns: mi.Float  # (W (H - 1),) likewise of a row's cells, row by row


def environment_map(emitter: mi.Emitter, texels: np.ndarray) -> EnvironmentMap:
    """The same picture as an `envmap` shows. texels: (H, W, 3), its scale in them."""
    height, width = texels.shape[:2]
    table = np.zeros((height, width, 4), np.float32)
    table[..., :3] = texels
    to_world = np.array(mi.traverse(emitter)["to_world"].matrix, np.float64).reshape(4, 4)[:3, :3]
    rows, columns = _shares(texels)
    return EnvironmentMap(
        width, height, own(table), own(np.linalg.inv(to_world)),
        own(rows.astype(np.float32)), own(columns.astype(np.float32)),
    )  # fmt: skip


def _shares(texels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Running shares of rows, (H - 1,), and of the cells of each, (H - 1, W)."""
    height = len(texels)
    bright = texels.astype(np.float64) @ LUMINANCE
    bright = np.maximum(bright[:-1], bright[1:])
    bright = np.maximum(bright, np.maximum(np.roll(bright, 1, 1), np.roll(bright, -1, 1)))
    belt = -np.diff(np.cos(np.arange(height) * np.pi / (height - 1)))
    weight = bright * belt[:, None] + 1e-30 * belt[:, None]  # of black pictures every direction
    columns = np.cumsum(weight, 1)
    rows = np.cumsum(columns[:, -1])
    return rows / rows[-1], columns / columns[:, -1:]


def sample(picture: EnvironmentMap, u: mi.Point2f) -> tuple[mi.Vector3f, mi.Float]:
    """Directions, picked where the picture is bright, and their density [1/sr]. u: (N,) uniform numbers; (N,) each."""
    row, chance, down = _picked(picture.rows, mi.UInt32(0), picture.height - 1, u.y)
    column, share, across = _picked(picture.columns, row * picture.width, picture.width, u.x)
    top, bottom = (dr.cos((mi.Float(row) + i) * (dr.pi / (picture.height - 1))) for i in (0, 1))
    y = dr.lerp(top, bottom, down)
    angle = (mi.Float(column) + across) * (2 * dr.pi / picture.width)
    sine, cosine = dr.sincos(angle)
    radius = dr.sqrt(at_least(1 - y * y, 0))
    local = mi.Vector3f(radius * sine, y, -radius * cosine)
    size = (top - bottom) * (2 * dr.pi / picture.width)
    world = [sum(_rotation(picture, axis, j) * local[axis] for axis in range(3)) for j in range(3)]
    return dr.normalize(mi.Vector3f(*world)), chance * share / at_least(size, 1e-30)


def _picked(
    shares: mi.Float, first: mi.UInt32, count: int, u: mi.Float
) -> tuple[mi.UInt32, mi.Float, mi.Float]:
    """Which of `count` running shares from `first` on u falls in, the chance of it, and how far into it."""
    found = dr.binary_search(0, count - 1, lambda i: dr.gather(mi.Float, shares, first + i) <= u)
    high = dr.gather(mi.Float, shares, first + found)
    low = dr.select(found > 0, dr.gather(mi.Float, shares, first + found - 1, found > 0), 0)
    chance = high - low
    return found, chance, clamp((u - low) / at_least(chance, 1e-30), 0, 1 - 2.0**-24)


def _rotation(picture: EnvironmentMap, row: int, axis: int) -> mi.Float:
    return dr.gather(mi.Float, picture.to_local, mi.UInt32(3 * row + axis))


def radiance(picture: EnvironmentMap, direction: mi.Vector3f, active: mi.Bool) -> mi.Color3f:
    """What arrives from directions, by bilinear interpolation. direction: (N,) unit; result: (N,)."""
    x, y, z = (sum(_rotation(picture, row, axis) * direction[axis] for axis in range(3)) for row in range(3))
    # Texel centres at half steps around, but at whole ones from pole to pole.
    column = dr.atan2(x, -z) * (picture.width / (2 * dr.pi)) - 0.5
    row = dr.safe_acos(y) * ((picture.height - 1) / dr.pi)
    left, above = dr.floor(column), at_most(dr.floor(row), max(picture.height - 2, 0))
    across, down = column - left, row - above

    def texel(step_x: int, step_y: int) -> mi.Color3f:
        i = mi.Int32(left) + step_x
        i = dr.select(i < 0, i + picture.width, i)  # atan2 gives from -width/2 - 1/2 to width/2 - 1/2
        i = clamp(dr.select(i >= picture.width, i - picture.width, i), 0, picture.width - 1)
        j = clamp(mi.Int32(above) + step_y, 0, picture.height - 1)
        index = mi.UInt32(j * picture.width + i)
        return mi.Color3f(dr.gather(mi.Vector4f, picture.texels, index, active).xyz)

    upper = dr.lerp(texel(0, 0), texel(1, 0), across)
    lower = dr.lerp(texel(0, 1), texel(1, 1), across)
    return dr.lerp(upper, lower, down)
