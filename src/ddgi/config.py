"""Settings from outside: a preset, a TOML file and `stage.field=value` texts."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from ddgi.constraints import optional
from ddgi.errors import SettingsError
from ddgi.settings import RenderSettings
from ddgi.settings_group import field_hints

NOTHING = ("none", "auto")
"""What stands for None, which TOML has no word for."""


def load_settings(
    preset: str = "default", config: str | Path | None = None, assignments: Iterable[str] = ()
) -> RenderSettings:
    """Settings from all their sources; later ones win: preset, file, assignments.

    Args:
        preset: Name of the preset to start from.
        config: A TOML file, one table per stage.
        assignments: Texts `stage.field=value`, the value in TOML; words need no quotes.

    Raises:
        SettingsError: A key is unknown or a value not allowed; names the field.
    """
    settings = RenderSettings.preset(preset)
    if config is not None:
        try:
            settings = override(settings, read_toml(config))
        except SettingsError as error:
            raise SettingsError(f"{config}: {error}") from error
    for text in assignments:
        settings = override(settings, parse_assignment(text))
    return settings


def override(settings: Any, table: Mapping[str, Any], where: str = "") -> Any:
    """Settings with the values of a nested table in place of their own.

    Args:
        settings: A settings dataclass; one inside another is a table inside the table.
        table: Only what differs.
        where: Dotted name of `settings` in messages, with a dot at the end.

    Raises:
        SettingsError: A key is unknown or a value not allowed; names the field.
    """
    hints = field_hints(type(settings))
    changed = {}
    for key, value in table.items():
        if key not in hints:
            groups = [f.name for f in fields(settings) if key in _names(getattr(settings, f.name))]
            raise SettingsError(
                f"unknown setting {where}{key}: {_suggestion(key, where, list(hints), groups)}"
            )
        current = getattr(settings, key)
        if is_dataclass(current):
            if not isinstance(value, Mapping):
                names = ", ".join(f"{where}{key}.{f.name}" for f in fields(current))
                raise SettingsError(f"{where}{key} is a group: set one of {names}")
            changed[key] = override(current, value, f"{where}{key}.")
        else:
            none = optional(hints[key]) and isinstance(value, str) and value in NOTHING
            changed[key] = None if none else _tuples(value)
    return replace(settings, **changed)


def _names(group: Any) -> set[str]:
    """Of the settings in a group; a value has none."""
    return {f.name for f in fields(group)} if is_dataclass(group) else set()


def as_table(settings: Any) -> dict[str, Any]:
    """A settings dataclass as a nested table of plain values, which `override` reads back."""
    return {
        f.name: as_table(value) if is_dataclass(value) else lists(value)
        for f in fields(settings)
        for value in [getattr(settings, f.name)]
    }


def lists(value: Any) -> Any:
    """Tuples as TOML's arrays, all the way down."""
    return list(map(lists, value)) if isinstance(value, tuple) else value


def read_toml(path: str | Path) -> dict[str, Any]:
    """The content of a TOML file.

    Raises:
        SettingsError: It cannot be read or is not TOML.
    """
    try:
        with open(path, "rb") as file:
            return tomllib.load(file)
    except FileNotFoundError as error:
        raise SettingsError(
            "there is no such file; `ddgi presets default` prints one to start from"
        ) from error
    except OSError as error:
        raise SettingsError(str(error.strerror)) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SettingsError(f"not valid TOML: {error}") from error


def parse_assignment(text: str) -> dict[str, Any]:
    """`stage.field=value` as a nested table.

    Raises:
        SettingsError: There is no "=" or no name in front of it.
    """
    name, equals, value = text.partition("=")
    keys = [key.strip() for key in name.split(".")]
    if not equals or not all(keys):
        raise SettingsError(f"{text!r} does not read stage.field=value")
    table: Any = _parse_value(value.strip())
    for key in reversed(keys):
        table = {key: table}
    return table


def _parse_value(text: str) -> Any:
    """A TOML value, an array without its brackets too; what is none, such as a bare word, is a text."""
    for written in (text, f"[{text}]") if "," in text else (text,):
        with suppress(tomllib.TOMLDecodeError):
            parsed = tomllib.loads(f"value = {written}")
            if len(parsed) == 1:
                return parsed["value"]
    return text


def _tuples(value: Any) -> Any:
    """TOML's arrays as tuples, all the way down."""
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _suggestion(key: str, where: str, known: list[str], groups: list[str]) -> str:
    if groups:
        return f"did you mean {' or '.join(f'{where}{group}.{key}' for group in groups)}?"
    close = get_close_matches(key, known, n=1, cutoff=0.5)
    if close:
        return f"did you mean {where}{close[0]}?"
    return f"{where.rstrip('.') or 'settings'} has {', '.join(known)}"
