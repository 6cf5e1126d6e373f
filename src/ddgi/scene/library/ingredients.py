"""Short forms of the Mitsuba dictionaries that several built-in scenes need."""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.scene.library.blueprint import Point

NEAR_GAP = 0.02
"""From a front wall's inner face to the near plane of `front_camera` [m]."""


def diffuse(red: float, green: float, blue: float) -> dict[str, Any]:
    """A Lambertian of this albedo, seen only from its front: for closed solids.

    One-sided on purpose: rays that leave a probe inside a wall then see back faces, by which probe
    relocation and classification know where they are.
    """
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": [red, green, blue]}}


def sheet(red: float, green: float, blue: float) -> dict[str, Any]:
    """A Lambertian of this albedo on both sides: for cloth and other surfaces without thickness."""
    return {"type": "twosided", "bsdf": diffuse(red, green, blue)}


def camera(
    origin: Point,
    target: Point,
    *,
    up: Point = (0.0, 1.0, 0.0),
    fov: float = 70.0,
    near: float = 0.01,
    size: tuple[int, int] = (640, 360),
) -> dict[str, Any]:
    """A pinhole at `origin` [m] looking at `target` [m].

    Args:
        origin: Where it stands.
        target: The point in the middle of the picture.
        up: Direction that points up in the picture.
        fov: Horizontal field of view [degrees].
        near: Nothing closer than this is seen, along the view direction [m].
        size: (width, height) [pixels].
    """
    return {
        "type": "perspective",
        "fov": fov,
        "fov_axis": "x",
        "near_clip": near,
        "to_world": mi.ScalarTransform4f().look_at(origin=list(origin), target=list(target), up=list(up)),
        "film": film(size),
    }


def film(size: tuple[int, int]) -> dict[str, Any]:
    """A picture of (width, height) pixels, box filtered, so that pixels are independent."""
    width, height = size
    return {
        "type": "hdrfilm",
        "width": width,
        "height": height,
        "pixel_format": "rgb",
        "component_format": "float32",
        "rfilter": {"type": "box"},
    }


def sun(direction: Point, irradiance: tuple[float, float, float]) -> dict[str, Any]:
    """Parallel light that travels along `direction`; irradiance is that of a surface facing it [W/m^2]."""
    return {
        "type": "directional",
        "direction": list(direction),
        "irradiance": {"type": "rgb", "value": list(irradiance)},
    }


def spot(
    origin: Point, target: Point, intensity: tuple[float, float, float], cutoff: float, beam: float
) -> dict[str, Any]:
    """A spotlight at `origin` [m] that shines at `target` [m].

    Args:
        origin: Where it hangs.
        target: A point on its axis.
        intensity: Along the axis [W/sr].
        cutoff: Angle between the axis and the cone's rim, where its light ends [degrees].
        beam: Angle between the axis and where its light begins to fall off [degrees].
    """
    axis = np.subtract(target, origin)
    up = (0.0, 1.0, 0.0) if np.hypot(axis[0], axis[2]) > 1e-3 * abs(axis[1]) else (0.0, 0.0, 1.0)
    return {
        "type": "spot",
        "to_world": mi.ScalarTransform4f().look_at(origin=list(origin), target=list(target), up=list(up)),
        "intensity": {"type": "rgb", "value": list(intensity)},
        "cutoff_angle": cutoff,
        "beam_width": beam,
    }


def front_camera(low: Point, high: Point, distance: float) -> dict[str, Any]:
    """A camera that looks into a closed box along -z from outside, past its front wall.

    The near plane lies just inside that wall, so the wall keeps the light in, unseen; the box fills
    the picture's width.

    Args:
        low: Lower corner of the air in the box [m].
        high: Upper corner [m].
        distance: From the front wall's inner face [m]; further than a metre.
    """
    x, y = (low[0] + high[0]) / 2, (low[1] + high[1]) / 2
    near = distance + NEAR_GAP
    fov = 2 * np.degrees(np.arctan((high[0] - low[0]) / 2 / near))
    return camera((x, y, high[2] + distance), (x, y, low[2]), fov=0.998 * float(fov), near=near)
