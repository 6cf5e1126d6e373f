"""A bust on a pedestal, after the marbles of antiquity: curls, brows and folds hold soft shadows.

It stands on y = 0 about the y axis and looks along +z; every part is a closed solid. Metres.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ddgi.scene.library import geometry
from ddgi.scene.library.geometry import Array, Triangles
from ddgi.scene.library.sculpting import Clay, curve

PEDESTAL = 0.78
"""Height of the pedestal [m]."""

_SCALE = 1.45  # of the bust: sculpted in life size


def pedestal() -> Triangles:
    """A fluted drum between a plinth and a square top."""
    height = PEDESTAL
    base = [(0, 0.09), (0.25, 0.09), (0.25, 0.09), (0.265, 0.12), (0.25, 0.15), (0.205, 0.19), (0.205, 0.19)]
    shaft = [(0.195, 0.21), (0.19, 0.23), (0.18, height - 0.17), (0.185, height - 0.15)]
    head = [
        (0.195, height - 0.13),
        (0.195, height - 0.13),
        (0.24, height - 0.07),
        (0.24, height - 0.07),
        (0, height - 0.07),
    ]
    profile = np.array([*base, *shaft, *head])
    fluting = np.zeros(len(profile))
    fluting[len(base) + 1 : len(base) + 3] = 0.016
    drum = geometry.lathe(profile, 160, flutes=20, fluting=fluting)
    plinth = geometry.box((-0.28, 0, -0.28), (0.28, 0.1, 0.28))
    top = geometry.box((-0.27, height - 0.08, -0.27), (0.27, height, 0.27))
    return geometry.merge([plinth, drum, top])


def bust() -> Triangles:
    """Head and shoulders in a cloak, with their foot; it reaches a little into the pedestal."""
    clay = Clay((-0.36, -0.02, -0.24), (0.36, 0.74, 0.26), 0.0055)
    _torso(clay)
    _head(clay)
    _face(clay)
    _hair(clay)
    sculpted = clay.solid()
    profile = [
        (0, 0.0),
        (0.13, 0.0),
        (0.13, 0.0),
        (0.125, 0.03),
        (0.07, 0.05),
        (0.065, 0.08),
        (0.09, 0.12),
        (0.09, 0.12),
        (0.0, 0.16),
    ]
    foot = geometry.lathe(np.array(profile), 96)
    # Heights of the bust begin at the foot's neck.
    whole = geometry.merge([foot, geometry.moved(sculpted, (0, 0.04, 0))])
    return geometry.moved(whole._replace(positions=_SCALE * whole.positions), (0, PEDESTAL - 0.005, 0))


def _torso(clay: Clay) -> None:
    """Chest, shoulders and neck, with a cloak that falls in folds from the left shoulder."""

    def at(x: float, y: float, z: float) -> tuple[float, float, float]:
        """Of the torso's own coordinates: narrower, and up to the head."""
        return 0.92 * x, y + 0.05, z

    clay.rod(at(0, 0.06, -0.01), at(0, 0.17, -0.005), (0.05, 0.1), soft=0.03)
    clay.ball(at(0, 0.2, -0.01), (0.19, 0.13, 0.115), soft=0.05)
    for side in (-1, 1):
        clay.rod(at(side * 0.05, 0.285, -0.03), at(side * 0.205, 0.235, -0.02), (0.055, 0.075), soft=0.05)
        clay.rod(at(side * 0.215, 0.235, -0.02), at(side * 0.225, 0.16, -0.01), (0.07, 0.06), soft=0.04)
        clay.ball(at(side * 0.075, 0.205, 0.065), (0.08, 0.06, 0.05), soft=0.04)
        clay.rod(at(0, 0.29, 0.055), at(side * 0.14, 0.305, 0.0), (0.012, 0.016), soft=0.025)  # collarbone
        clay.rod(
            at(side * 0.012, 0.295, 0.05), at(side * 0.055, 0.42, -0.01), (0.014, 0.016), soft=0.03
        )  # sinew
    clay.rod(at(0, 0.27, -0.025), at(0, 0.43, -0.005), (0.066, 0.058), soft=0.05)
    for k in range(7):
        t = k / 6
        over = [
            (0.27 - 0.13 * t, 0.20 + 0.09 * t, -0.10),
            (0.245 - 0.13 * t, 0.285 + 0.035 * t, -0.02),
            (0.17 - 0.13 * t, 0.225 + 0.03 * t, 0.095 + 0.01 * np.sin(5 * t)),
            (0.05 - 0.14 * t, 0.135 + 0.03 * t, 0.125),
            (-0.09 - 0.10 * t, 0.10 + 0.035 * t, 0.085 - 0.03 * t),
        ]
        _strand(clay, np.array([at(*point) for point in over]), 0.021 - 0.004 * (k % 2), soft=0.012)
    for k in range(5):  # on the other shoulder
        t = k / 4
        over = [
            (-0.25 + 0.10 * t, 0.16 + 0.1 * t, -0.1),
            (-0.275 + 0.11 * t, 0.255 + 0.05 * t, -0.025),
            (-0.255 + 0.08 * t, 0.17 + 0.02 * t, 0.06 + 0.02 * t),
            (-0.2 + 0.06 * t, 0.10, 0.06 + 0.03 * t),
        ]
        _strand(clay, np.array([at(*point) for point in over]), 0.019, soft=0.012)


