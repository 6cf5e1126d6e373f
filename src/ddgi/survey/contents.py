"""What was loaded, counted."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import numpy as np

from ddgi.scene.scene import Scene
from ddgi.trace.materials import Materials


@dataclass(frozen=True)
class Contents:
    """Numbers of things in a scene."""

    triangles: int  # an analytic shape counts as one
    shapes: int
    instances: int
    materials: int  # that differ
    textures: int
    texels: int
    animations: int
    skins: int
    morphs: int  # shapes with morph targets


def contents(scene: Scene) -> Contents:
    """Count what a scene holds."""
    textures, rig = scene.materials.textures, scene.rig
    return Contents(
        triangles=scene.triangles,
        shapes=len(scene.shapes),
        instances=sum(shape.class_name() == "Instance" for shape in scene.mi_scene.shapes()),
        materials=_different(scene.materials, sorted(scene.shapes.values())),
        textures=0 if textures is None else dr.width(textures.offset),
        texels=0 if textures is None else int(np.sum(textures.width.numpy() * textures.height.numpy())),
        animations=0 if rig is None else len(rig.clips),
        skins=0 if rig is None else len(rig.skins),
        morphs=0 if rig is None else sum(bool(b.target_positions) for b in rig.bendable.values()),
    )


def _different(materials: Materials, rows: list[int]) -> int:
    """How many of the table's rows differ."""
    numbers = (materials.base, materials.surface, materials.emission)
    names = (materials.base_texture, materials.opacity_texture, materials.emission_texture)
    columns = [np.array(n).reshape(-1, 4) for n in numbers] + [np.array(n)[:, None] for n in names]
    return len(np.unique(np.concatenate(columns, 1)[rows], axis=0))
