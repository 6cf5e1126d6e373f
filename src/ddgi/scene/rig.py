"""What of a scene can move: its nodes, and the animations, skins and morph targets that act on them.

Nothing here plays it. The scene shows the file at rest; this says how to leave that.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class RigNode:
    """A node of the hierarchy, at rest."""

    name: str
    parent: int | None  # number in `Rig.nodes`
    children: tuple[int, ...]
    local: np.ndarray  # (4, 4) from the node's space to its parent's
    translation: np.ndarray | None  # (3,) the same in parts; None where the file gives a matrix
    rotation: np.ndarray | None  # (4,) quaternion x, y, z, w
    scale: np.ndarray | None  # (3,)
    skin: int | None  # number in `Rig.skins`
    weights: tuple[float, ...]  # of morph targets
    shapes: tuple[str, ...]  # names of the scene's shapes that stand here
    light: str | None  # name of the light that stands here
    camera: str | None


@dataclass(frozen=True)
class Skin:
    """Joints that bend shapes."""

    joints: tuple[int, ...]  # numbers in `Rig.nodes`
    inverse_bind: np.ndarray  # (J, 4, 4) from the mesh's space to each joint's


@dataclass(frozen=True)
class Channel:
    """One motion of one node."""

    node: int
    path: str  # "translation", "rotation", "scale" or "weights"
    interpolation: str  # "LINEAR", "STEP" or "CUBICSPLINE"
    times: np.ndarray  # (T,) [s], rising
    values: np.ndarray  # (T, C); of splines (T, 3, C): in-tangent, value, out-tangent


@dataclass(frozen=True)
class Clip:
    """Motions that run together."""

    name: str
    channels: tuple[Channel, ...]

    @property
    def duration(self) -> float:
        """Time of the last key [s]."""
        return max((float(c.times[-1]) for c in self.channels), default=0.0)


@dataclass(frozen=True)
class Bendable:
    """A shape with morph targets or a skin: its V vertices in the space of its mesh, before either."""

    positions: np.ndarray  # (V, 3), in the order of the shape's vertices
    normals: np.ndarray | None  # (V, 3)
    target_positions: tuple[np.ndarray, ...]  # (V, 3) displacements by morph target
    target_normals: tuple[np.ndarray, ...]
    joints: np.ndarray | None  # (V, K) numbers in the skin's list
    weights: np.ndarray | None  # (V, K)


@dataclass(frozen=True)
class Rig:
    """Everything that can move, in the coordinates of the file.

    What a `Scene` traces counts from its `origin`: as if a node moved by -origin were above all roots.
    """

    nodes: tuple[RigNode, ...] = ()
    skins: tuple[Skin, ...] = ()
    clips: tuple[Clip, ...] = ()
    bendable: dict[str, Bendable] = field(default_factory=dict)  # by name of the shape
