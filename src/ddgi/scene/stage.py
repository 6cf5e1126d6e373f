"""The part of a scene that can move: what it is at rest, and the Mitsuba scene that shows it in a pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.box import Box, around
from ddgi.errors import SceneError
from ddgi.own_memory import own, own_numbers
from ddgi.scene.matrices import cofactors, cross, moved_surface, normals_around, times, unit
from ddgi.scene.mesh_keys import (
    ALPHA_ATTRIBUTE,
    COLOR_ATTRIBUTE,
    FACES,
    NORMALS,
    POSITIONS,
    TEXCOORDS,
    make_mesh,
    vertex_attribute,
)  # fmt: skip
from ddgi.scene.plugin_parts import parts
from ddgi.scene.pose import Bent, Pose
from ddgi.trace.movers import Movers

COMMON = "movers"
TO_WORLD = "to_world"


@dataclass(frozen=True)
class Member:
    """A shape of the common mesh. V vertices and F triangles."""

    name: str
    row: int  # of the material table
    rest: Bent
    texcoords: np.ndarray | None  # (V, 2)
    faces: np.ndarray  # (F, 3)

    def surface(self, now: Bent) -> tuple[np.ndarray, np.ndarray]:
        """Positions and unit normals in the common mesh, where every vertex has a normal: flat faces have their own."""
        if now.normals is not None and self.rest.normals is not None:
            return now.positions, unit(now.normals)
        corners = now.positions[self.faces]
        normals = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return corners.reshape(-1, 3), np.repeat(unit(normals), 3, 0)

    @property
    def used(self) -> np.ndarray:
        """Which of its vertices those in the common mesh are."""
        return self.faces.ravel() if self.rest.normals is None else np.arange(len(self.rest.positions))

    @property
    def common_faces(self) -> np.ndarray:
        """(F, 3) its triangles, by number of `used`."""
        return np.arange(self.faces.size).reshape(-1, 3) if self.rest.normals is None else self.faces


@dataclass(frozen=True)
class Aside:
    """A shape that lies beside the common mesh: a lamp, or what is no plain mesh."""

    name: str
    shape: mi.Shape
    rest: Bent  # of a mesh; of others the corners of the box around them
    to_world: np.ndarray | None  # (4, 4) at rest, of what is moved as a whole; None: its vertices move
    faces: np.ndarray | None  # (F, 3) of a mesh

    def move(self, parameters: mi.SceneParameters, key: str, pose: Pose) -> None:
        """Put it where a pose has it."""
        if self.to_world is not None:
            matrix = pose.matrices.get(self.name, np.eye(4)) @ self.to_world
            parameters[f"{key}.{TO_WORLD}"] = mi.Transform4f(mi.Matrix4f(matrix.astype(np.float32)))
            return
        now = _posed(self.name, self.rest, pose)
        parameters[f"{key}.{POSITIONS}"] = own(now.positions)
        if now.normals is not None and f"{key}.{NORMALS}" in parameters:
            parameters[f"{key}.{NORMALS}"] = own(unit(now.normals))


class Stage:
    """What can move. The one thing about a scene that changes: its copies share it, and each has its own pose shown."""

    def __init__(self, shapes: Sequence[tuple[str, mi.Shape]], row_of: Mapping[str, int]) -> None:
        """Take over the shapes that can move.

        Args:
            shapes: Name and shape, at rest; one or more.
            row_of: Row of the material table, by name.

        Raises:
            SceneError: One cannot be moved; says which.
        """
        self.at_rest = tuple(
            shape for _, shape in shapes
        )  # kept: their numbers are rows, which nobody else may get
        self._members = [_member(n, shape, row_of[n]) for n, shape in shapes if _joins(shape)]
        self._asides = [_aside(n, shape) for n, shape in shapes if not _joins(shape)]
        self._common = _Common(self._members)
        self._shown: Pose | None = None
        self._scene, self._parameters, mesh = self._built()
        rows = [np.full(len(m.faces), m.row, np.int64) for m in self._members] or [np.zeros(1, np.int64)]
        faces = [np.arange(len(m.faces)) for m in self._members] or [np.zeros(1, np.int64)]
        self._movers = Movers(
            self._scene,
            dr.opaque(mi.UInt32, mesh),
            own_numbers(np.concatenate(rows)),
            own_numbers(np.concatenate(faces)),
        )

    @property
    def _parts(self) -> list[Member | Aside]:
        return [*self._members, *self._asides]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the shapes."""
        return tuple(part.name for part in self._parts)

    def show(self, pose: Pose) -> Movers:
        """What moves, in a pose, ready to trace."""
        if pose is not self._shown:
            if self._members:
                positions, normals = self._common.surface(pose)
                self._parameters[f"{COMMON}.{POSITIONS}"] = own(positions)
                self._parameters[f"{COMMON}.{NORMALS}"] = own(normals)
            for number, aside in enumerate(self._asides):
                aside.move(self._parameters, _key(number), pose)
            self._parameters.update()
            self._shown = pose
        return self._movers

    def boxes(self, pose: Pose) -> dict[str, Box]:
        """The box around each shape in a pose, by name. Low and high corner [m], from `Scene.origin`."""
        found = {}
        if self._members:
            low, high = self._common.corners(pose)
            found = {m.name: _box(a, b) for m, a, b in zip(self._members, low, high, strict=True)}
        for aside in self._asides:
            points = _posed(aside.name, aside.rest, pose).positions
            found[aside.name] = _box(points.min(0), points.max(0))
        return found

    def box(self, pose: Pose) -> Box:
        """The box around all of them."""
        return around(list(self.boxes(pose).values()))

    def bent(self, name: str, positions: np.ndarray, normals: np.ndarray | None) -> Bent:
        """A mesh in another form, its normals those around each vertex if none are given.

        Args:
            name: Of the mesh.
            positions: (V, 3) from `Scene.origin`.
            normals: (V, 3).

        Raises:
            SceneError: It is no mesh, or has another number of vertices.
        """
        part = next(part for part in self._parts if part.name == name)
        if part.faces is None:
            raise SceneError(f"{name} is no mesh: only its place can change")
        for values, what in ((positions, "vertices"), (normals, "normals")):
            if values is not None and np.shape(values) != part.rest.positions.shape:
                raise SceneError(
                    f"{name} has {len(part.rest.positions)} {what}, not an array {np.shape(values)}"
                )
        if normals is None and part.rest.normals is not None:
            normals = normals_around(positions, part.faces)
        return Bent(positions, normals)

    def copied(self, name: str, pose: Pose) -> mi.Mesh:
        """A mesh of its own that stands where a pose has it, of the same material and glow.

        Raises:
            SceneError: The shape is no mesh.
        """
        part = next(part for part in self._parts if part.name == name)
        if part.faces is None:
            raise SceneError(
                f"{name}: came as an object, which cannot be moved for the path tracer: describe it"
            )
        rest = dict(zip(self.names, self.at_rest, strict=True))[name]
        now, parameters, properties = _posed(name, part.rest, pose), mi.traverse(rest), mi.Properties()
        properties["bsdf"], properties["face_normals"] = rest.bsdf(), now.normals is None
        if rest.is_emitter():
            radiance = parts(rest.emitter())["radiance"]
            properties["emitter"] = mi.load_dict({"type": "area", "radiance": radiance})
        texcoords = np.array(parameters[TEXCOORDS]).reshape(-1, 2) if TEXCOORDS in parameters else np.zeros(0)
        extra = {key: vertex_attribute(rest, key) for key in (COLOR_ATTRIBUTE, ALPHA_ATTRIBUTE)}
        return make_mesh(
            name, now.positions, part.faces, properties,
            normals=None if now.normals is None else unit(now.normals),
            texcoords=texcoords if len(texcoords) else None,
            attributes={key: None if found is None else found[1] for key, found in extra.items()},
        )  # fmt: skip

    def _built(self) -> tuple[mi.Scene, mi.SceneParameters, int]:
        """Mitsuba's scene, what can be set in it, and the registry number of the common mesh."""
        description: dict[str, object] = {"type": "scene"}
        mesh = None
        if self._members:
            mesh = description[COMMON] = self._common.mesh()
        description |= {_key(number): aside.shape for number, aside in enumerate(self._asides)}
        scene = mi.load_dict(description, optimize=False, parallel=False)
        parameters = mi.traverse(scene)
        for aside in self._asides:
            aside.shape.set_id(aside.name)  # the dictionary's keys became ids
        number = 0 if mesh is None else int(dr.reinterpret_array(mi.UInt32, mi.ShapePtr(mesh))[0])
        return scene, parameters, number


