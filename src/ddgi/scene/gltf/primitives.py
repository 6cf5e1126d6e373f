"""Primitives to triangles: lists, strips and fans; with what their vertices carry.

glTF 2.0 specification, sections 3.7.2 (geometry), 3.7.2.1 (topology).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf import draco
from ddgi.scene.gltf.accessors import Accessors
from ddgi.scene.gltf.buffers import Views
from ddgi.scene.gltf.schema import Primitive

TRIANGLES, STRIP, FAN = 4, 5, 6
Displacements = dict[str, np.ndarray]
"""(V, 3) by attribute: "POSITION" or "NORMAL"."""


@dataclass(frozen=True)
class Piece:
    """A primitive's V vertices and F triangles, in the space of its mesh."""

    positions: np.ndarray  # (V, 3) float32
    faces: np.ndarray  # (F, 3) counter-clockwise from the front
    normals: np.ndarray | None  # (V, 3)
    texcoords: dict[int, np.ndarray]  # (V, 2) by number of the set; v runs down the picture
    colors: np.ndarray | None  # (V, 4) linear RGB and alpha in [0, 1]
    joints: np.ndarray | None  # (V, 4 n) numbers in the skin's list
    weights: np.ndarray | None  # (V, 4 n)
    targets: tuple[Displacements, ...]  # morph targets
    material: int | None


class PrimitiveReader:
    """Reads the geometry of a file, each primitive once."""

    def __init__(self, accessors: Accessors, views: Views) -> None:
        self._accessors = accessors
        self._views = views
        self._pieces: dict[tuple[int, int], Piece] = {}

    def piece(self, mesh: int, number: int, primitive: Primitive) -> Piece:
        """The primitive's triangles.

        Raises:
            SceneError: It has no positions, an attribute of another length, or a vertex out of range.
        """
        if (mesh, number) not in self._pieces:
            label = f"meshes[{mesh}].primitives[{number}]"
            self._pieces[mesh, number] = _Attributes(self._accessors, self._views, primitive, label).piece()
        return self._pieces[mesh, number]


class _Attributes:
    """What one primitive names, out of accessors or out of a Draco mesh."""

    def __init__(self, accessors: Accessors, views: Views, primitive: Primitive, label: str) -> None:
        self._accessors = accessors
        self._primitive = primitive
        self._label = label
        self._names = primitive.attributes
        if "POSITION" not in self._names:
            raise SceneError(f"{label} has no POSITION")
        self._count = accessors.spec(self._names["POSITION"]).count
        self._packed: draco.Packed | None = None
        if primitive.extensions.draco is not None:
            self._packed = draco.decode(primitive.extensions.draco, views, label)
            self._count = self._packed.vertices

    def piece(self) -> Piece:
        colors = self._colors()
        return Piece(
            positions=self._floats("POSITION", "VEC3"),
            faces=self._faces(),
            normals=self._floats("NORMAL", "VEC3") if "NORMAL" in self._names else None,
            texcoords={
                int(name[9:]): self._floats(name, "VEC2")
                for name in self._names
                if name.startswith("TEXCOORD_") and name[9:].isdecimal()
            },
            colors=colors,
            joints=self._joined("JOINTS_", lambda name: self._integers(name)),
            weights=self._joined("WEIGHTS_", lambda name: self._floats(name, "VEC4")),
            targets=tuple(self._target(target) for target in self._primitive.targets),
            material=self._primitive.material,
        )

    def _raw(self, name: str) -> np.ndarray:
        """Numbers of an attribute as stored."""
        if self._packed is None or name not in self._packed.attributes:
            return self._accessors.raw(self._names[name])
        values = self._packed.attributes[name]
        if values.shape[1] != (wanted := self._accessors.width(self._names[name])):
            raise SceneError(
                f"{self._label}: its Draco data has {values.shape[1]} numbers for {name}, not {wanted}"
            )
        return values

    def _floats(self, name: str, *kinds: str) -> np.ndarray:
        index = self._names[name]
        self._accessors.check(index, kinds, None if self._packed else self._count)
        values = self._accessors.converted(index, self._raw(name))
        if len(values) != self._count:
            raise SceneError(f"{self._label}: {name} has {len(values)} elements, not {self._count}")
        return values

    def _integers(self, name: str) -> np.ndarray:
        index = self._names[name]
        if self._packed is None or name not in self._packed.attributes:
            return self._accessors.integers(index, ("VEC4",), self._count)
        self._accessors.check(index, ("VEC4",))
        values = self._raw(name)
        if values.dtype.kind not in "iu" or values.min() < 0:
            raise SceneError(f"{self._label}: its Draco data has no whole numbers for {name}")
        return values

    def _colors(self) -> np.ndarray | None:
        if "COLOR_0" not in self._names:
            return None
        spec = self._accessors.spec(self._names["COLOR_0"])
        if spec.component_type != 5126 and not spec.normalized:
            raise SceneError(f"{self._label}: COLOR_0 holds integers that are not normalised")
        values = np.clip(self._floats("COLOR_0", "VEC3", "VEC4"), 0, 1)
        return values if values.shape[1] == 4 else np.column_stack([values, np.ones(len(values), np.float32)])

    def _joined(self, prefix: str, read: Callable[[str], np.ndarray]) -> np.ndarray | None:
        """Sets 0, 1, ... of an attribute side by side."""
        sets: list[np.ndarray] = []
        while f"{prefix}{len(sets)}" in self._names:
            sets.append(read(f"{prefix}{len(sets)}"))
        return np.concatenate(sets, 1) if sets else None

    def _target(self, target: dict[str, int]) -> Displacements:
        return {
            name: self._accessors.floats(target[name], ("VEC3",), self._count)
            for name in ("POSITION", "NORMAL")
            if name in target
        }

    def _faces(self) -> np.ndarray:
        if self._packed is not None:
            corners = self._packed.faces.reshape(-1)
            return self._checked(corners, self._label).reshape(-1, 3)
        index = self._primitive.indices
        if index is None:
            return triangles(np.arange(self._count, dtype=np.uint32), self._primitive.mode)
        corners = self._accessors.integers(index, ("SCALAR",))[:, 0].astype(np.uint32)
        return triangles(self._checked(corners, self._accessors.label(index)), self._primitive.mode)

    def _checked(self, corners: np.ndarray, label: str) -> np.ndarray:
        if corners.size and (largest := int(corners.max())) >= self._count:
            raise SceneError(f"{label} names vertex {largest}, but there are {self._count}")
        return corners.astype(np.uint32)


def triangles(corners: np.ndarray, mode: int) -> np.ndarray:
    """(F, 3) triangles of a list, a strip or a fan; corners that make no whole triangle are left out."""
    if mode == TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    first, second, third = corners[:-2], corners[1:-1], corners[2:]
    if mode == FAN:
        return np.stack([second, third, np.full_like(second, corners[0] if corners.size else 0)], 1)
    # Every other triangle of a strip would face the other way.
    odd = np.arange(len(first)) % 2 == 1
    return np.stack([first, np.where(odd, third, second), np.where(odd, second, third)], 1)
