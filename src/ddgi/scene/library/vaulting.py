"""Walls with windows, vaults and domes, all with thickness. Metres, +y up.

Watertight and wound counter-clockwise seen from outside, as in `geometry`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ddgi.scene.library.geometry import Array, Triangles, grid, merge, slab_between, smooth, swept

_SLANT = 1e-3  # jambs lean by it, so that no triangle of a wall's front is a mere line [m]
_OVERLAP = 0.05  # how far one part of a wall runs on inside another, so that no ray finds a crack [m]


def between(lower: Array, upper: Array) -> Triangles:
    """The solid between two surfaces.

    Args:
        lower: (R, C, 3) points [m].
        upper: (R, C, 3) points on the side to which rows cross columns points [m].
    """
    up = np.concatenate([upper[:-1, 0], upper[-1, :-1], upper[:0:-1, -1], upper[0, :0:-1]])
    low = np.concatenate([lower[:-1, 0], lower[-1, :-1], lower[:0:-1, -1], lower[0, :0:-1]])
    sides = grid(np.stack([low, up], 1), closed_rows=True)
    # Each surface has vertices of its own, so that smooth normals do not run over the rims.
    return merge([smooth(grid(upper)), smooth(grid(lower[::-1])), sides])


def windowed_wall(
    span: tuple[float, float],
    height: tuple[float, float],
    z: tuple[float, float],
    centres: Sequence[float],
    half_width: tuple[float, float],
    sill: tuple[float, float],
    spring: float,
    *,
    rise: float = 1.0,
    segments: int = 16,
    step: float = np.inf,
) -> Triangles:
    """A wall along x with a row of equal windows. Pairs of one window are for the back and the front.

    Args:
        span: Where the wall begins and ends along x [m].
        height: Of its foot and of its upper edge [m].
        z: Its back and its front [m].
        centres: The windows' middles along x, rising [m].
        half_width: Half a window's width [m].
        sill: Height of a window's foot [m].
        spring: Height at which its arch begins [m].
        rise: Of the arch, as a share of half its width: 1 is round, 0 a straight lintel.
        segments: Per arch.
        step: Longest piece of wall between windows, for walls to be bent [m].
    """
    foot = min(sill) - _OVERLAP
    angle = np.linspace(np.pi, 0.0, segments + 1)
    piers = [max(1, int(np.ceil(gap / step))) for gap in np.diff([span[0], *centres, span[1]])]

    def outline(half: float) -> tuple[Array, Array]:
        """Places along x, and heights, of the upper part's lower edge."""
        xs, lows = [], []
        begins = [span[0], *(centre + half + _SLANT for centre in centres)]
        ends = [*(centre - half - _SLANT for centre in centres), span[1]]
        for number, (begin, end) in enumerate(zip(begins, ends, strict=True)):
            pier = np.linspace(begin, end, piers[number] + 1)
            xs.append(pier)
            lows.append(np.full_like(pier, foot))
            if number < len(centres):
                xs.append(centres[number] + half * np.cos(angle))
                lows.append(spring + rise * half * np.sin(angle))
        return np.concatenate(xs), np.concatenate(lows)

    (x_back, low_back), (x_front, low_front) = (outline(half) for half in half_width)
    back, front, top = (np.full_like(x_back, value) for value in (*z, height[1]))
    edges = [
        (x_front, top, front),
        (x_front, low_front, front),
        (x_back, low_back, back),
        (x_back, top, back),
    ]
    upper = swept(np.stack([np.stack(edge, -1) for edge in edges]))
    x = np.linspace(*span, 2 if np.isinf(step) else int(np.ceil((span[1] - span[0]) / step)) + 1)
    below = slab_between(x, np.full_like(x, height[0]), np.full_like(x, sill[0]), z)
    nearer = np.isclose(below.positions[:, 2], z[1]) & np.isclose(below.positions[:, 1], sill[0])
    below.positions[nearer, 1] = sill[1]
    return merge([below, upper])


def bent(shape: Triangles, radius: float) -> Triangles:
    """Bend a wall along x around the y axis: its middle stands at z = -radius, its +z side faces the axis.

    Args:
        shape: The wall; what lies at z = 0 keeps its length.
        radius: Of the arc that z = 0 becomes [m].
    """
    x, y, z = shape.positions.T
    angle = x / radius
    return Triangles(
        np.stack([(radius - z) * np.sin(angle), y, -(radius - z) * np.cos(angle)], 1), shape.faces
    )


def groin_vault(
    bays: Sequence[float],
    half: tuple[float, float],
    spring: float,
    rise: float,
    top: float,
    *,
    margin: float = 0.2,
    cells: int = 24,
) -> Triangles:
    """A row of bays where two barrels cross, as one solid with a flat top.

    Args:
        bays: The bays' middles along x, 2 half[0] apart [m].
        half: Half a bay's extent along x and z [m].
        spring: Height at which the barrels begin [m].
        rise: From there to the crown [m].
        top: Height of the upper side [m].
        margin: How far the solid runs on inside the walls around it [m].
        cells: Quads along each side of a bay.
    """
    angle = np.linspace(-np.pi / 2, np.pi / 2, cells + 1)
    # Where two bays meet each has its own points, so that smooth normals do not run over the crease.
    x = np.concatenate([middle + half[0] * np.sin(angle) for middle in bays]).round(9)
    over_x = np.tile(np.cos(angle), len(bays))
    x = np.concatenate([[x[0] - margin], x, [x[-1] + margin]])
    over_x = np.concatenate([[0.0], over_x, [0.0]])
    z = np.concatenate([[-half[1] - margin], half[1] * np.sin(angle), [half[1] + margin]])
    over_z = np.concatenate([[0.0], np.cos(angle), [0.0]])
    height = spring + rise * np.maximum(over_x[None], over_z[:, None]).clip(0.0)
    lower = np.stack(np.broadcast_arrays(x[None], height, z[:, None]), -1)
    upper = lower.copy()
    upper[..., 1] = top
    return between(lower, upper)


def half_dome(inner: float, outer: float, cells: int = 32) -> Triangles:
    """A quarter of a hollow ball that stands on y = 0 about the origin and opens towards -x.

    Args:
        inner: Radius of the side that is seen from below [m].
        outer: Radius of the other side [m].
        cells: Quads from the foot to the crown.
    """
    height = np.linspace(0.0, np.pi / 2, cells + 1)[None]
    turn = np.linspace(np.pi / 2, -np.pi / 2, 2 * cells + 1)[:, None]
    direction = np.stack(
        np.broadcast_arrays(np.cos(height) * np.cos(turn), np.sin(height), np.cos(height) * np.sin(turn)), -1
    )
    direction[:, -1] = (0.0, 1.0, 0.0)
    return between(inner * direction, outer * direction)
