"""What a path-traced picture of a scene depends on, camera aside, as one short text.

A reference picture that was rendered for hours can be stored under it, and found again for as long as
nothing in the scene has changed.
"""

from __future__ import annotations

import re
from hashlib import sha256
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.plugin_parts import parts
from ddgi.scene.plugin_tree import PluginTree
from ddgi.scene.scene import Scene

WORDS = re.compile(r"^\s*(\w+ = (?:[A-Za-z_]\w*|-?\d+)),?$", re.MULTILINE)
"""Settings in an object's text that are words or whole numbers; measured numbers may differ in the last digit."""


def fingerprint(scene: Scene) -> str:
    """Fingerprint of a scene's `source`: geometry, materials and lights; not cameras, samplers, integrators.

    Files count by what they hold, wherever they are. Names do not count. Objects of Mitsuba count by their
    class, their parameters, and the settings that their text shows; what they show in neither (a
    texture's wrap mode, a shape's flipped normals) is not seen. Meant for Mitsuba of one version.

    Returns:
        64 hexadecimal digits, the same in every process.

    Raises:
        SceneError: The scene has no `source`.
    """
    if scene.source is None:
        raise SceneError(f"{scene.name}: not loaded from a file or dictionary, so it has no fingerprint")
    return _Walk(PluginTree(scene.source, None)).node(0).hex()


class _Digest:
    """SHA-256 of a list of parts, each with its length in front: no two lists give the same bytes."""

    def __init__(self) -> None:
        self._hash = sha256()

    def add(self, *contents: str | bytes) -> None:
        for content in contents:
            data = content.encode() if isinstance(content, str) else content
            self._hash.update(len(data).to_bytes(8, "little"))
            self._hash.update(data)

    def add_array(self, values: Any) -> None:
        array = np.ascontiguousarray(values)
        self.add(array.dtype.str, repr(array.shape), array.tobytes())

    def add_value(self, value: Any) -> None:
        """A number, text, vector, colour, transform, spectrum or tensor."""
        kind = type(value).__name__
        if isinstance(value, (str, bool, int, float, bytes)):
            self.add(repr(value))
        elif "Transform" in kind:  # every Dr.Jit array answers to `matrix`
            self.add_array(value.matrix)
        elif hasattr(value, "wavelengths"):
            self.add_array(value.wavelengths)
            self.add_array(value.values)
        else:
            self.add_array(value)

    def add_file(self, name: str) -> None:
        path = Path(str(mi.file_resolver().resolve(name)))
        self.add(path.read_bytes() if path.is_file() else str(path))

    @property
    def bytes(self) -> bytes:
        return self._hash.digest()


class _Walk:
    """Digests of a tree's nodes from the leaves up, each once; a node's place in the list does not count."""

    def __init__(self, tree: PluginTree) -> None:
        self._tree = tree
        self._nodes: dict[int, bytes] = {}
        kind = mi.ObjectType
        self._ignored_kinds = (
            kind.Sensor,
            kind.Film,
            kind.Sampler,
            kind.Integrator,
            kind.ReconstructionFilter,
        )
        self._ignored_classes = (mi.Sensor, mi.Film, mi.Sampler, mi.Integrator, mi.ReconstructionFilter)

    def node(self, index: int) -> bytes:
        if index not in self._nodes:
            self._nodes[index] = self._digest(index)
        return self._nodes[index]

    def _digest(self, index: int) -> bytes:
        properties, digest = self._tree.properties(index), _Digest()
        digest.add(properties.plugin_name())
        children = dict(self._tree.children(index))
        for key in properties.keys():  # noqa: SIM118, not a dict
            if key in children:
                if not self._ignored(children[key], outermost=index == 0):
                    digest.add(_meaning(key, index), self._child(children[key]))
                continue
            digest.add(key)
            if "filename" in key and properties.type(key) == mi.Properties.Type.String:
                digest.add_file(properties[key])
            else:
                digest.add_value(properties[key])
        return digest.bytes

    def _child(self, child: int | Any) -> bytes:
        return self.node(child) if isinstance(child, int) else _object(child)

    def _ignored(self, child: int | Any, outermost: bool) -> bool:
        """Whether no picture shows it. Materials directly in the scene count where something refers to them."""
        if not isinstance(child, int):
            return isinstance(child, self._ignored_classes)
        kind = self._tree.kind(child)
        unused = outermost and kind in (mi.ObjectType.BSDF, mi.ObjectType.Texture)
        return unused or kind in self._ignored_kinds


def _meaning(key: str, parent: int) -> str:
    """What a child's key says: nothing in the scene itself, nor where the parser made it up."""
    return "" if parent == 0 or key.startswith("_") else key


def _object(found: Any) -> bytes:
    """Digest of an object that was built already."""
    digest = _Digest()
    digest.add(found.class_name())
    if isinstance(found, (mi.Bitmap, mi.VolumeGrid)):
        digest.add_array(np.array(found))
        if isinstance(found, mi.Bitmap):
            digest.add(str(found.pixel_format()), str(found.srgb_gamma()))
        return digest.bytes
    digest.add(*WORDS.findall(str(found)))
    parameters = mi.traverse(found)
    for key in sorted(parameters.keys()):
        digest.add(key)
        digest.add_value(parameters[key])
    for name, part in parts(found).items():
        digest.add(name, part.class_name())
    return digest.bytes
