"""Mitsuba's parsed scene as a tree of plugins that can be inspected, changed and built one by one.

Building each plugin by itself, children first, tells exactly which element of a file is wrong, and
gives the Python object of every shape, also of those inside a shape group.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.errors import SceneError
from ddgi.scene import mesh_arrays, product_texture
from ddgi.scene.jpeg import heard, is_jpeg
from ddgi.scene.mesh_arrays import register_mesh_arrays
from ddgi.scene.notes import Notes
from ddgi.scene.product_texture import register_product
from ddgi.scene.validate import check_finite


@contextmanager
def searching(folder: Path | None) -> Iterator[None]:
    """Let Mitsuba find files relative to `folder` meanwhile, and its own data, but nothing else.

    A folder that someone else added would lend its files to a scene that lacks one of the same name.
    """
    resolver = mi.file_resolver()
    before = [resolver[i] for i in range(len(resolver))]
    if folder is not None:
        own = Path(mi.__file__).resolve().parent
        resolver.clear()
        resolver.append(str(folder))
        for path in before:
            if Path(str(path)).resolve().is_relative_to(own):
                resolver.append(path)
    try:
        yield
    finally:
        resolver.clear()
        for path in before:
            resolver.append(path)


class PluginTree:
    """A parsed scene. Nodes are numbered as in `mi.parser.ParserState.nodes`; 0 is the scene itself."""

    def __init__(self, state: Any, config: Any) -> None:
        self.state = state
        self._config = config
        self._built: dict[int, Any] = {}
        self._node_of: dict[int, int] = {}
        self._added: dict[int, str] = {}
        self.notes = Notes()  # what building had to leave out
        self.called: dict[str, str] = {}  # what a file calls materials whose ids are ours
        self.version: tuple[int, ...] = (3,)  # of Mitsuba, that the file was written for

    @classmethod
    def parse(cls, source: dict[str, Any] | Path) -> PluginTree:
        """Read a scene, without building anything.

        Args:
            source: A dictionary as for `mi.load_dict`, or an XML file.

        Raises:
            SceneError: It is malformed, refers to ids that do not exist, or is not a scene.
        """
        config = mi.parser.ParserConfig(mi.variant() or "")
        config.merge_equivalent = config.merge_meshes = False  # shapes keep their names
        config.parallel = False
        register_mesh_arrays()
        register_product()
        try:
            if isinstance(source, dict):
                state = mi.parser.parse_dict(config, source)
            else:
                state = mi.parser.parse_file(config, str(source))
            _set_kinds(state)
            mi.parser.transform_all(config, state)
        except Exception as error:  # the parser raises RuntimeError, TypeError and others
            raise SceneError(one_line(error)) from error
        if state.nodes[0].type != mi.ObjectType.Scene:
            plugin = state.nodes[0].props.plugin_name()
            raise SceneError(f"the outermost element must be a scene, not {plugin!r}")
        tree = cls(state, config)
        if isinstance(source, Path):
            tree.version = _version(source)
        return tree

    # Inspecting -------------------------------------------------------------------------------------

    def properties(self, index: int) -> Any:
        """The node's properties (`mi.Properties`)."""
        return self.state.nodes[index].props

    def plugin(self, index: int) -> str:
        """The node's plugin name, such as "diffuse"."""
        return self.properties(index).plugin_name()

    def kind(self, index: int) -> Any:
        """The node's `mi.ObjectType`."""
        return self.state.nodes[index].type

    def children(self, index: int) -> list[tuple[str, int | Any]]:
        """Key and node number of each child, in order; a child that came as an object is that object."""
        properties, found = self.properties(index), []
        for key in properties.keys():  # noqa: SIM118, not a dict
            kind = properties.type(key)
            if kind == mi.Properties.Type.ResolvedReference:
                found.append((key, properties[key].index()))
            elif kind == mi.Properties.Type.Object:
                found.append((key, properties[key]))
        return found

    def label(self, index: int) -> str:
        """Plugin, name and place of a node, for messages."""
        properties = self.properties(index)
        name = f' "{properties.id()}"' if properties.id() else ""
        file = f" of {Path(properties['filename']).name}" if "filename" in properties else ""
        return f"{properties.plugin_name()}{name}{file}{self._place(index)}"

    def _from_file(self, index: int) -> bool:
        return self._place(index).startswith(" at ")

    def _place(self, index: int) -> str:
        if index in self._added:
            return f" ({self._added[index]})"
        place = mi.parser.file_location(self.state, self.state.nodes[index])
        return "" if place.startswith("dictionary node") else f" at {place}"

    # Changing ---------------------------------------------------------------------------------------

    def drop(self, parent: int, key: str) -> None:
        """Remove one child or property."""
        del self.properties(parent)[key]

    def refer(self, parent: int, key: str, child: int) -> None:
        """Make a node the child of another."""
        self.properties(parent)[key] = mi.Properties.ResolvedReference(child)

    def graft(self, description: dict[str, Any], origin: str) -> list[int]:
        """Add plugins to the scene; return the numbers of the outermost ones.

        Args:
            description: Plugins by name, as inside a scene dictionary.
            origin: Where they come from, for messages.

        Raises:
            SceneError: It is malformed.
        """
        top = list(self.append(description, origin).values())
        for index in top:
            self.refer(0, f"_added_{index}", index)
        return top

    def append(self, description: dict[str, Any], origin: str) -> dict[str, int]:
        """Add plugins that nothing refers to yet; return the numbers of the outermost ones by name.

        Args:
            description: Plugins by name, as inside a scene dictionary.
            origin: Where they come from, for messages.

        Raises:
            SceneError: It is malformed.
        """
        try:
            other = mi.parser.parse_dict(self._config, {"type": "scene", **description})
            _set_kinds(other)
            mi.parser.transform_all(self._config, other)
        except Exception as error:
            raise SceneError(f"{origin}: {one_line(error)}") from error
        offset = len(self.state.nodes) - 1
        for node in list(other.nodes)[1:]:
            copy = mi.parser.SceneNode(node)
            copy.file_index = 0
            for key in list(copy.props.keys()):
                if copy.props.type(key) == mi.Properties.Type.ResolvedReference:
                    copy.props[key] = mi.Properties.ResolvedReference(copy.props[key].index() + offset)
            self.state.nodes.append(copy)
            self._added[len(self.state.nodes) - 1] = origin
        return {key: child + offset for key, child in PluginTree(other, self._config).children(0)}

    # Building ---------------------------------------------------------------------------------------

    def build(
        self, index: int, skip: Callable[[int], bool] | None = None, changes: dict[str, Any] | None = None
    ) -> Any:
        """Build a node and everything below it; the same node gives the same object every time.

        Args:
            index: Node number.
            skip: Says of each direct child whether to leave it out.
            changes: Properties to replace; the result is then not remembered.

        Raises:
            SceneError: A file is missing, a number is not finite, or Mitsuba refuses; says which element.
        """
        if changes is None and index in self._built:
            return self._built[index]
        node = mi.parser.SceneNode(self.state.nodes[index])
        node.file_index = 0
        self._check(index)
        for key, child in self.children(index):
            if not isinstance(child, int):
                continue
            if skip is not None and skip(child):
                del node.props[key]
            else:
                node.props[key] = self.build(child)
        for key, value in (changes or {}).items():
            node.props[key] = value
        built = self._instantiated(index, node)
        if changes is None:
            self._built[index] = built
            self._node_of[id(built)] = index
        return built

    def forget(self, *kinds: Any) -> None:
        """Build nodes of these kinds (`mi.ObjectType`) anew when they are next asked for."""
        for index in [index for index in self._built if self.kind(index) in kinds]:
            del self._node_of[id(self._built.pop(index))]

    def _instantiated(self, index: int, node: Any) -> Any:
        """The object of one node whose children are built, without properties that its plugin lacks."""
        while True:
            state = mi.parser.ParserState()
            state.nodes.append(mi.parser.SceneNode(node))
            try:
                with self._listening(index):
                    return mi.parser.instantiate(self._config, state)
            except Exception as error:
                unknown = [key for key in _unknown_properties(error) if key in node.props]
                if not unknown or not self._from_file(index):  # in a dictionary it is a slip, not age
                    raise SceneError(f"{self.label(index)}: {one_line(error)}") from error
            for key in unknown:
                self.notes.add(f"{self.label(index)}: no property {key!r} in Mitsuba 3, left out")
                del node.props[key]
                if key in self.properties(index):  # the reference builds from it
                    self.drop(index, key)

    def _listening(self, index: int) -> AbstractContextManager[None]:
        """What to hold around the building of a node: the damage of a JPEG picture becomes a note."""
        properties, string = self.properties(index), mi.Properties.Type.String
        if "filename" not in properties or properties.type("filename") != string:
            return nullcontext()
        path = Path(str(mi.file_resolver().resolve(properties["filename"])))
        return heard(self.label(index), self.notes) if is_jpeg(path) else nullcontext()

    def node_of(self, built: Any) -> int | None:
        """The node an object was built from; None if it came as an object."""
        return self._node_of.get(id(built))

    def properties_of(self, built: Any) -> Any | None:
        """The properties an object was built from; None if it came as an object."""
        index = self.node_of(built)
        return None if index is None else self.properties(index)

    def label_of(self, built: Any) -> str:
        """Plugin, name and place of an object, for messages."""
        index = self._node_of.get(id(built))
        return self.label(index) if index is not None else f'{built.class_name()} "{built.id()}"'

    def _check(self, index: int) -> None:
        """Numbers must be finite, and files must exist and hold something."""
        properties, types = self.properties(index), mi.Properties.Type
        for key in properties.keys():  # noqa: SIM118, not a dict
            kind = properties.type(key)
            if kind == types.Transform:
                check_finite(np.array(properties[key].matrix), f"{self.label(index)}: {key}")
            elif kind in (types.Float, types.Vector, types.Color):
                check_finite(np.array(properties[key]), f"{self.label(index)}: {key}")
            elif kind == types.String and key == "filename":
                path = Path(str(mi.file_resolver().resolve(properties[key])))
                if not path.is_file():
                    raise SceneError(
                        f"{self.label(index)}: file not found: {properties[key]}: add it, or remove the element"
                    )
                if path.stat().st_size == 0:
                    raise SceneError(f"{self.label(index)}: the file is empty: {properties[key]}")


