"""Balls that fall, bounce off walls, posts and each other, and roll: a small simulation, the same on every run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddgi.scene.library.geometry import Array

GRAVITY = 9.81
"""[m/s^2]."""
STEPS = 240
"""A second."""
BOUNCE = 0.78
"""Speed that is left along the normal after a bounce."""
GRIP = 0.35
"""Share of its slip that a ball loses at a contact: the rest turns into spin."""
DRAG = 0.15
"""Share of its speed that the air takes in a second."""
SPIN_SHARE = 2 / 3
"""Of a hollow ball's moment of inertia, in its mass times radius squared."""


@dataclass(frozen=True)
class Yard:
    """What the balls bounce off. Metres, +y up, the floor at y = 0."""

    low: tuple[float, float]  # x and z of the walls
    high: tuple[float, float]
    posts: tuple[tuple[float, float, float], ...] = ()  # x, z, radius; of any height


def tumble(
    yard: Yard, start: Array, radius: float, seconds: float, rate: float, seed: int
) -> tuple[Array, Array]:
    """Let balls go.

    Args:
        yard: What they bounce off.
        start: (N, 3) their middles in the beginning [m].
        radius: Of all of them [m].
        seconds: How long.
        rate: Moments that are kept, a second.
        seed: Of their first speeds and spins.

    Returns:
        (T, N, 3) middles [m], and (T, N, 4) rotations as unit quaternions x, y, z, w.
    """
    rng = np.random.default_rng(seed)
    place = np.array(start, np.float64)
    speed = rng.normal(0, 1.5, place.shape)
    spin = rng.normal(0, 3.0, place.shape)  # [rad/s]
    turn = np.tile([0.0, 0.0, 0.0, 1.0], (len(place), 1))
    every, dt = round(STEPS / rate), 1 / STEPS
    places, turns = [], []
    for step in range(round(seconds * STEPS) + 1):
        if step % every == 0:
            places.append(place.copy())
            turns.append(turn.copy())
        speed[:, 1] -= GRAVITY * dt
        speed *= 1 - DRAG * dt
        place += speed * dt
        turn = _turned(turn, spin * dt)
        _bounce_off_yard(yard, place, speed, spin, radius)
        _bounce_off_each_other(place, speed, radius)
    return np.array(places), np.array(turns)


def _bounce_off_yard(yard: Yard, place: Array, speed: Array, spin: Array, radius: float) -> None:
    """The floor, four walls, and posts; positions, speeds and spins are changed."""
    up, flat = np.array([0.0, 1.0, 0.0]), np.zeros_like(place)
    _bounce(place, speed, spin, radius, np.broadcast_to(up, place.shape), place[:, 1] - radius)
    for axis, (low, high) in zip((0, 2), zip(yard.low, yard.high, strict=True), strict=True):
        normal = flat.copy()
        normal[:, axis] = 1
        _bounce(place, speed, spin, radius, normal, place[:, axis] - radius - low)
        _bounce(place, speed, spin, radius, -normal, high - place[:, axis] - radius)
    for x, z, size in yard.posts:
        away = (place - [x, 0, z]) * [1, 0, 1]
        distance = np.linalg.norm(away, axis=1)
        normal = away / np.maximum(distance, 1e-9)[:, None]
        _bounce(place, speed, spin, radius, normal, distance - radius - size)


def _bounce(place: Array, speed: Array, spin: Array, radius: float, normal: Array, gap: Array) -> None:
    """Balls whose gap to something is gone are put back, and sent away from it along its normal; grip makes them roll."""
    hit = gap < 0
    if not hit.any():
        return
    n = normal[hit]
    place[hit] -= gap[hit, None] * n
    along = (speed[hit] * n).sum(1, keepdims=True)
    inwards = np.minimum(along, 0)
    slip = speed[hit] - along * n + np.cross(spin[hit], -radius * n)
    push = -GRIP * slip
    speed[hit] += push - (1 + BOUNCE) * inwards * n
    spin[hit] += np.cross(-n, push) / (SPIN_SHARE * radius)


def _bounce_off_each_other(place: Array, speed: Array, radius: float) -> None:
    """Pairs that overlap are parted, and swap what they approach each other by."""
    between = place[:, None] - place[None]
    distance = np.linalg.norm(between, axis=-1)
    first, second = np.nonzero(np.triu(distance < 2 * radius, 1))
    for i, j in zip(first, second, strict=True):
        n = between[i, j] / max(float(distance[i, j]), 1e-9)
        apart = 0.5 * (2 * radius - distance[i, j]) * n
        place[i] += apart
        place[j] -= apart
        closing = min(float((speed[i] - speed[j]) @ n), 0.0)
        speed[i] -= 0.5 * (1 + BOUNCE) * closing * n
        speed[j] += 0.5 * (1 + BOUNCE) * closing * n


def _turned(turn: Array, angle: Array) -> Array:
    """Quaternions (N, 4) turned further by rotation vectors (N, 3) [rad]."""
    size = np.linalg.norm(angle, axis=1, keepdims=True)
    half = np.concatenate([angle * (0.5 * np.sinc(size / (2 * np.pi))), np.cos(size / 2)], 1)
    a, b = half, turn
    vector = a[:, 3:] * b[:, :3] + b[:, 3:] * a[:, :3] + np.cross(a[:, :3], b[:, :3])
    scalar = a[:, 3] * b[:, 3] - (a[:, :3] * b[:, :3]).sum(1)
    out = np.concatenate([vector, scalar[:, None]], 1)
    return out / np.linalg.norm(out, axis=1, keepdims=True)
