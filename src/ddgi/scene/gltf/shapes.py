"""The meshes at nodes to Mitsuba's shapes: bent, placed, coloured and named."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf.accessors import Accessors
from ddgi.scene.gltf.deform import morphed, skin_matrices
from ddgi.scene.gltf.instancing import placements
from ddgi.scene.gltf.materials import Look, Materials, VertexColors
from ddgi.scene.gltf.names import Names
from ddgi.scene.gltf.nodes import Placed
from ddgi.scene.gltf.placement import Soup, joined, place
from ddgi.scene.gltf.primitives import TRIANGLES, Piece, PrimitiveReader
from ddgi.scene.gltf.schema import Document, Material
from ddgi.scene.gltf.textures import Described
from ddgi.scene.mesh_arrays import described
from ddgi.scene.notes import Notes
from ddgi.scene.rig import Bendable, Skin

MOST_TRIANGLES = 2**28
"""Of a whole scene, each place where a mesh stands counted."""
MOST_INSTANCES = 32
"""Kept as such: each costs 20 ms whenever a kernel with rays is recorded (Mitsuba 3.9, LLVM; 400: 8 s)."""

WORST_CONDITION = 1e4
"""Of a placement that can be undone: a hundredth of a millimetre remains exact to a part in a thousand."""


@dataclass
class ShapeBuilder:
    """Collects the shapes of a scene."""

    document: Document
    accessors: Accessors
    primitives: PrimitiveReader
    materials: Materials
    skins: tuple[Skin, ...]
    worlds: dict[int, np.ndarray]  # of every placed node
    animated: frozenset[int]  # nodes that some animation moves
    notes: Notes
    names: Names
    shapes: dict[str, dict[str, Any]] = field(default_factory=dict)  # as inside a scene dictionary
    bendable: dict[str, Bendable] = field(default_factory=dict)
    triangles: int = 0
    not_triangles: Counter[str] = field(default_factory=Counter)  # by what they are
    without_area: int = 0  # triangles

    def add(self, placed: Placed) -> list[str]:
        """The shapes of one node; their names.

        Raises:
            SceneError: Its mesh cannot be used.
        """
        node = placed.node
        if node.mesh is None:
            return []
        if node.extensions.instancing is None:
            return [
                name for piece, base in self._pieces(placed) for name in self._single(placed, piece, base)
            ]
        local = placements(node.extensions.instancing, self.accessors, f"nodes[{placed.index}]")
        worlds = placed.world @ local
        pieces = [piece for piece, _ in self._pieces(placed)]
        if placed.index not in self.animated and self._can_instance(pieces, worlds):
            return self._instanced(placed, pieces, worlds)
        self.notes.add("instances that are many, that glow, move or are mirrored, are made into one mesh")
        return [name for piece in pieces for name in self._merged(placed, piece, worlds)]

    def _pieces(self, placed: Placed) -> Iterator[tuple[Piece, Piece]]:
        """Each primitive of a node's mesh, morphed as it rests; and as it is stored."""
        number = placed.node.mesh
        assert number is not None
        mesh = self.document.meshes[number]
        weights = mesh.weights if placed.node.weights is None else placed.node.weights
        for index, primitive in enumerate(mesh.primitives):
            if primitive.mode < TRIANGLES:
                self.not_triangles["line primitive" if primitive.mode else "point primitive"] += 1
                continue
            piece = self.primitives.piece(number, index, primitive)
            yield morphed(piece, weights, f"nodes[{placed.index}]"), piece

    def _single(self, placed: Placed, piece: Piece, base: Piece) -> list[str]:
        label = f"nodes[{placed.index}]"
        matrices, moves = placed.world, placed.index in self.animated
        if placed.node.skin is not None:  # a skinned mesh stands where its joints are
            skin = self.skins[placed.node.skin]
            lost = next((joint for joint in skin.joints if joint not in self.worlds), None)
            if lost is not None:
                raise SceneError(f"{label}: the joint nodes[{lost}] of its skin is not in the scene")
            worlds = np.stack([self.worlds[joint] for joint in skin.joints])
            matrices = skin_matrices(piece, worlds @ skin.inverse_bind, label)
            moves = not self.animated.isdisjoint(skin.joints)
        glows = self.materials.look(piece.material, VertexColors()).radiance is not None
        soup = self._placed(
            piece, matrices, label, keep_flat=moves and not glows
        )  # Mitsuba's lamps have an area
        if not len(soup.faces):
            return []
        name = self.names.unique(self._name(placed))
        self.shapes[f"_shape-{len(self.shapes)}"] = {"id": name, **self._shape(piece, soup)}
        # What rests as a point or a sheet cannot be moved from there.
        squashed = moves and matrices.ndim == 2 and _squashed(matrices)
        if piece.targets or piece.joints is not None or squashed:
            self.bendable[name] = _bendable(base, soup.kept)
        return [name]

    def _placed(self, piece: Piece, matrices: np.ndarray, label: str, *, keep_flat: bool = False) -> Soup:
        soup = place(piece, matrices, label, keep_flat=keep_flat)
        self.without_area += soup.without_area
        self.triangles += len(soup.faces)
        if self.triangles > MOST_TRIANGLES:
            raise SceneError(f"more than {MOST_TRIANGLES:,} triangles")
        return soup

    def _name(self, placed: Placed) -> str:
        number = placed.node.mesh
        assert number is not None
        return placed.node.name or self.document.meshes[number].name or f"mesh-{number}"

    def _shape(self, piece: Piece, soup: Soup) -> dict[str, Any]:
        colors = None if piece.colors is None else piece.colors[soup.kept]
        vertices = VertexColors()
        if colors is not None:
            vertices = VertexColors(bool((colors[:, :3] != 1).any()), bool((colors[:, 3] != 1).any()))
        look = self.materials.look(piece.material, vertices)
        texcoords = _texcoords(piece, soup, look)
        if look.bumpy and texcoords is not None:
            turned = _mirrored_share(soup, texcoords)
            if 0 < turned < 1:
                self.notes.add(
                    "a normal map on a mesh of which a part is mirrored: bumps there are lit from the wrong side"
                )
            if turned > 0.5:
                look = self.materials.look(piece.material, vertices, mirrored=True)
        if look.uv_set is not None and look.uv_set not in piece.texcoords:
            self.notes.add(
                "pictures on a mesh without texture coordinates for them: one colour of each is shown"
            )
        rgb, alpha = self._tinted(colors, vertices, piece.material)
        shape = described(
            soup.positions, soup.faces, normals=soup.normals, texcoords=texcoords,
            colors=rgb, alphas=alpha,
        )  # fmt: skip
        shape["bsdf"] = look.bsdf
        if look.radiance is not None:
            shape["emitter"] = {"type": "area", "radiance": self._radiance(look.radiance, rgb)}
        return shape

    def _radiance(self, radiance: Described, colors: np.ndarray | None) -> Described:
        """Mitsuba's lamps know no colours of vertices: their mean."""
        if radiance["type"] != "mesh_attribute" or colors is None:
            return radiance
        self.notes.add("colours of vertices that emit: their mean is used")
        return {"type": "rgb", "value": [float(x) for x in colors.mean(0)]}

    def _tinted(
        self, colors: np.ndarray | None, vertices: VertexColors, index: int | None
    ) -> tuple[np.ndarray | None, np.ndarray | None]:
        """Colours and opacities of vertices with the material's factors in them."""
        if colors is None:
            return None, None
        material = Material() if index is None else self.document.materials[index]
        factor = np.array(material.pbr.base_color_factor)
        info = material.pbr.base_color_texture
        if info is not None and self.document.textures[info.index].source is not None:
            factor = np.ones(4)  # it is in the picture
        rgb = colors[:, :3] * factor[:3] if vertices.varied else None
        if not vertices.alpha or material.alpha_mode == "OPAQUE":
            return rgb, None
        alpha = colors[:, 3:] * factor[3]
        return rgb, alpha if material.alpha_mode == "BLEND" else alpha >= material.alpha_cutoff

    # Instances ------------------------------------------------------------------------------------------

    def _can_instance(self, pieces: list[Piece], worlds: np.ndarray) -> bool:
        """Mitsuba's instances neither emit, nor turn a mirrored front to the front again."""
        if len(worlds) > MOST_INSTANCES or (np.linalg.det(worlds[:, :3, :3]) <= 0).any():
            return False
        return all(self.materials.look(p.material, VertexColors()).radiance is None for p in pieces)

    def _merged(self, placed: Placed, piece: Piece, worlds: np.ndarray) -> list[str]:
        """All instances of a primitive as one shape."""
        soups = [self._placed(piece, world, f"nodes[{placed.index}]") for world in worlds]
        soup = joined(soups)
        if not len(soup.faces):
            return []
        name = self.names.unique(self._name(placed))
        self.shapes[f"_shape-{len(self.shapes)}"] = {"id": name, **self._shape(piece, soup)}
        return [name]

    def _instanced(self, placed: Placed, pieces: list[Piece], worlds: np.ndarray) -> list[str]:
        label, base_name = f"nodes[{placed.index}]", self._name(placed)
        group: dict[str, Any] = {"type": "shapegroup"}
        for piece in pieces:
            soup = self._placed(piece, np.eye(4), label)
            if len(soup.faces):
                name = self.names.unique(base_name)
                group[f"_shape-{len(group)}"] = {"id": name, **self._shape(piece, soup)}
        if len(group) == 1:
            return []
        key = f"_group-{len(self.shapes)}"
        self.shapes[key] = group
        names = []
        for world in worlds:
            names.append(self.names.unique(f"{base_name}-instance"))
            self.shapes[f"_shape-{len(self.shapes)}"] = {
                "type": "instance",
                "id": names[-1],
                "to_world": mi.ScalarTransform4f(world.tolist()),
                "group": {"type": "ref", "id": key},
            }
        return names


