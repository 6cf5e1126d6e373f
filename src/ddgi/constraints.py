"""What a setting accepts, in words: for error messages and for the comments of printed settings.

Read from the annotations of the settings dataclasses, so code, check and text cannot disagree.
"""

from __future__ import annotations

from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Interval, Le, Lt
from typing_extensions import Doc

COUNTS = {1: "one", 2: "two", 3: "three", 4: "four"}


def accepts(hint: Any) -> str:
    """What values an annotation allows, as a noun phrase: "a whole number from 8 to 4096"."""
    hint, extras = unwrap(hint)
    origin, args = get_origin(hint), get_args(hint)
    if origin is Literal:
        return "one of " + ", ".join(str(a) for a in args)
    if origin in (Union, UnionType):
        kinds = [accepts(a) for a in args if a is not NoneType]
        return " or ".join([*kinds, "none"] if NoneType in args else kinds)
    if origin is tuple:
        return _several(args)
    return _scalar(hint) + _range(extras)


def optional(hint: Any) -> bool:
    """Whether an annotation allows None."""
    return NoneType in get_args(unwrap(hint)[0])


def documentation(hint: Any) -> str:
    """The text of the annotation's `Doc`."""
    return next((e.documentation for e in unwrap(hint)[1] if isinstance(e, Doc)), "")


def unwrap(hint: Any) -> tuple[Any, tuple[Any, ...]]:
    """The bare type of an annotation, and what `Annotated` adds to it."""
    if get_origin(hint) is Annotated:
        return hint.__origin__, hint.__metadata__
    return hint, ()


def _several(args: tuple[Any, ...]) -> str:
    """A tuple, written as TOML's arrays: "[[a], [b]]" if its members are tuples, else so many numbers."""
    inner = unwrap(args[0])[0]
    if get_origin(inner) is tuple:
        return "[" + ", ".join(f"[{accepts(a)}]" for a in args) + "]"
    noun = accepts(args[0]).removeprefix("a ").replace("number", "numbers", 1)
    return f"{COUNTS.get(len(args), str(len(args)))} {noun}"


def _scalar(kind: Any) -> str:
    return {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}.get(
        kind, str(kind)
    )


def _range(extras: tuple[Any, ...]) -> str:
    """The bounds among an annotation's extras, as words that follow a noun."""
    low = high = above = below = None
    for extra in extras:
        if isinstance(extra, (Interval, Ge)):
            low = extra.ge
        if isinstance(extra, (Interval, Le)):
            high = extra.le
        if isinstance(extra, (Interval, Gt)):
            above = extra.gt
        if isinstance(extra, (Interval, Lt)):
            below = extra.lt
    if low is not None and high is not None:
        return f" from {_figure(low)} to {_figure(high)}"
    words = [
        *([f"of {_figure(low)} or more"] if low is not None else []),
        *([f"above {_figure(above)}"] if above is not None else []),
        *([f"of {_figure(high)} or less"] if high is not None else []),
        *([f"below {_figure(below)}"] if below is not None else []),
    ]
    return " " + " and ".join(words) if words else ""


def _figure(bound: Any) -> str:
    """A bound, without a fraction that says nothing."""
    return str(bound) if isinstance(bound, int) else f"{bound:g}"
