"""A coiled dragon with scales, horns and an open mouth: an organic figure of many small hollows.

It stands on y = 0 about the y axis and faces +z; every part is a closed solid, and parts reach into
one another. Metres.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ddgi.scene.library import geometry
from ddgi.scene.library.geometry import Array, Triangles
from ddgi.scene.library.sculpting import Clay, curve, frames, tube

TURNS = (-0.75, 2.4)
"""From the tail's tip to where the neck leaves the heap; the first turn that rises begins at 0."""

_THICK = 0.15  # radius of the body [m]
_SCALES = 14  # around the body
_SIDES = 56  # points around the body: four for each scale
_HEAD = np.array([0.0, 1.47, 0.15])  # where the head sits on the neck [m]


def dragon() -> Triangles:
    """The whole figure: 1.8 m wide and 1.8 m tall."""
    path, hints, radii = _spine()
    return geometry.merge(
        [
            tube(path, radii * _scales(path, radii), hints, sides=_SIDES),
            *_crest(path, hints, radii),
            *_legs(),
            *(geometry.moved(part, _HEAD) for part in _head()),
        ]
    )


def _spine() -> tuple[Array, Array, Array]:
    """The body's axis (N, 3) [m], the way its back points (N, 3), and its radius (N,) [m]."""
    turn = np.linspace(*TURNS, 40)[:-1]
    angle = 2 * np.pi * (turn - TURNS[1]) + np.pi  # leaves the heap behind the axis
    outwards = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], 1)
    radius = _THICK * np.clip((turn - TURNS[0]) / 0.8, 0, 1) ** 0.7
    distance = 0.64 - np.where(turn < 0, 0.22, 0.16) * turn
    height = np.where(turn < 0, radius, _THICK + 0.2 * turn) + 0.01
    heap = np.column_stack(
        [distance[:, None] * outwards + np.outer(height, (0, 1, 0)), 0.8 * outwards + (0, 0.6, 0), radius]
    )
    neck = np.array(  # axis, back, radius
        [
            (-0.02, 0.64, -0.25, -0.1, 0.60, -0.80, 0.150),
            (-0.16, 0.71, -0.20, -0.5, 0.50, -0.60, 0.147),
            (-0.23, 0.86, -0.10, -0.8, 0.20, -0.40, 0.142),
            (-0.19, 1.03, -0.04, -0.5, 0.10, -0.80, 0.133),
            (-0.09, 1.19, -0.05, -0.2, 0.10, -1.00, 0.122),
            (-0.03, 1.33, -0.03, -0.1, 0.35, -1.00, 0.108),
            (0.00, 1.43, 0.05, 0.0, 0.60, -0.80, 0.100),
            (0.00, 1.49, 0.14, 0.0, 0.80, -0.60, 0.085),
        ]
    )
    line = curve(np.concatenate([heap, neck]), 14)
    line[0, 6] = 0.0
    return line[:, :3], line[:, 3:6], line[:, 6]


def _scales(path: Array, radii: Array) -> Array:
    """(_SIDES, N) factors on the radius: diamonds on the back and flanks, broad plates on the belly."""
    step = np.linalg.norm(np.diff(path, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(step / np.maximum(radii[1:], 0.03))]) * _SCALES / (2 * np.pi)
    around = _SCALES * np.arange(_SIDES)[:, None] / _SIDES
    diamonds = abs(np.sin(0.5 * np.pi * (around + along)) * np.sin(0.5 * np.pi * (around - along)))
    plates = abs(np.sin(0.5 * np.pi * along)) ** 0.5
    from_back = np.minimum(around, _SCALES - around) / _SCALES  # 0 on the back, 1/2 on the belly
    belly = np.clip((from_back - 0.36) / 0.03, 0, 1)
    return 1 + 0.09 * np.sqrt(diamonds) * (1 - belly) + 0.06 * plates * belly


def _crest(path: Array, hints: Array, radii: Array) -> Iterator[Triangles]:
    """Flat thorns along the back that lean towards the tail."""
    back, _ = frames(path, hints)
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    for place in np.arange(0.35, length[-1] - 0.12, 0.11):
        i = int(np.searchsorted(length, place))
        size = 0.03 + 0.62 * radii[i]
        foot = path[i] + 0.9 * radii[i] * back[i]
        rise = np.array([0.0, 0.4, 0.8, 1.15])[:, None] * size
        lean = np.array([0.0, 0.05, 0.3, 0.75])[:, None] * size
        yield tube(
            foot + rise * back[i] - lean * along[i],
            size * np.array([0.52, 0.42, 0.22, 0.0]),
            along[i],
            sides=10,
            flatness=0.3,
        )


def _legs() -> Iterator[Triangles]:
    """Two forelegs that rest on the heap, with four claws each."""
    for side in (-1, 1):
        points = [
            (0.05, 0.91, 0.0),
            (0.20, 0.96, -0.02),
            (0.32, 0.92, 0.0),
            (0.36, 0.80, 0.11),
            (0.31, 0.73, 0.24),
        ]
        path = curve(np.array(points) * (side, 1, 1), 10)
        radii = np.interp(np.linspace(0, 1, len(path)), [0, 0.3, 0.6, 0.85, 1], [0.09, 0.08, 0.06, 0.05, 0.0])
        yield tube(path, radii, (0, 0.3, 1), sides=24)
        for spread in (-0.9, -0.3, 0.3, 0.9):
            toe = np.array([np.sin(spread + 0.2 * side), 0, np.cos(spread + 0.2 * side)])
            wrist = path[-4]
            claw = curve(
                np.stack(
                    [
                        wrist,
                        wrist + 0.07 * toe + (0, 0.025, 0),
                        wrist + 0.13 * toe,
                        wrist + 0.16 * toe - (0, 0.06, 0),
                    ]
                ),
                6,
            )
            yield tube(claw, np.linspace(0.034, 0.0, len(claw)) ** 0.8 * 0.5, (0, 1, 0), sides=10)


