"""A glTF file to the dictionary that Mitsuba's parser takes, and to what in it can move."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf import cameras, lights
from ddgi.scene.gltf.accessors import Accessors
from ddgi.scene.gltf.buffers import Views
from ddgi.scene.gltf.document import REFINEMENTS, UNDERSTOOD, Container, read_container
from ddgi.scene.gltf.extent import extent
from ddgi.scene.gltf.images import Images
from ddgi.scene.gltf.materials import Materials
from ddgi.scene.gltf.motion import read_clips, read_skins
from ddgi.scene.gltf.names import Names
from ddgi.scene.gltf.nodes import NONE, Hierarchy, Placed, placed_nodes, read_hierarchy
from ddgi.scene.gltf.primitives import PrimitiveReader
from ddgi.scene.gltf.schema import Document
from ddgi.scene.gltf.shapes import ShapeBuilder
from ddgi.scene.gltf.textures import Textures
from ddgi.scene.no_surface import no_triangle, none_has_area, only
from ddgi.scene.notes import AT_REST, Notes
from ddgi.scene.play import moving_nodes
from ddgi.scene.recentre import origin_for
from ddgi.scene.rig import Rig, RigNode


@dataclass(frozen=True)
class Described:
    """A glTF file, ready for Mitsuba's parser."""

    description: dict[str, Any]
    origin: np.ndarray  # (3,) the place in the file's coordinates that those in the description count from
    rig: Rig  # in the file's coordinates
    called: dict[str, str]  # names of materials in the file, by their keys in the description


def read_gltf(path: Path, notes: Notes) -> Described:
    """Read a .gltf or .glb file.

    Args:
        path: The file; others that it names must lie in its folder.
        notes: Takes what was changed or left out.

    Raises:
        SceneError: It cannot be used; the message names the file and the element.
    """
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # what comes of it is checked
            return _described(read_container(path), notes)
    except SceneError as error:
        line = "".join(c if c.isprintable() else " " for c in str(error))  # what the file says is in it
        raise SceneError(f"{path}: {line}") from error


def _described(container: Container, notes: Notes) -> Described:
    document = container.document
    _note_extensions(document, notes)
    views = Views(container)
    accessors = Accessors(document, views)
    made = Textures(document, Images(container, views, notes), notes)
    materials = Materials(document, made, notes)
    skins, clips = read_skins(document, accessors), read_clips(document, accessors, notes)
    primitives = PrimitiveReader(accessors, views)
    hierarchy = read_hierarchy(document)
    nodes = placed_nodes(document, hierarchy, np.zeros(3))
    origin = origin_for(*extent(document, nodes, accessors, primitives, skins))
    if origin.any():
        nodes = placed_nodes(document, hierarchy, origin)
    worlds = {placed.index: placed.world for placed in nodes}
    names = Names()
    things = _Things(document, notes, names)
    for placed in nodes:  # before shapes: people call lights and cameras by their names
        if placed.visible:
            things.add(placed)
    animated = moving_nodes([node.children for node in document.nodes], clips)
    builder = ShapeBuilder(document, accessors, primitives, materials, skins, worlds, animated, notes, names)
    shapes = {placed.index: builder.add(placed) for placed in nodes if placed.visible}
    _check_surfaces(builder)
    _note_geometry(builder, notes)
    if clips:
        notes.add(f"{len(clips)} animation(s): {AT_REST}")
    description = {
        "type": "scene", **things.plugins, **made.plugins, **materials.plugins, **builder.shapes,
    }  # fmt: skip
    rig = Rig(_rig_nodes(document, hierarchy, shapes, things), skins, clips, builder.bendable)
    return Described(description, origin, rig, materials.called)


class _Things:
    """Lights and cameras of a scene, as inside a scene dictionary."""

    def __init__(self, document: Document, notes: Notes, names: Names) -> None:
        self._document = document
        self._notes = notes
        self._names = names
        self.plugins: dict[str, dict[str, Any]] = {}
        self.lights: dict[int, str] = {}  # name by node
        self.cameras: dict[int, str] = {}

    def add(self, placed: Placed) -> None:
        node = placed.node
        if node.camera is not None:
            camera = self._document.cameras[node.camera]
            name = self._names.unique(node.name or camera.name or f"camera-{len(self.cameras)}")
            self._put(name, cameras.sensor(camera, placed))
            self.cameras[placed.index] = name
        if node.extensions.light is not None:
            light = self._document.lights[node.extensions.light.light]
            name = self._names.unique(node.name or light.name or f"{light.type}-{len(self.lights)}")
            self._put(name, lights.emitter(light, placed, self._notes))
            self.lights[placed.index] = name

    def _put(self, name: str, plugin: dict[str, Any]) -> None:
        self.plugins[f"_thing-{len(self.plugins)}"] = {"id": name, **plugin}


def _note_extensions(document: Document, notes: Notes) -> None:
    for name in sorted(set(document.extensions_used) - UNDERSTOOD):
        what = "refines the picture: left out" if name in REFINEMENTS else "is not read"
        notes.add(f"{name if name.isprintable() else repr(name)} {what}")


def _check_surfaces(builder: ShapeBuilder) -> None:
    """Refuse a file in which there is something, but no surface. Of one without anything the import tells."""
    if builder.shapes:
        return
    if builder.without_area:
        raise SceneError(none_has_area(builder.without_area))
    if found := only(builder.not_triangles):
        raise SceneError(no_triangle(found))


def _note_geometry(builder: ShapeBuilder, notes: Notes) -> None:
    if others := sum(builder.not_triangles.values()):
        notes.add(f"{others} primitive(s) of points or lines left out")
    if builder.without_area:
        notes.add(f"{builder.without_area} triangle(s) without area left out")


def _rig_nodes(
    document: Document, hierarchy: Hierarchy, shapes: dict[int, list[str]], things: _Things
) -> tuple[RigNode, ...]:
    nodes = []
    for index, node in enumerate(document.nodes):
        parent, parts = hierarchy.parents[index], node.matrix is None
        mesh = None if node.mesh is None else document.meshes[node.mesh]
        weights = node.weights if node.weights is not None else mesh.weights if mesh is not None else []
        nodes.append(
            RigNode(
                name=node.name or f"node-{index}",
                parent=None if parent == NONE else parent,
                children=tuple(node.children),
                local=hierarchy.local[index],
                translation=hierarchy.translation[index] if parts else None,
                rotation=hierarchy.rotation[index] if parts else None,
                scale=hierarchy.scale[index] if parts else None,
                skin=node.skin,
                weights=tuple(weights),
                shapes=tuple(shapes.get(index, ())),
                light=things.lights.get(index),
                camera=things.cameras.get(index),
            )
        )
    return tuple(nodes)
