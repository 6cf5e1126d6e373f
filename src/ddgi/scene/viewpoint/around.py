"""Where to stand to see an object: far enough that it fits, on the side where there is most to see."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddgi.lighting.lights import Lights
from ddgi.scene.viewpoint.sight import brightness, see
from ddgi.scene.viewpoint.views import SIZE, View, directions, frustum, lit, mean, variety
from ddgi.trace.tracer import Tracer

FOV = 45.0
"""Horizontal field of view [degrees]."""
MARGIN = 0.06
"""Of half the picture, left free around the object."""
AZIMUTHS = 24
USUAL = 30.0
"""Azimuth of a three-quarter view, all else being equal [degrees]."""
ELEVATIONS = {20.0: 1.0, 45.0: 0.8, -20.0: 0.55, 75.0: 0.55, -60.0: 0.4}
"""Of the camera [degrees], and how much each is worth, all else being equal."""


@dataclass(frozen=True)
class Orbit:
    """A circle around an object, from all of which it fits into the picture."""

    target: np.ndarray  # (3,) what the cameras look at, on the object's axis [m]
    elevation: float  # [radians]
    distance: float  # [m]


def orbit(points: np.ndarray, up: np.ndarray, elevation: float, aspect: float) -> Orbit:
    """The nearest orbit from which a body fits into the picture at every azimuth.

    Turned around its axis, a point sweeps a circle, which the camera sees from an elevation; how far off
    the camera must be for the circle to stay within one side of the picture is the maximum of
    A cos + B sin over the turn, sqrt(A² + B²).

    Args:
        points: (V, 3) the body [m].
        up: (3,) unit; the axis runs through the middle of the box around the body.
        elevation: Of the camera above the middle [radians].
        aspect: Width of the picture over its height.
    """
    middle = 0.5 * (points.min(0) + points.max(0))
    offset = points - middle
    y = offset @ up
    radius = np.linalg.norm(offset - y[:, None] * up, axis=1)
    half_x = np.tan(0.5 * np.radians(FOV)) * (1 - MARGIN)
    half_y = half_x / aspect
    sin, cos = np.sin(elevation), np.cos(elevation)
    aside = (radius * np.hypot(1 / half_x, cos) + y * sin).max()
    above = (y * (cos / half_y + sin) + radius * abs(cos - sin / half_y)).max()
    below = (y * (sin - cos / half_y) + radius * abs(cos + sin / half_y)).max()
    # Looking a little higher or lower leaves as much free above as below.
    shift = half_y * (above - below) / 2
    distance = max(aside, (above + below) / 2)
    return Orbit(middle + shift / cos * up, elevation, distance - shift * sin / cos)


def best_view(tracer: Tracer, lights: Lights, points: np.ndarray, up: np.ndarray) -> View:
    """From where most of a body is seen, and most of it varied and lit.

    Args:
        tracer: The scene.
        lights: Its lights.
        points: (V, 3) the body [m].
        up: (3,) unit.
    """
    azimuth = np.arange(AZIMUTHS) / AZIMUTHS * 2 * np.pi
    habit = 1 + 0.1 * np.cos(azimuth - np.radians(USUAL))
    origin, target, score = [], [], []
    for degrees, worth in ELEVATIONS.items():
        circle = orbit(points, up, np.radians(degrees), SIZE[0] / SIZE[1])
        towards = directions(np.radians(degrees), azimuth, up)
        origin.append(circle.target + circle.distance * towards)
        target.append(np.broadcast_to(circle.target, towards.shape))
        score.append(worth * habit)
    places, targets = np.concatenate(origin), np.concatenate(target)
    forward = targets - places
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    shown, light = _shown(tracer, lights, places, forward, points, up)
    best = int((np.concatenate(score) * shown * (light if light.any() else 1)).argmax())
    return View(places[best], targets[best], FOV, bool(light[best] > 0))


def _shown(tracer, lights, places, forward, points, up) -> tuple[np.ndarray, np.ndarray]:
    """(V,) how much of a body views show, and how well it is lit there."""
    rays = frustum(forward, up, FOV)
    sight = see(tracer, places[:, None, None], rays)
    size = float(np.ptp(points, axis=0).max())
    slack = 1e-3 * size
    body = sight.hit & (
        (sight.position >= points.min(0) - slack) & (sight.position <= points.max(0) + slack)
    ).all(-1)
    seen = np.sqrt(mean(body & ~sight.black)) * (2 + variety(sight, body, size))
    light = brightness(tracer, lights, places[:, None, None], rays)
    return seen, lit(np.where(body, light, np.nan))
