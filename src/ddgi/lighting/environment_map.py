"""A picture of the surroundings, looked up by ourselves.

Mitsuba's `envmap` keeps its texels in a texture of the GPU, which no frozen kernel of Dr.Jit 1.5 can
read there: the process aborts ("unknown variable"). So what rays see of it comes from a plain array.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.extrema import at_most, clamp
from ddgi.own_memory import own


@dataclass
class EnvironmentMap:
    """Radiance by direction, latitude by longitude: row 0 at the pole +y, columns from -z by way of +x."""

    width: int
    height: int
    texels: mi.Float  # (4 W H,) r g b, unused [W/(m^2 sr)]
    to_local: mi.Float  # (9,) rotation from the world to the picture's axes, row by row


def environment_map(emitter: mi.Emitter, texels: np.ndarray) -> EnvironmentMap:
    """The same picture as an `envmap` shows. texels: (H, W, 3), its scale in them."""
    height, width = texels.shape[:2]
    table = np.zeros((height, width, 4), np.float32)
    table[..., :3] = texels
    to_world = np.array(mi.traverse(emitter)["to_world"].matrix, np.float64).reshape(4, 4)[:3, :3]
    return EnvironmentMap(width, height, own(table), own(np.linalg.inv(to_world)))


def radiance(picture: EnvironmentMap, direction: mi.Vector3f, active: mi.Bool) -> mi.Color3f:
    """What arrives from directions, by bilinear interpolation. direction: (N,) unit; result: (N,)."""
    x, y, z = (
        sum(
            dr.gather(mi.Float, picture.to_local, mi.UInt32(3 * row + axis)) * direction[axis]
            for axis in range(3)
        )
        for row in range(3)
    )
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
