"""Where to stand in a room, and where to look: there is depth, variety and light, and nothing in the way."""

from __future__ import annotations

import numpy as np

from ddgi.lighting.lights import Lights
from ddgi.scene.viewpoint.rooms import FRONT, Places, is_room
from ddgi.scene.viewpoint.sight import Sight, brightness, see
from ddgi.scene.viewpoint.views import View, directions, frustum, lit, mean, variety
from ddgi.trace.tracer import Tracer

FOV = 75.0
"""Horizontal field of view [degrees]."""
PITCH = -6.0
"""Elevation of the view [degrees]."""
STANDS, AZIMUTHS = 64, 16
"""Places that are tried, and directions at each."""
STEP, WALL = 1.5, 0.15
"""How far to step back, at most, and what stays free behind, in heights of the room: who looks into a box
through its open side, or across a room, stands at its end."""
SHORT_LIST = 24
"""Views that are looked at closely."""
FINE = (48, 27)
NEAR = 0.7
"""What is nearer than so much of the room's height begins to be in the way."""
LEAST = 0.04
"""Share of the places tried that stand in rooms, at least: fewer are nooks of an object."""


def best_view(
    tracer: Tracer, lights: Lights, tried: Places, up: np.ndarray, reach: float, *, fronts: float = FRONT
) -> View | None:
    """The view of a room that shows most; None where there are no rooms.

    Args:
        tracer: The scene.
        lights: Its lights.
        tried: Places to choose from.
        up: (3,) unit.
        reach: What is further off counts as sky [m].
        fronts: Least share of fronts among what is seen from a place.
    """
    rooms = _largest(tried[is_room(tried, fronts)])
    if not len(rooms) or len(rooms) < LEAST * len(tried):
        return None
    stands = rooms[np.arange(min(len(rooms), STANDS))]
    place, forward, unit = _directed(tracer, stands, up)
    sight = see(tracer, place[:, None, None], frustum(forward, up, FOV))
    short = np.argsort(-_shown(sight, unit, reach), kind="stable")[:SHORT_LIST]
    place, forward, unit = place[short], forward[short], unit[short]
    rays = frustum(forward, up, FOV, FINE)
    sight = see(tracer, place[:, None, None], rays)
    light = lit(brightness(tracer, lights, place[:, None, None], rays))
    best = int((_shown(sight, unit, reach) * (light if light.any() else 1)).argmax())
    depth = float(np.median(np.minimum(sight.distance[best], reach)))
    return View(place[best], place[best] + depth * forward[best], FOV, bool(light[best] > 0))


def _directed(tracer: Tracer, stands: Places, up: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Views all around from places, and the same from as far back as one can step.

    Returns:
        (V, 3) place, (V, 3) direction, (V,) height of the room.
    """
    azimuth = np.arange(AZIMUTHS) / AZIMUTHS * 2 * np.pi
    forward = np.tile(directions(np.radians(PITCH), azimuth, up), (len(stands), 1))
    back = np.tile(directions(0.0, azimuth + np.pi, up), (len(stands), 1))
    place = np.repeat(stands.position, AZIMUTHS, 0)
    unit = np.repeat(stands.top - stands.floor, AZIMUTHS)
    free = see(tracer, place, back).distance - WALL * unit
    step = np.clip(free, 0, STEP * unit)[:, None] * back
    return np.concatenate([place, place + step]), np.tile(forward, (2, 1)), np.tile(unit, 2)


def _largest(rooms: Places) -> Places:
    """Those at least half as high as the room in which half of all the space is."""
    height = rooms.top - rooms.floor
    if not len(rooms):
        return rooms
    order = np.argsort(height, kind="stable")
    space = np.cumsum((height * rooms.width**2)[order])
    usual = height[order][np.searchsorted(space, 0.5 * space[-1])]
    return rooms[height >= 0.5 * usual]


def _shown(sight: Sight, unit: np.ndarray, reach: float) -> np.ndarray:
    """(V,) how much views show. unit: (V,) heights of their rooms [m]."""
    hit = sight.distance < reach
    distance = np.minimum(sight.distance, reach) / unit[:, None, None]
    depth = mean(np.log2(1 + np.minimum(distance, 20)) * hit)
    in_the_way, black, sky = mean(np.clip(1 - distance / NEAR, 0, 1)), mean(sight.black), mean(~hit)
    seen = depth * variety(sight, hit, unit[:, None, None]) ** 1.5
    return seen * (1 - in_the_way) ** 3 * (1 - black) ** 2 * (1 - sky)
