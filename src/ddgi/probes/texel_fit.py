"""Texels fitted to how they are read: bilinear interpolation between exact texels is not exact.

Irradiance over directions is smooth, nearly a sum of spherical harmonics up to the second order
(Ramamoorthi and Hanrahan 2001). Interpolated between texels that hold its exact values, its peaks come
out low: by 2.5 % along z, 1 % along x and y, on a map of 8 x 8. So the part of a map that those
harmonics describe is replaced by the texels whose interpolation comes nearest to it over the sphere.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.own_memory import own
from ddgi.probes.directions import fibonacci
from ddgi.probes.octahedral import direction_to_square, interior, texel_at, texel_directions

SAMPLES_PER_TEXEL = 32
STEPS = 40
"""Of conjugate gradients: the error shrinks at least threefold with every one."""


@dataclass
class TexelFit:
    """What to add to T texels: `change` times what `harmonics` finds in them."""

    harmonics: mi.TensorXf  # (9, T)
    change: mi.TensorXf  # (T, 9)

    def apply(self, weights: mi.TensorXf) -> mi.TensorXf:
        """Texel weights of rays, (T, R), fitted."""
        return weights + dr.matmul(self.change, dr.matmul(self.harmonics, weights))

    def apply_to_maps(self, maps: mi.TensorXf) -> mi.TensorXf:
        """Maps of exact texels, one in a row, (N, T), fitted."""
        return maps + dr.matmul(dr.matmul(maps, self.harmonics, Bt=True), self.change, Bt=True)


def texel_fit(size: int) -> TexelFit:
    """The fit of a map with size^2 interior texels."""
    harmonics, change = _matrices(size)
    return TexelFit(_tensor(harmonics), _tensor(change))


def _tensor(matrix: np.ndarray) -> mi.TensorXf:
    return mi.TensorXf(own(matrix), matrix.shape)


@cache
def _matrices(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Harmonics of texels by least squares, (9, T); best texels minus exact ones of every harmonic, (T, 9)."""
    exact = _harmonics(texel_directions(size))
    if len(exact) < exact.shape[1]:
        return np.zeros(exact.T.shape), np.zeros(exact.shape)  # too few texels to tell harmonics apart
    directions = fibonacci(SAMPLES_PER_TEXEL * size * size)
    return np.linalg.pinv(exact), _best_texels(size, directions, exact) - exact


def _harmonics(direction: mi.Vector3f) -> np.ndarray:
    """Polynomials that span the spherical harmonics up to order two. (N, 9)."""
    x, y, z = np.array(direction, np.float64)
    return np.stack([np.ones_like(x), x, y, z, x * y, y * z, z * x, x * x - y * y, 3 * z * z - 1], -1)


def _best_texels(size: int, directions: mi.Vector3f, guess: np.ndarray) -> np.ndarray:
    """Texels whose interpolation is nearest to every harmonic, by conjugate gradients. (T, 9)."""
    texels, shares = _taps(size, directions)
    read = lambda values: (shares[..., None] * values[texels]).sum(0)  # noqa: E731

    def spread(values: np.ndarray) -> np.ndarray:
        parts = (shares[..., None] * values).reshape(-1, values.shape[1])
        return np.stack([np.bincount(texels.ravel(), p, size * size) for p in parts.T], -1)

    best = guess.copy()
    step = left = spread(_harmonics(directions) - read(best))
    size_of = lambda v: (v * v).sum(0)  # noqa: E731
    for _ in range(STEPS):
        along = spread(read(step))
        length = size_of(left) / np.maximum((step * along).sum(0), 1e-300)
        best = best + length * step
        before, left = left, left - length * along
        step = left + size_of(left) / np.maximum(size_of(before), 1e-300) * step
    return best


def _taps(size: int, directions: mi.Vector3f) -> tuple[np.ndarray, np.ndarray]:
    """The four texels that interpolation reads, and their shares. Both (4, N)."""
    first, fractions = texel_at(direction_to_square(directions), size)
    assert fractions is not None  # no tap was given
    corners = (first, first + 1, first + size + 2, first + size + 3)
    texels = np.stack([np.array(interior(c, size)) for c in corners])
    x, y = (np.array(f, np.float64) for f in fractions)
    return texels, np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y])
