"""The maps of all probes side by side: planes of the grid across its y axis, x to the right and z downwards in each."""

from __future__ import annotations

import math

import numpy as np

from ddgi.errors import SettingsError
from ddgi.probes.field import IrradianceField, distance_map, irradiance_map
from ddgi.settings import RenderSettings

GAP = 1
"""Between maps, and four times as much between planes [texels]."""
LARGEST = 1 << 26
"""Most pixels of a picture."""


def irradiance_atlas(field: IrradianceField, settings: RenderSettings) -> np.ndarray:
    """Irradiance over pi [W/(m^2 sr)], as bright as a white surface would be. (H, W, 3)."""
    return _laid_out(field, irradiance_map(field, settings) / np.pi)


def distance_atlas(field: IrradianceField, settings: RenderSettings) -> np.ndarray:
    """Mean distance, from 0 at the probe to 1 at the longest that is kept, in grey. (H, W, 3)."""
    reach = float(field.volumes[0].reach(settings.volume)[0])
    mean = distance_map(field, settings)[..., :1] / reach
    return _laid_out(field, np.repeat(mean, 3, -1))


def _laid_out(field: IrradianceField, maps: np.ndarray) -> np.ndarray:
    """Maps (P, n, n, 3) of the probes as one picture, planes in rows of about as many as there are rows."""
    nx, ny, nz = field.volumes[0].grid.counts
    size = maps.shape[1] + GAP
    across = max(1, math.ceil(math.sqrt(ny * nz / nx)))
    down = math.ceil(ny / across)
    height, width = nz * size + 4 * GAP, nx * size + 4 * GAP
    if height * down * width * across > LARGEST:
        raise SettingsError(
            f"an atlas of {len(maps):,} probes is {width * across:,} x {height * down:,} pixels: use fewer probes (grid.budget)"
        )
    picture = np.zeros((height * down, width * across, 3), np.float32)
    tiles = maps.reshape(nz, ny, nx, *maps.shape[1:])
    for y in range(ny):
        top, left = y // across * height, y % across * width
        for z in range(nz):
            for x in range(nx):
                row, column = top + z * size, left + x * size
                picture[row : row + size - GAP, column : column + size - GAP] = tiles[z, y, x]
    return picture
