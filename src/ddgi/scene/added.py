"""What the caller adds to a scene, takes out of it, and wants to move in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ddgi.scene.daylight import AddedLights

if TYPE_CHECKING:
    from ddgi.scene.ceiling import Height


@dataclass(frozen=True)
class Added:
    """See `load_scene` for meaning and units."""

    lights: AddedLights = AddedLights()
    ceiling: Height | None = None
    clear: tuple[str, ...] = ()
    movable: tuple[str, ...] = ()
