"""A group of settings: a frozen dataclass that refuses values its annotations do not allow.

So a setting is checked where it is made, whether it comes from Python, a file or the command line, and
a stage never meets a value out of range.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, TypeVar, dataclass_transform, get_type_hints

import numpy as np

from ddgi.constraints import accepts
from ddgi.errors import SettingsError

Group = TypeVar("Group")


@dataclass_transform(frozen_default=True, kw_only_default=True)
def settings_group(name: str = "") -> Callable[[type[Group]], type[Group]]:
    """Make a class of annotated fields a group of settings.

    Args:
        name: Of the group, as messages and TOML files have it; empty for the whole.

    Raises:
        SettingsError: On making an instance with a value that its field does not allow; names the field.
    """

    def decorate(kind: type[Group]) -> type[Group]:
        kind.__post_init__ = _check  # type: ignore[attr-defined]
        group = dataclass(frozen=True, slots=True, kw_only=True)(kind)
        _PREFIXES[group] = f"{name}." if name else ""
        return group

    return decorate


_PREFIXES: dict[type, str] = {}
"""What stands before the field's name in messages."""


def field_hints(kind: Any) -> dict[str, Any]:
    """Annotations of a group by field, constraints included."""
    return _field_hints(kind)


@cache
def _field_hints(kind: Any) -> dict[str, Any]:
    hints = get_type_hints(kind, include_extras=True)
    return {f.name: hints[f.name] for f in fields(kind)}


def _check(group: Any) -> None:
    """Bring every field into its own type, or refuse it."""
    for name, hint in field_hints(type(group)).items():
        value = getattr(group, name)
        if hint not in _PREFIXES:
            object.__setattr__(group, name, _checked(value, hint, _PREFIXES[type(group)] + name))
        elif not isinstance(value, hint):
            raise SettingsError(f"{name} must be a group of settings, {hint.__module__}, not {value!r}")


def _checked(value: Any, hint: Any, name: str) -> Any:
    from pydantic import ValidationError

    plain = value.item() if isinstance(value, np.generic) else value
    try:
        return _adapter(hint).validate_python(plain, strict=True)
    except ValidationError as error:
        raise SettingsError(f"{name} must be {accepts(hint)}, not {_written(value)}") from error


def _written(value: Any) -> str:
    """As in a settings file."""
    return str(value).lower() if isinstance(value, bool) else repr(value)


@cache
def _adapter(hint: Any) -> Any:
    from pydantic import ConfigDict, TypeAdapter

    return TypeAdapter(hint, config=ConfigDict(allow_inf_nan=False))
