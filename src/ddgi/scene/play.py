"""Playing the animations of a glTF file: where its nodes stand at a time, and how its meshes are bent then.

glTF 2.0 specification, sections 3.11 (animations, appendix C for interpolation), 3.7.3 (skins) and
3.7.2.2 (morph targets).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ddgi.box import Point
from ddgi.errors import SceneError
from ddgi.scene.matrices import blended, compose, moved_surface
from ddgi.scene.pose import Bent, Pose
from ddgi.scene.rig import Bendable, Channel, Clip, Rig, RigNode


def moving_nodes(children: Sequence[Sequence[int]], clips: Iterable[Clip]) -> frozenset[int]:
    """Numbers of the nodes that some animation moves, or that stand below one.

    Args:
        children: Of every node.
        clips: The animations.
    """
    waiting = [c.node for clip in clips for c in clip.channels if c.path != "weights"]
    found: set[int] = set()
    while waiting:
        node = waiting.pop()
        if node not in found:
            found.add(node)
            waiting.extend(children[node])
    return frozenset(found)


def moving_shapes(rig: Rig) -> frozenset[str]:
    """Names of the shapes that some animation moves or bends."""
    nodes = moving_nodes([node.children for node in rig.nodes], rig.clips)
    bends = {c.node for clip in rig.clips for c in clip.channels if c.path == "weights"}
    found: set[str] = set()
    for number, node in enumerate(rig.nodes):
        skinned = node.skin is not None and not nodes.isdisjoint(rig.skins[node.skin].joints)
        carried = number in nodes and node.skin is None  # what has a skin stands where its joints are
        if carried or skinned or number in bends:
            found.update(node.shapes)
    return frozenset(found)


class Player:
    """Plays a rig: knows where everything rests, so that a moment costs only what moves."""

    def __init__(self, rig: Rig, origin: Point) -> None:
        """Find what moves. origin: `Scene.origin`, from which poses count."""
        self._rig = rig
        self._outside = np.eye(4)
        self._outside[:3, 3] = -np.asarray(origin)
        everything = [number for number, node in enumerate(rig.nodes) if node.parent is None]
        for number in everything:  # grows meanwhile: parents come before children
            everything.extend(rig.nodes[number].children)
        self._rest = np.tile(np.eye(4), (len(rig.nodes), 1, 1))
        self._local = np.stack([n.local for n in rig.nodes]) if rig.nodes else self._rest
        self._place(everything, self._local, self._rest)
        moving = moving_nodes([node.children for node in rig.nodes], rig.clips)
        self._moving = [number for number in everything if number in moving]
        self._undone = np.linalg.pinv(self._rest[self._moving]) if self._moving else np.zeros((0, 4, 4))
        shapes = moving_shapes(rig)
        self._bending = [
            (number, node)
            for number, node in enumerate(rig.nodes)
            if any(shape in shapes and shape in rig.bendable for shape in node.shapes)
        ]

    def pose(self, clip: Clip, time: float) -> Pose:
        """How everything stands at a time [s] of an animation; before its first and after its last key it rests there."""
        nodes, parts = self._rig.nodes, _parts(clip, time)
        local = self._local.copy()
        for number, changed in parts.items():
            if changed.keys() - {"weights"} and nodes[number].translation is not None:
                local[number] = _local(nodes[number], changed)
        world = self._rest.copy()
        self._place(self._moving, local, world)
        matrices: dict[str, np.ndarray] = {}
        for number, since in zip(self._moving, world[self._moving] @ self._undone, strict=True):
            node = nodes[number]
            carried = (*(shape for shape in node.shapes if node.skin is None), node.light, node.camera)
            matrices |= {name: since for name in carried if name is not None}
        bent: dict[str, Bent] = {}
        for number, node in self._bending:
            weights = parts.get(number, {}).get("weights", node.weights)
            for shape in (shape for shape in node.shapes if shape in self._rig.bendable):
                bent[shape] = self._bent(self._rig.bendable[shape], node, world, number, weights)
        return Pose({name: matrix for name, matrix in matrices.items() if name not in bent}, bent)

    def _place(self, order: Iterable[int], local: np.ndarray, world: np.ndarray) -> None:
        """Fill in the places of nodes, parents first."""
        for number in order:
            parent = self._rig.nodes[number].parent
            world[number] = (self._outside if parent is None else world[parent]) @ local[number]

    def _bent(
        self, shape: Bendable, node: RigNode, world: np.ndarray, number: int, weights: Iterable[float]
    ) -> Bent:
        weights = list(weights)
        positions, normals = shape.positions.astype(np.float64), shape.normals
        for weight, target in zip(weights, shape.target_positions, strict=False):
            positions = positions + weight * target
        if normals is not None:
            for weight, target in zip(weights, shape.target_normals, strict=False):
                normals = normals + weight * target
        matrices = world[number]
        if node.skin is not None and shape.joints is not None and shape.weights is not None:
            skin = self._rig.skins[node.skin]
            joints = np.minimum(shape.joints, len(skin.joints) - 1)
            matrices = blended(
                joints, shape.weights.astype(np.float64), world[list(skin.joints)] @ skin.inverse_bind
            )
        return Bent(*moved_surface(positions, normals, matrices))


def _parts(clip: Clip, time: float) -> dict[int, dict[str, np.ndarray]]:
    """What an animation says at a time, by node and path."""
    found: dict[int, dict[str, np.ndarray]] = {}
    for channel in clip.channels:
        found.setdefault(channel.node, {})[channel.path] = value_at(channel, time)
    return found


def _local(node: RigNode, changed: dict[str, np.ndarray]) -> np.ndarray:
    """(4, 4) a node in its parent's space, with some of its parts changed."""
    parts = ((changed.get(path, getattr(node, path))) for path in ("translation", "rotation", "scale"))
    translation, rotation, scale = (np.asarray(part, np.float64)[None] for part in parts)
    return compose(translation, rotation, scale)[0]


