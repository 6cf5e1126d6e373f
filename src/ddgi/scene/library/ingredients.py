"""Short forms of the Mitsuba dictionaries that several built-in scenes need."""

from __future__ import annotations

from typing import Any

import mitsuba as mi

from ddgi.scene.library.blueprint import Point


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