def _strand(clay: Clay, points: Array, radius: float, soft: float) -> None:
    """A fold or lock along a curve."""
    line = curve(points, 5)
    for start, end in pairwise(line):
        clay.rod(start, end, (radius, radius), soft=soft)


def _head(clay: Clay) -> None:
    """Skull, jaw and ears."""
    clay.ball((0, 0.545, -0.015), (0.08, 0.095, 0.1), soft=0.03)
    clay.ball((0, 0.5, 0.03), (0.066, 0.095, 0.062), soft=0.04)
    clay.ball((0, 0.445, 0.04), (0.05, 0.042, 0.05), soft=0.03)
    clay.ball((0, 0.418, 0.077), (0.02, 0.018, 0.016), soft=0.02)
    for side in (-1, 1):
        clay.rod((side * 0.06, 0.475, 0.0), (side * 0.025, 0.42, 0.06), (0.018, 0.014), soft=0.03)  # jaw
        clay.ball((side * 0.082, 0.51, -0.012), (0.011, 0.032, 0.02), soft=0.008)
        clay.ball((side * 0.092, 0.513, -0.008), (0.006, 0.02, 0.01), soft=0.006, carve=True)


def _face(clay: Clay) -> None:
    """Eyes, brows, nose, cheeks and lips."""
    for side in (-1, 1):
        clay.ball((side * 0.033, 0.524, 0.098), (0.021, 0.014, 0.02), soft=0.014, carve=True)
        clay.ball((side * 0.032, 0.523, 0.074), (0.016, 0.0135, 0.016), soft=0.002)
        clay.rod((side * 0.018, 0.535, 0.089), (side * 0.048, 0.532, 0.077), (0.0045, 0.0045), soft=0.006)
        clay.rod((side * 0.018, 0.512, 0.087), (side * 0.046, 0.513, 0.077), (0.0035, 0.0035), soft=0.006)
        clay.rod((side * 0.012, 0.549, 0.09), (side * 0.05, 0.552, 0.07), (0.009, 0.008), soft=0.014)
        clay.ball((side * 0.042, 0.487, 0.066), (0.022, 0.02, 0.018), soft=0.025)
        clay.ball((side * 0.0125, 0.48, 0.1), (0.0095, 0.009, 0.011), soft=0.006)
    clay.rod((0, 0.545, 0.09), (0, 0.486, 0.113), (0.0095, 0.0125), soft=0.01)
    clay.rod((-0.021, 0.4535, 0.086), (0, 0.457, 0.096), (0.0045, 0.008), soft=0.006)
    clay.rod((0.021, 0.4535, 0.086), (0, 0.457, 0.096), (0.0045, 0.008), soft=0.006)
    clay.rod((-0.015, 0.443, 0.087), (0.015, 0.443, 0.087), (0.0075, 0.0075), soft=0.006)
    clay.rod((-0.022, 0.4495, 0.098), (0.022, 0.4495, 0.098), (0.0035, 0.0035), soft=0.004, carve=True)


def _hair(clay: Clay) -> None:
    """Curls all over the skull, leaving the face and ears free."""
    number = 150
    k = np.arange(number) + 0.5
    height, azimuth = 1 - 1.55 * k / number, np.pi * (1 + 5**0.5) * k
    across = np.sqrt(1 - height**2)
    way = np.stack([across * np.sin(azimuth), height, across * np.cos(azimuth)], 1)
    place = np.array([0, 0.55, -0.018]) + way * (0.084, 0.098, 0.104)
    hairline = 0.585 - 1.1 * np.clip(place[:, 2] - 0.04, -0.07, 0)  # lower at the temples and the neck
    behind = place[:, 2] < -0.03
    for centre, outwards in zip(
        place[(place[:, 1] > hairline) | behind], way[(place[:, 1] > hairline) | behind], strict=True
    ):
        clay.ball(centre, 0.0155, soft=0.007)
        clay.ball(centre + 0.0155 * outwards, 0.0055, soft=0.004, carve=True)