def value_at(channel: Channel, time: float) -> np.ndarray:
    """What a channel says at a time [s]; rotations are unit quaternions x, y, z, w.

    Before the first key that of the first, after the last that of the last. glTF 2.0, appendix C.
    """
    times, values = channel.times.astype(np.float64), channel.values.astype(np.float64)
    after = int(np.searchsorted(times, time, side="right"))
    before, after = max(after - 1, 0), min(after, len(times) - 1)
    span = times[after] - times[before]
    share = float(np.clip((time - times[before]) / span, 0, 1)) if span > 0 else 0.0
    rotation = channel.path == "rotation"
    if channel.interpolation == "CUBICSPLINE":
        found = _spline(values[before], values[after], share, span)
    elif channel.interpolation == "STEP" or share == 0:
        found = values[before]
    elif rotation:
        return _slerp(values[before], values[after], share)
    else:
        found = (1 - share) * values[before] + share * values[after]
    return found / np.linalg.norm(found) if rotation and np.linalg.norm(found) > 0 else found


def _spline(before: np.ndarray, after: np.ndarray, share: float, span: float) -> np.ndarray:
    """Hermite's cubic. before, after: (3, C) in-tangent, value, out-tangent per second."""
    t, t2, t3 = share, share**2, share**3
    start = (2 * t3 - 3 * t2 + 1) * before[1] + span * (t3 - 2 * t2 + t) * before[2]
    return start + (3 * t2 - 2 * t3) * after[1] + span * (t3 - t2) * after[0]


def _slerp(a: np.ndarray, b: np.ndarray, share: float) -> np.ndarray:
    """Between two rotations along the shorter way, at even speed."""
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    cosine = float(a @ b)
    if cosine < 0:
        b, cosine = -b, -cosine
    angle = np.arccos(min(cosine, 1.0))
    if angle < 1e-4:  # as good as straight
        mixed = (1 - share) * a + share * b
    else:
        mixed = (np.sin((1 - share) * angle) * a + np.sin(share * angle) * b) / np.sin(angle)
    return mixed / np.linalg.norm(mixed)


def find_clip(clips: Sequence[Clip], wanted: str | int | None) -> Clip:
    """The animation of that name, or number; the first if none is named.

    Raises:
        SceneError: There is no such one; the message lists those there are.
    """
    names = [clip.name for clip in clips]
    if wanted is None and clips:
        return clips[0]
    if wanted in names:
        return clips[names.index(str(wanted))]
    if str(wanted).isdecimal() and int(str(wanted)) < len(clips):
        return clips[int(str(wanted))]
    what = "no animation" if wanted is None else f"no animation {wanted!r}"
    raise SceneError(f"{what}: there are {', '.join(names) or 'none'}")
