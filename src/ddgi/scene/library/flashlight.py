"""Two dark rooms, and a flashlight that looks around in them: a small bright light that moves."""

from __future__ import annotations

import numpy as np

from ddgi.scene.library.blueprint import Blueprint, Point
from ddgi.scene.library.ingredients import spot
from ddgi.scene.library.moving import Carried, rig, turns_about
from ddgi.scene.library.two_rooms import two_rooms

HELD: Point = (3.2, 1.4, 0.6)
"""Where it is held at first [m], in the room that has the lamp in `two-rooms`."""
AIMED: Point = (1.0, 0.9, -1.2)
LASTS, STEPS = 6.0, 24


def flashlight(wall: float = 0.2, intensity: float = 60.0) -> Blueprint:
    """Build the rooms without their lamp.

    Args:
        wall: Thickness of the walls [m].
        intensity: Of the flashlight along its axis [W/sr].
    """
    rooms = two_rooms(wall)
    description = {name: part for name, part in rooms.description.items() if name != "lamp"}
    description["flashlight"] = spot(HELD, AIMED, (intensity, 0.95 * intensity, 0.8 * intensity), 18.0, 9.0)
    phase = np.linspace(0, 2 * np.pi, STEPS + 1)
    places = np.array(HELD) + np.stack(
        [-0.8 * (1 - np.cos(phase)), 0.05 * np.sin(2 * phase), -0.3 * np.sin(phase)], 1
    )
    # To the door, and over the walls on either side of it.
    turns = turns_about((0.0, 1.0, 0.0), -55 * np.sin(phase))
    times = np.linspace(0, LASTS, STEPS + 1)
    return Blueprint(
        description,
        rooms.box,
        rig("look-around", [Carried("flashlight", times, places, turns, light="flashlight")]),
    )
