"""MTL files: materials as written, nothing of them judged yet."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.notes import Notes
from ddgi.scene.obj.statements import read_statements

COLORS = {"Kd": "diffuse", "Ks": "specular", "Ke": "emission", "Tf": "filter"}
NUMBERS = {"Ns": "shininess", "Ni": "ior", "d": "opacity", "Tr": "transparency", "illum": "illum"}
PICTURES = {"map_Kd": "diffuse", "map_Ke": "emission", "map_d": "opacity"}
SILENT = ("Ka", "map_Ka", "Km", "sharpness")
"""Ambient light is what the field is for."""
ARGUMENTS = {
    "-blendu": 1, "-blendv": 1, "-boost": 1, "-bm": 1, "-cc": 1, "-clamp": 1, "-imfchan": 1, "-mm": 2,
    "-texres": 1, "-type": 1, "-o": 3, "-s": 3, "-t": 3,
}  # fmt: skip
UP_TO = ("-o", "-s", "-t")
"""Options that may have fewer arguments."""


@dataclass(frozen=True)
class Picture:
    """A picture in a material."""

    file: str
    folder: Path
    owner: str  # the line, for messages
    offset: tuple[float, float] = (0.0, 0.0)
    scale: tuple[float, float] = (1.0, 1.0)
    clamp: bool = False


@dataclass
class Material:
    """A material; None where the file says nothing."""

    name: str
    diffuse: np.ndarray | None = None  # (3,) linear
    specular: np.ndarray | None = None
    emission: np.ndarray | None = None  # [W/(m^2 sr)]
    filter: np.ndarray | None = None
    shininess: float | None = None  # exponent
    ior: float | None = None
    opacity: float | None = None
    transparency: float | None = None
    illum: float | None = None
    pictures: dict[str, Picture] = field(default_factory=dict)


def read_materials(path: Path, notes: Notes) -> dict[str, Material]:
    """The materials of a file by name.

    Raises:
        SceneError: A line is wrong; the message says which and how.
    """
    out: dict[str, Material] = {}
    current: Material | None = None
    unread: set[str] = set()  # each is told once
    for line, keyword, rest in read_statements(path):
        owner = f"{path}: line {line}: {keyword}"
        if keyword == "newmtl":
            current = out[rest] = Material(rest)
        elif current is None:
            raise SceneError(f"{owner} stands before the first newmtl")
        elif keyword in COLORS:
            setattr(current, COLORS[keyword], _color(rest, owner, notes))
        elif keyword in NUMBERS:
            setattr(current, NUMBERS[keyword], _numbers(rest.removeprefix("-halo"), owner)[0])
        elif keyword in PICTURES:
            current.pictures[PICTURES[keyword]] = _picture(rest, path.parent, owner)
        elif keyword not in SILENT:
            if keyword not in unread:
                notes.add(f"{path.name}: line {line}: lines that start with {keyword!r} are not read")
            unread.add(keyword)
    return out


def _color(text: str, owner: str, notes: Notes) -> np.ndarray | None:
    if text.split(None, 1)[:1] == ["spectral"]:
        notes.add("a spectral colour in an MTL file: not read")
        return None
    xyz = text.startswith("xyz")
    values = _numbers(text.removeprefix("xyz"), owner)
    if xyz:
        notes.add("an xyz colour in an MTL file: taken as RGB")
    color = np.array(values[:3] if len(values) >= 3 else values[:1] * 3)
    if (color < 0).any():
        raise SceneError(f"{owner} is negative")
    return color


def _numbers(text: str, owner: str) -> list[float]:
    try:
        values = [float(x) for x in text.split()]
    except ValueError as error:
        raise SceneError(f"{owner} {text[:40]!r} is not made of numbers") from error
    if not values or not np.isfinite(values).all():
        raise SceneError(f"{owner} needs finite numbers")
    return values


def _picture(text: str, folder: Path, owner: str) -> Picture:
    """Options and then the name, which may have spaces in it."""
    options: dict[str, list[str]] = {}
    rest = text
    while (head := rest.split(None, 1)) and head[0] in ARGUMENTS:
        option, rest = head[0], head[1] if len(head) > 1 else ""
        options[option] = []
        while len(options[option]) < ARGUMENTS[option] and (parts := rest.split(None, 1)):
            if option in UP_TO and not _is_number(parts[0]):
                break
            options[option].append(parts[0])
            rest = parts[1] if len(parts) > 1 else ""
    if not rest:
        raise SceneError(f"{owner} names no picture")
    offset = _pair(options.get("-o", []), 0.0)
    scale = _pair(options.get("-s", []), 1.0)
    return Picture(rest, folder, owner, offset, scale, options.get("-clamp") == ["on"])


def _pair(values: list[str], default: float) -> tuple[float, float]:
    u, v = [*map(float, values), default, default][:2]
    return u, v


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False
