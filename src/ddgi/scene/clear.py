"""Materials that the caller declares clear: light passes straight, for window panes that a file has opaque.

What is made of them gets Mitsuba's `null` in the plugin tree, so that it is clear for the path-traced reference
as well, and left out of what rays meet as glass is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import mitsuba as mi

from ddgi.errors import SceneError
from ddgi.scene.notes import Notes
from ddgi.scene.plugin_tree import PluginTree

KEY = "_clear"
"""Under which a shape finds its BSDF; like other names with an underscore in front, no file has it."""
COLLECTIONS = ("shapegroup", "merge")
NEAREST = 3
"""Names that an error lists."""


def make_clear(tree: PluginTree, wanted: Sequence[str], notes: Notes) -> None:
    """Make every shape clear that is called, or whose material is called, as the caller says.

    Args:
        tree: The parsed scene; it is changed.
        wanted: Names of materials or shapes; capitals do not matter.
        notes: Takes what shines, and so stays as it is.

    Raises:
        SceneError: Nothing is called so; the message lists the nearest names.
    """
    if not wanted:
        return
    shapes = {index: names for index in _shapes(tree) if (names := _names(tree, index))}
    known = {name.casefold(): name for names in shapes.values() for name in sorted(names)}
    for name in wanted:
        if not isinstance(name, str) or name.casefold() not in known:
            raise SceneError(_unknown(name, known))
    asked = {name.casefold() for name in wanted}
    null = tree.append({"clear": {"type": "null"}}, "made clear")["clear"]
    for index, names in shapes.items():
        if asked & {name.casefold() for name in names}:
            for part in _parts(tree, index):
                _clear(tree, part, null, notes)


def _shapes(tree: PluginTree) -> Iterator[int]:
    """Numbers of all shapes but instances, which show what others show too."""
    for index in range(len(tree.state.nodes)):
        if tree.kind(index) == mi.ObjectType.Shape and tree.plugin(index) != "instance":
            yield index


def _names(tree: PluginTree, shape: int) -> set[str]:
    """What a shape is called, and its material."""
    properties = tree.properties(shape)
    names = {properties.id()}
    if not properties.id() and "filename" in properties:
        names.add(Path(properties["filename"]).stem)
    names |= {_material(tree, child) for _, child in tree.children(shape) if _is(tree, child, _BSDF)}
    return names - {""}


def _material(tree: PluginTree, bsdf: int | Any) -> str:
    """What a material is called; one around another without a name, as that other."""
    if not isinstance(bsdf, int):
        return str(bsdf.id())
    name = tree.called.get(tree.properties(bsdf).id(), tree.properties(bsdf).id())
    nested = (_material(tree, child) for _, child in tree.children(bsdf) if _is(tree, child, _BSDF))
    return name or next(nested, "")


def _parts(tree: PluginTree, shape: int) -> Iterator[int]:
    """The shape itself, or those that it collects."""
    if tree.plugin(shape) not in COLLECTIONS:
        yield shape
        return
    for _, child in tree.children(shape):
        if isinstance(child, int) and tree.kind(child) == mi.ObjectType.Shape:
            yield from _parts(tree, child)


def _clear(tree: PluginTree, shape: int, null: int, notes: Notes) -> None:
    children = tree.children(shape)
    if any(_is(tree, child, mi.ObjectType.Emitter) for _, child in children):
        notes.add(f"{tree.label(shape)}: a lamp, which cannot be clear")
        return
    for key, child in children:
        if _is(tree, child, _BSDF):
            tree.drop(shape, key)
    tree.refer(shape, KEY, null)


def _is(tree: PluginTree, child: int | Any, kind: Any) -> bool:
    if isinstance(child, int):
        return bool(tree.kind(child) == kind)
    return isinstance(child, mi.BSDF if kind == _BSDF else mi.Emitter)


def _unknown(name: Any, known: dict[str, str]) -> str:
    plain = str(name).casefold()
    close = [key for key in known if plain in key]  # half a name is what people remember
    close += [key for key in get_close_matches(plain, known, n=NEAREST, cutoff=0.3) if key not in close]
    nearest = ", ".join(known[key] for key in (close or list(known))[:NEAREST])
    none = "no shape of a file is here, and those of built-in scenes and Mitsuba objects stay as they are"
    there_are = f"the nearest are {nearest}" if nearest else none
    return f"nothing to make clear: no material or shape {name!r}; {there_are}"


_BSDF = mi.ObjectType.BSDF
