"""What options take besides numbers and words: sizes, points, directions, colours."""

from __future__ import annotations

import math
from typing import Any

import click


class Size(click.ParamType):
    """`WxH`, pixels."""

    name = "WxH"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """(width, height)."""
        if isinstance(value, tuple):
            return value
        width, _, height = value.lower().partition("x")
        if not (_is_side(width) and _is_side(height)):
            self.fail(f"{value!r} is not a size such as 640x360.", param, ctx)
        return int(width), int(height)


class Pixel(click.ParamType):
    """`X,Y`, column and row."""

    name = "X,Y"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """(column, row)."""
        if isinstance(value, tuple):
            return value
        parts = value.split(",")
        if len(parts) != 2 or not all(p.strip().isascii() and p.strip().isdigit() for p in parts):
            self.fail(f"{value!r} is not a pixel such as 120,45.", param, ctx)
        return int(parts[0]), int(parts[1])


class Finite(click.FloatRange):
    """A finite number within bounds, if there are any."""

    def _describe_range(self) -> str:
        """For the help, which would make "x<=None" of no bounds."""
        return "" if self.min is None and self.max is None else super()._describe_range()

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number."""
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value!r} is not a finite number.", param, ctx)
        return number


class Numbers(click.ParamType):
    """So many finite numbers, separated by commas."""

    def __init__(self, count: int, name: str) -> None:
        self.count, self.name = count, name

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, ...]:
        """The numbers."""
        if isinstance(value, tuple):
            return value
        numbers = parse_numbers(value)
        if numbers is None or len(numbers) != self.count:
            self.fail(f"{value!r} is not {self.count} finite numbers, separated by commas.", param, ctx)
        return numbers


class SpotLight(Numbers):
    """A spot light: where it stands and points [m], intensity [W/sr] and cutoff angle [degrees]."""

    def __init__(self) -> None:
        super().__init__(10, "FROM,TO,R,G,B,ANGLE")

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, ...]:
        """The numbers, if they make sense together."""
        numbers = super().convert(value, param, ctx)
        if numbers[:3] == numbers[3:6]:
            self.fail("a spot light cannot point at where it stands.", param, ctx)
        if not 0 < numbers[9] < 90:
            self.fail(f"the cutoff angle must lie between 0 and 90 degrees, not {numbers[9]:g}.", param, ctx)
        return numbers


class Word(click.ParamType):
    """One of some words, or three numbers."""

    def __init__(self, words: tuple[str, ...], name: str) -> None:
        self.words, self.name = words, name

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str | tuple[float, ...]:
        """The word or the numbers."""
        if isinstance(value, tuple) or value in self.words:
            return value
        numbers = parse_numbers(value)
        if numbers is None or len(numbers) != 3:
            self.fail(f"{value!r} is neither {', '.join(self.words)} nor three finite numbers.", param, ctx)
        return numbers


def Sky() -> Word:  # noqa: N802 - reads as the type that it makes
    """Mitsuba's model of a clear sky, or the radiance of an even one."""
    return Word(("sunsky",), "sunsky|R,G,B")


def Up() -> Word:  # noqa: N802
    """An axis, or a vector."""
    return Word(("x", "y", "z", "+x", "+y", "+z", "-x", "-y", "-z"), "AXIS|X,Y,Z")


class Ceiling(Finite):
    """A height, or where the scene's walls end."""

    name = "HEIGHT|auto"

    def _describe_range(self) -> str:
        return ""  # there are no bounds to tell in the help

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number, or "auto"."""
        if value == "auto" or isinstance(value, float):
            return value
        if parse_numbers(value) is None:
            self.fail(f"{value!r} is neither a height in metres nor auto.", param, ctx)
        return super().convert(value, param, ctx)


def parse_numbers(text: str) -> tuple[float, ...] | None:
    """Finite numbers separated by commas; None if they are not."""
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        return None
    return numbers if all(map(math.isfinite, numbers)) else None


def _is_side(text: str) -> bool:
    return text.isascii() and text.isdecimal() and len(text) < 10 and int(text) > 0