def _version(path: Path) -> tuple[int, ...]:
    """What the outermost element of a scene file says."""
    found = re.search(r"<scene\s[^>]*version\s*=\s*[\"']([\d.]+)", path.read_text("utf-8", "replace"))
    return tuple(int(part) for part in found[1].split(".") if part) if found else (3,)


def _set_kinds(state: Any) -> None:
    """Mitsuba's parser does not know what plugins written in Python are."""
    kinds = {mesh_arrays.PLUGIN: mi.ObjectType.Shape, product_texture.PLUGIN: mi.ObjectType.Texture}
    for node in state.nodes:
        node.type = kinds.get(node.props.plugin_name(), node.type)


def _unknown_properties(error: Exception) -> list[str]:
    """The properties that Mitsuba says a plugin does not have."""
    _, complaint, names = str(error).partition("unreferenced propert")
    return re.findall(r'^\s*- [\w ]+ "([^"]+)":', names, re.MULTILINE) if complaint else []


def one_line(error: Exception) -> str:
    """What a Mitsuba exception says, without source positions of its own code and without line breaks."""
    text = re.sub(r"\[\w+\.(cpp|h):\d+\]\s*", "", str(error))
    text = re.sub(r"failed to instantiate \w+ plugin of type \".*?\":\s*", "", text)
    text = re.sub(r"Found \d+ unreferenced (property|properties) in .*?:\s*-", "unknown property:", text)
    text = re.sub(r"\[[A-Za-z]+\] ", "", text)  # the class that complained
    text = re.sub(r"^(While loading|At) ((dictionary )?node \".*?\"|unknown location):\s*", "", text)
    text = re.sub(
        r"Plugin (\".*?\") not found!",
        r"Mitsuba 3 has no plugin \1: put one that it has in its place, or remove the element",
        text,
    )
    text = re.sub(
        r"Parsing of XML file \".*?\" failed: (.*)",
        r"not a readable XML file: \1: is it a Mitsuba scene?",
        text,
    )
    text = re.sub(r"\s*\n\s*", " ", text).strip()
    return (
        re.sub(r"(Error while loading [^:]+: while processing <include>: )\1+", r"\1", text)
        or type(error).__name__
    )