def _head() -> Iterator[Triangles]:
    """The head about its joint with the neck, mouth open towards +z."""
    yield _skull()
    for side in (-1, 1):
        mirror = np.array([side, 1, 1])
        horn = curve(
            np.array([(0.05, 0.07, -0.02), (0.10, 0.18, -0.12), (0.13, 0.24, -0.26), (0.11, 0.36, -0.36)])
            * mirror,
            10,
        )
        yield tube(horn, 0.036 * (1 - np.linspace(0, 1, len(horn)) ** 1.5), (0, 0.3, 1), sides=20)
        whisker = curve(
            np.array(
                [
                    (0.04, -0.01, 0.31),
                    (0.14, 0.02, 0.36),
                    (0.24, -0.06, 0.30),
                    (0.30, -0.20, 0.28),
                    (0.36, -0.22, 0.36),
                ]
            )
            * mirror,
            10,
        )
        yield tube(whisker, np.linspace(0.012, 0.0, len(whisker)), (0.1, 1, 0.3), sides=8)
        for k in range(6):  # a mane of thorns behind the cheeks
            angle = np.radians(-50 + 26 * k)
            outwards = np.array([side * np.cos(angle), np.sin(angle), 0.0])
            foot = 0.08 * outwards - (0, 0, 0.02)
            reach = 0.13 + 0.03 * (k % 2)
            thorn = curve(
                np.stack(
                    [
                        foot,
                        foot + 0.6 * reach * outwards - (0, 0, 0.07),
                        foot + reach * outwards - (0, 0, 0.2),
                    ]
                ),
                6,
            )
            yield tube(
                thorn, np.linspace(0.034, 0.0, len(thorn)), np.array([0, 0, 1.0]), sides=10, flatness=0.6
            )
        for k in range(6):  # teeth, the foremost longest
            t = k / 5
            upper = np.array([side * (0.07 - 0.032 * t), -0.045 - 0.004 * t, 0.10 + 0.21 * t])
            lower = np.array([side * (0.058 - 0.03 * t), -0.085 - 0.06 * t, 0.10 + 0.17 * t])
            size = 0.035 + (0.025 if k >= 4 else 0.0)
            yield tube(
                upper + np.outer([0, 0.6, 1], (0, -size, 0)), np.array([0.011, 0.007, 0]), (0, 0, 1), sides=8
            )
            yield tube(
                lower + np.outer([0, 0.6, 1], (0, size, 0)), np.array([0.010, 0.006, 0]), (0, 0, 1), sides=8
            )
    tongue = curve(
        np.array([(0, -0.07, 0.02), (0, -0.09, 0.12), (0, -0.115, 0.22), (0, -0.10, 0.30), (0, -0.12, 0.36)]),
        8,
    )
    yield tube(tongue, 0.03 * (1 - np.linspace(0, 1, len(tongue)) ** 3), (1, 0, 0), sides=16, flatness=0.4)


def _skull() -> Triangles:
    """Skull, jaws, brows and eyes."""
    clay = Clay((-0.24, -0.28, -0.24), (0.24, 0.24, 0.42), 0.006)
    clay.rod((0, -0.01, -0.14), (0, 0.0, 0.0), (0.085, 0.1), soft=0.04)
    clay.ball((0, 0.025, 0.03), (0.105, 0.09, 0.12), soft=0.05)
    for side in (-1, 1):
        clay.rod((side * 0.035, 0.01, 0.08), (side * 0.022, -0.015, 0.31), (0.06, 0.034), soft=0.03)
        clay.rod((side * 0.07, -0.07, 0.0), (side * 0.018, -0.165, 0.28), (0.04, 0.024), soft=0.03)
        clay.ball((side * 0.03, 0.012, 0.325), 0.026, soft=0.015)
        clay.rod((side * 0.035, 0.07, 0.15), (side * 0.105, 0.115, -0.03), (0.018, 0.032), soft=0.02)
        clay.rod((side * 0.09, -0.03, 0.0), (side * 0.16, -0.02, -0.12), (0.04, 0.012), soft=0.03)
        clay.ball((side * 0.088, 0.055, 0.095), 0.034, soft=0.012, carve=True)
        clay.ball((side * 0.03, 0.018, 0.352), 0.012, soft=0.006, carve=True)
    clay.rod((0, -0.16, 0.27), (0, -0.2, 0.3), (0.028, 0.012), soft=0.02)  # chin
    clay.rod((0, 0.06, 0.12), (0, 0.035, 0.3), (0.012, 0.014), soft=0.03)  # bridge of the nose
    clay.ball((0, -0.07, 0.2), (0.045, 0.03, 0.13), soft=0.02, carve=True)  # the palate
    for side in (-1, 1):
        clay.ball((side * 0.078, 0.053, 0.09), 0.027)
    return clay.solid()
