"""Shape plugins to what is traced: built, checked, named, and without what light passes straight."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi

from ddgi.errors import SceneError
from ddgi.scene.emitters import EmitterReader
from ddgi.scene.materials import MaterialReader, Row
from ddgi.scene.notes import Notes
from ddgi.scene.plugin_parts import parts
from ddgi.scene.plugin_tree import PluginTree
from ddgi.scene.ply.faces import check_triangles
from ddgi.scene.unique_names import UniqueNames
from ddgi.scene.validate import check_mesh, without_area

UNCHECKED_FILES = ("ply", "serialized")
"""Mesh formats whose readers trust the vertex numbers in the file, and crash on wrong ones."""
MESH_FILES = ("obj", *UNCHECKED_FILES)
"""Mesh formats that hold whatever their makers wrote."""


Traced = tuple[str, Any]
"""Name and shape."""


@dataclass
class Geometry:
    """What a scene traces."""

    traced: list[Traced] = field(default_factory=list)  # groups before their instances
    rows: dict[int, Row] = field(default_factory=dict)  # by registry number
    owners: dict[int, int | mi.Shape] = field(default_factory=dict)  # of a row: its shape's node, or object
    left_out: list[tuple[int, str]] = field(default_factory=list)  # parent and key of what rays do not meet
    names: dict[str, int] = field(default_factory=dict)  # shape name -> registry number
    area_lights: list[mi.Emitter] = field(default_factory=list)
    triangles: int = 0
    without_area: int = 0  # triangles of files that are lines or points; not counted above
    clear: list[str] = field(default_factory=list)  # labels of those left out: light passes them straight


class ShapeReader:
    """Builds every shape of a scene."""

    def __init__(
        self, tree: PluginTree, materials: MaterialReader, emitters: EmitterReader, notes: Notes
    ) -> None:
        self._tree = tree
        self._materials = materials
        self._emitters = emitters
        self._notes = notes
        self._groups: dict[int, bool] = {}
        self._names = UniqueNames()
        self.geometry = Geometry()

    def add(self, child: int | mi.Shape, name: str, parent: int = 0) -> None:
        """Take one shape of the scene in.

        Args:
            child: Node number, or a shape that came as an object.
            name: Its key in the node that holds it, used where it has no id.
            parent: That node; by default the scene.

        Raises:
            SceneError: It cannot be built, or holds what cannot be traced; says which element.
        """
        if isinstance(child, int):
            plugin = self._tree.plugin(child)
            if plugin == "shapegroup":
                return  # built with the first instance that shows it
            if plugin == "instance":
                self._add_instance(child, name, parent)
                return
            if plugin == "merge":
                self._add_members(child)
                return
        shape = self._traced(child)
        if shape is None:
            self.geometry.left_out.append((parent, name))
        else:
            flat = without_area(shape) if self._of_a_file(child) else 0
            self.geometry.without_area += flat
            self.geometry.triangles += shape.effective_primitive_count() - flat
            self._list(shape, name)

    def _of_a_file(self, child: int | mi.Shape) -> bool:
        return isinstance(child, int) and self._tree.plugin(child) in MESH_FILES

    def _add_members(self, index: int) -> None:
        """The shapes of a `merge`, each by itself."""
        for key, inner in self._tree.children(index):
            if not isinstance(inner, int) or self._tree.kind(inner) == mi.ObjectType.Shape:
                self.add(inner, key, index)

    def _list(self, shape: mi.Shape, name: str) -> None:
        self.geometry.traced.append((self._named(shape, name), shape))

    def _named(self, shape: mi.Shape, key: str) -> str:
        """The shape's id, else its file's name, made unique; in the table of names if it has a row."""
        properties = self._tree.properties_of(shape)
        if shape.id():
            base = shape.id()
        elif properties is not None and "filename" in properties:
            base = Path(properties["filename"]).stem
        else:
            base = shape.class_name().lower() if key.startswith("_") else key
        name = self._names.unique(base)
        if shape_number(shape) in self.geometry.rows:
            self.geometry.names[name] = shape_number(shape)
        return name

    def _traced(self, child: int | mi.Shape, removable: bool = True) -> mi.Shape | None:
        """The shape with its row entered; None if rays do not meet it.

        A clear shape that cannot be removed has a row that lets all rays pass.
        """
        shape = self._built(child) if isinstance(child, int) else child
        label = self._tree.label_of(shape)
        check_mesh(shape, label)
        if shape.class_name() in ("ShapeGroupPlugin", "Instance"):  # came as an object: rows only
            for inner in parts(shape).values():
                if isinstance(inner, mi.Shape):
                    self._traced(inner, removable=False)
            return shape
        if shape.is_mesh() and shape.face_count() == 0:
            self._notes.add(f"{label}: has no triangles, left out")
            return None
        row = self._materials.row(shape)
        if shape.is_emitter():
            opacity = 1.0 if row.clear else row.opacity  # a lamp without a surface is a black one
            row = replace(row, emission=self._emitters.emission(shape), opacity=opacity)
            self.geometry.area_lights.append(shape.emitter())
        elif row.clear:
            self.geometry.clear.append(label)
            if removable:
                return None
        self.geometry.rows[shape_number(shape)] = row
        self.geometry.owners[shape_number(shape)] = child
        return shape

    def _built(self, index: int) -> mi.Shape:
        if self._tree.plugin(index) == "ply":
            self._check_ply(index)
        if self._tree.plugin(index) in UNCHECKED_FILES:
            # Without normals to compute and lights to measure, nothing reads the faces yet.
            bare = self._tree.build(index, skip=lambda _: True, changes={"face_normals": True})
            check_mesh(bare, self._tree.label(index))
            if not bare.face_count():  # of nothing Mitsuba cannot compute normals
                return bare
        try:
            return self._tree.build(index, skip=self._not_ours)
        except SceneError:
            if self._tree.plugin(index) != "obj":
                raise
            # A file without faces fails only for want of normals; let it count as an empty mesh.
            try:
                bare = self._tree.build(index, skip=lambda _: True, changes={"face_normals": True})
            except SceneError:
                bare = None
            if bare is None or bare.face_count():
                raise
            return bare

    def _check_ply(self, index: int) -> None:
        """Mitsuba's reader stumbles over polygons, and shows vertex 0 for one that does not exist."""
        path = Path(str(mi.file_resolver().resolve(self._tree.properties(index).get("filename", ""))))
        if not path.is_file():
            return  # which building says
        try:
            check_triangles(path)
        except SceneError as error:
            raise SceneError(f"{self._tree.label(index)}: {error}") from error

    def _not_ours(self, index: int) -> bool:
        """Whether a child of a shape is left out."""
        kind = self._tree.kind(index)
        if kind == mi.ObjectType.Emitter and self._tree.plugin(index) != "area":
            self._notes.add(f"{self._tree.label(index)}: not a light this package has, left out")
            return True
        if kind in (mi.ObjectType.Medium, mi.ObjectType.Sensor):
            self._notes.add(f"{self._tree.label(index)} inside a shape is left out")
            return True
        return False

    def _add_instance(self, index: int, name: str, parent: int) -> None:
        groups = [inner for _, inner in self._tree.children(index) if isinstance(inner, int)]
        if not all(self._group(group) for group in groups):
            self.geometry.left_out.append((parent, name))
            return  # all of it was clear
        instance = self._tree.build(index)
        self.geometry.triangles += instance.effective_primitive_count()
        self._list(instance, name)

    def _group(self, index: int) -> bool:
        """Build a shape group once, with a row for every shape in it; False if nothing is left."""
        if index not in self._groups:
            left_out = set()
            for key, inner in self._tree.children(index):
                shape = self._traced(inner)
                if shape is None:
                    left_out.add(inner)
                    self.geometry.left_out.append((index, key))
                else:
                    self._named(shape, key)
            self._groups[index] = len(left_out) < len(self._tree.children(index))
            if self._groups[index]:
                group = self._tree.build(index, skip=lambda inner: inner in left_out)
                self.geometry.traced.append((group.id() or f"group-{index}", group))
        return self._groups[index]


def shape_number(shape: mi.Shape) -> int:
    """Dr.Jit's registry number: the row of the material table."""
    return int(dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))[0])
