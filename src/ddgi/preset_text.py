"""Settings as TOML to read and edit: each field with what it means and what it accepts."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from inspect import getdoc
from textwrap import wrap
from typing import Any

import tomlkit

from ddgi.config import NOTHING, lists
from ddgi.constraints import accepts, documentation
from ddgi.settings import RenderSettings
from ddgi.settings_group import field_hints

WIDTH = 98
"""Longest comment [characters]."""

SUMMARIES = {
    "default": "ours: whatever measures best",
    "fine": "ours for stills: twice the rays, and light between near things in every pixel, at three times the cost",
    "scale": "Majercik et al. 2021, Scaling Probe-Based Real-Time Dynamic Global Illumination",
    "blog": "McGuire 2019, the web articles on dynamic diffuse global illumination",
    "ctu": "the thesis at CTU Prague",
    "mff": "the thesis at MFF, Charles University: full paths per probe ray",
    "classic": "irradiance probes without visibility, what DDGI improves on",
}
"""A line for each preset."""


def to_toml(settings: RenderSettings) -> str:
    """Settings as TOML that `ddgi.config` reads back to the same value."""
    document = tomlkit.document()
    _add_fields(document, settings)
    return tomlkit.dumps(document)


def _add_fields(container: Any, settings: Any) -> None:
    """Put every field of a settings dataclass into a TOML table, groups as tables of their own."""
    for field, (name, hint) in zip(fields(settings), field_hints(type(settings)).items(), strict=True):
        value = getattr(settings, name)
        if is_dataclass(value):
            table = tomlkit.table()
            table.comment(_one_line(getdoc(value)))
            _add_fields(table, value)
            container.add(name, table)
            continue
        default = tomlkit.item(_plain(field.default)).as_string()
        for line in wrap(f"{documentation(hint)}; {accepts(hint)}; default: {default}", WIDTH):
            container.add(tomlkit.comment(line))
        container.add(name, _plain(value))


def _plain(value: Any) -> Any:
    """A value as TOML has it."""
    if value is None:
        return NOTHING[0]
    return lists(value)


def _one_line(text: str | None) -> str:
    return " ".join((text or "").split())