class _Common:
    """The vertices of all members at once: a hundred objects, one at a time, take ten times as long."""

    def __init__(self, members: Sequence[Member]) -> None:
        self._members = members
        surfaces = [member.surface(member.rest) for member in members]
        self._ends = np.cumsum([0, *(len(p) for p, _ in surfaces)])
        if members:
            self._positions = np.concatenate([p for p, _ in surfaces])
            self._normals = np.concatenate([n for _, n in surfaces])
        self._latest: tuple[Pose, tuple[np.ndarray, np.ndarray]] | None = None
        self._member = np.repeat(np.arange(len(members)), np.diff(self._ends))

    def corners(self, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
        """Low and high corners of the boxes around all members. (M, 3) each."""
        positions, _ = self.surface(pose)
        starts = self._ends[:-1]
        return np.minimum.reduceat(positions, starts), np.maximum.reduceat(positions, starts)

    def surface(self, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
        """Positions and unit normals in a pose, of every member's vertices one after the other. (V, 3) each."""
        if self._latest is not None and self._latest[0] is pose:
            return self._latest[1]
        self._latest = pose, self._surface(pose)
        return self._latest[1]

    def _surface(self, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
        stays = np.eye(4)
        matrices = np.stack([pose.matrices.get(member.name, stays) for member in self._members])
        linear = matrices[:, :3, :3]
        turned = cofactors(linear) * np.where(np.linalg.det(linear) < 0, -1.0, 1.0)[:, None, None]
        positions = times(linear[self._member], self._positions) + matrices[self._member, :3, 3]
        normals = unit(times(turned[self._member], self._normals))
        for number, member in enumerate(self._members):
            if member.name in pose.bent:
                part = slice(self._ends[number], self._ends[number + 1])
                positions[part], normals[part] = member.surface(pose.bent[member.name])
        return positions, normals

    def mesh(self) -> mi.Mesh:
        """Mitsuba's, at rest."""
        faces = [m.common_faces + start for m, start in zip(self._members, self._ends, strict=False)]
        texcoords = None
        if any(m.texcoords is not None for m in self._members):
            texcoords = np.concatenate([_texcoords(m) for m in self._members])
        return make_mesh(
            COMMON, self._positions, np.concatenate(faces), mi.Properties(),
            normals=self._normals, texcoords=texcoords,
        )  # fmt: skip


def _joins(shape: mi.Shape) -> bool:
    """Whether a shape becomes part of the common mesh: a plain mesh that does not shine."""
    return _has_vertices(shape) and not shape.is_emitter()


def _has_vertices(shape: mi.Shape) -> bool:
    """Rectangles say that they are meshes too."""
    return shape.is_mesh() and POSITIONS in mi.traverse(shape)


def _member(name: str, shape: mi.Mesh, row: int) -> Member:
    parameters = mi.traverse(shape)
    texcoords = np.array(parameters[TEXCOORDS]).reshape(-1, 2)
    return Member(name, row, _vertices(shape), texcoords if len(texcoords) else None, _faces(shape))


def _aside(name: str, shape: mi.Shape) -> Aside:
    if _has_vertices(shape):
        return Aside(name, shape, _vertices(shape), None, _faces(shape))
    parameters = mi.traverse(shape)
    if TO_WORLD not in parameters or shape.class_name() in ("Instance", "ShapeGroupPlugin"):
        raise SceneError(f"{name}: a shape of this kind ({shape.class_name().lower()}) cannot be moved")
    box = shape.bbox()
    low, high = np.ravel(box.min), np.ravel(box.max)
    corners = np.array([[(low, high)[(k >> axis) & 1][axis] for axis in range(3)] for k in range(8)])
    matrix = np.array(parameters[TO_WORLD].matrix, np.float64).reshape(4, 4)
    return Aside(name, shape, Bent(corners), matrix, None)


def _faces(shape: mi.Mesh) -> np.ndarray:
    return np.array(mi.traverse(shape)[FACES]).reshape(-1, 3).astype(np.int64)


def _vertices(shape: mi.Mesh) -> Bent:
    """A mesh at rest; without normals where its faces are flat."""
    parameters = mi.traverse(shape)
    positions = np.array(parameters[POSITIONS], np.float64).reshape(-1, 3)
    smooth = shape.has_vertex_normals() and not shape.has_face_normals()
    return Bent(positions, np.array(parameters[NORMALS], np.float64).reshape(-1, 3) if smooth else None)


def _posed(name: str, rest: Bent, pose: Pose) -> Bent:
    if name in pose.bent:
        bent = pose.bent[name]
        return bent if rest.normals is not None else Bent(bent.positions)
    if name in pose.matrices:
        return Bent(*moved_surface(rest.positions, rest.normals, pose.matrices[name]))
    return rest


def _texcoords(member: Member) -> np.ndarray:
    """Zero where there are none, as the material then has no picture."""
    if member.texcoords is None:
        return np.zeros((len(member.used), 2))
    return member.texcoords[member.used]


def _box(low: np.ndarray, high: np.ndarray) -> Box:
    (a, b, c), (d, e, f) = low.tolist(), high.tolist()
    return (a, b, c), (d, e, f)


def _key(number: int) -> str:
    return f"aside-{number}"
