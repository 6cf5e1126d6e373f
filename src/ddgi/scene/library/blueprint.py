"""What a built-in scene is before Mitsuba loads it. Imports neither Mitsuba nor NumPy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ddgi.scene.rig import Rig

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Blueprint:
    """A scene described, ready for `mi.load_dict(blueprint.description, optimize=False)`."""

    description: dict[str, Any]
    """Shapes, emitters, and cameras: one `perspective` entry each, under the camera's name, best first."""

    box: tuple[Point, Point] | None = None
    """(low, high) of what probes should cover, inner faces of the walls included [m]; None: everything."""

    rig: Rig | None = None
    """What moves, and how, by names of shapes, lights and cameras."""


@dataclass(frozen=True)
class BuiltIn:
    """A scene the package builds itself."""

    name: str
    summary: str
    """One line for listings."""

    build: Callable[..., Blueprint]
    """Called with the scene's own keyword parameters, all optional, once a Mitsuba variant is set."""
