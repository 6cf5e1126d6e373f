"""What options take besides numbers and words: sizes, points, colours, lamps."""

from __future__ import annotations

import math
from typing import Any

import click

Lamp = dict[str, Any]


class Size(click.ParamType):
    """`WxH`, pixels."""

    name = "WxH"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, int]:
        """(width, height)."""
        if isinstance(value, tuple):
            return value
        width, _, height = value.lower().partition("x")
        if not (_is_count(width) and _is_count(height)):
            self.fail(f"{value!r} is not a size such as 640x360.", param, ctx)
        return int(width), int(height)


class Numbers(click.ParamType):
    """So many finite numbers, separated by commas."""

    def __init__(self, count: int, name: str) -> None:
        self.count, self.name = count, name

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[float, ...]:
        """The numbers."""
        if isinstance(value, tuple):
            return value
        numbers = parse_numbers(value)
        if numbers is None or len(numbers) != self.count:
            self.fail(f"{value!r} is not {self.count} finite numbers ({self.name}).", param, ctx)
        return numbers


class Sky(click.ParamType):
    """`sunsky`, or the colour of an even sky."""

    name = "sunsky|R,G,B"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str | tuple[float, ...]:
        """The word, or three numbers."""
        if value == "sunsky" or isinstance(value, tuple):
            return value
        numbers = parse_numbers(value)
        if numbers is None or len(numbers) != 3:
            self.fail(f"{value!r} is neither sunsky nor three finite numbers.", param, ctx)
        return numbers


class PointLight(Numbers):
    """A point light: where [m], and its intensity [W/sr]."""

    def __init__(self) -> None:
        super().__init__(6, "X,Y,Z,R,G,B")

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """As a Mitsuba dictionary."""
        numbers = super().convert(value, param, ctx)
        return {"type": "point", "position": list(numbers[:3]), "intensity": _rgb(numbers[3:])}


class SpotLight(Numbers):
    """A spot light: where and towards where [m], its intensity [W/sr] and cutoff angle [degrees]."""

    def __init__(self) -> None:
        super().__init__(10, "X,Y,Z,TX,TY,TZ,R,G,B,ANGLE")

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """As a description; `lamp` makes it a Mitsuba dictionary once a backend is there."""
        numbers = super().convert(value, param, ctx)
        origin, target, angle = numbers[:3], numbers[3:6], numbers[9]
        if origin == target:
            self.fail("a spot light must point somewhere: its target is where it stands.", param, ctx)
        if not 0 < angle < 90:
            self.fail(f"a spot light's cutoff angle must lie between 0 and 90 degrees, not {angle:g}.", param, ctx)
        return {
            "type": "spot", "origin": origin, "target": target,
            "intensity": _rgb(numbers[6:9]), "cutoff_angle": angle,
        }  # fmt: skip


def lamp(light: Lamp) -> Lamp:
    """A light from the command line as `load_scene` takes it."""
    if light["type"] != "spot":
        return light
    import mitsuba as mi

    light = dict(light)
    origin, target = light.pop("origin"), light.pop("target")
    across = [0.0, 0.0, 1.0] if abs(target[2] - origin[2]) < 0.9 * math.dist(origin, target) else [0.0, 1.0, 0.0]
    return light | {"to_world": mi.ScalarTransform4f().look_at(origin=origin, target=target, up=across)}


def parse_numbers(text: str) -> tuple[float, ...] | None:
    """Finite numbers separated by commas; None if they are not."""
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        return None
    return numbers if all(map(math.isfinite, numbers)) else None


def _rgb(values: tuple[float, ...]) -> Lamp:
    return {"type": "rgb", "value": list(values)}


def _is_count(text: str) -> bool:
    return text.isascii() and text.isdecimal() and 0 < int(text) <= 65536