def _texcoords(piece: Piece, soup: Soup, look: Look) -> np.ndarray | None:
    """(V, 2) of the set that the material uses; zero where there is none, as Mitsuba would make some up."""
    values = piece.texcoords.get(look.uv_set or 0)
    return np.zeros((len(soup.positions), 2), np.float32) if values is None else values[soup.kept]


def _mirrored_share(soup: Soup, texcoords: np.ndarray) -> float:
    """Share of the triangles, of those with an area of texture, on which pictures are seen as in a mirror.

    Row 0 of a picture lies at v = 0: seen from the front, u and v of one that is not mirrored turn clockwise.
    """
    a, b, c = texcoords[soup.faces].astype(np.float64).swapaxes(0, 1)
    area = np.linalg.det(np.stack([b - a, c - a], 1))
    return float((area > 0).sum() / max((area != 0).sum(), 1))


def _squashed(matrix: np.ndarray) -> bool:
    """Whether a placement (4, 4) cannot be undone, as it makes a sheet, a line or a point of things."""
    sizes = np.linalg.svd(matrix[:3, :3], compute_uv=False)
    return bool(sizes[-1] * WORST_CONDITION <= sizes[0])


def _bendable(piece: Piece, kept: np.ndarray) -> Bendable:
    def rows(values: np.ndarray | None) -> np.ndarray | None:
        return None if values is None else values[kept]

    none = np.zeros((len(kept), 3), np.float32)
    return Bendable(
        positions=piece.positions[kept],
        normals=rows(piece.normals),
        target_positions=tuple(t["POSITION"][kept] if "POSITION" in t else none for t in piece.targets),
        target_normals=tuple(t["NORMAL"][kept] if "NORMAL" in t else none for t in piece.targets),
        joints=rows(piece.joints),
        weights=rows(piece.weights),
    )
