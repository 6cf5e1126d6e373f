"""Every surface a Lambertian one, in our material table and in Mitsuba's parsed scene alike.

The field takes every surface as Lambertian; highlights and glass are what it does not carry. With the
same matt surfaces on both sides, a path-traced picture differs from ours by how light is transported
and by nothing else.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.scene import product_texture
from ddgi.scene.image import WRAP, Image
from ddgi.scene.materials import Row, scaled
from ddgi.scene.plugin_tree import PluginTree
from ddgi.scene.shapes import Geometry
from ddgi.scene.textures import VertexValues
from ddgi.trace import disney
from ddgi.trace.albedo import rough_share

WRAP_MODES = {code: name for name, code in WRAP.items()}
ORIGIN = "made Lambertian"
BSDF_KEY = "_lambertian"
"""Under which a shape finds its BSDF; like other names with an underscore in front, no file has it."""


def make_lambertian(tree: PluginTree, geometry: Geometry) -> Geometry:
    """Give every surface a Lambertian material with its albedo, gloss left out.

    Emission, opacity and sidedness stay. In the tree, each shape gets a new BSDF, and shapes that rays
    do not meet (glass) go. Shapes that came as objects are changed themselves: they cannot be copied.

    Args:
        tree: The parsed scene; it is changed.
        geometry: What was read from it; it stays as it is.

    Returns:
        The geometry with Lambertian rows.
    """
    for parent, key in geometry.left_out:
        tree.drop(parent, key)
    _drop_unused(tree)
    palette = Palette()
    rows = {number: lambertian(row) for number, row in geometry.rows.items()}
    names = {number: palette.bsdf(row) for number, row in rows.items()}
    nodes = tree.append(palette.plugins, ORIGIN)
    for number, owner in geometry.owners.items():
        _paint(tree, owner, nodes[names[number]])
    return replace(geometry, rows=rows)


def lambertian(row: Row) -> Row:
    """The row without highlight; what a metal reflects in all directions together, a matt surface does."""
    matt = disney.even(row.alpha**0.5) if row.disney else 1.0
    kept = matt + (rough_share(row.alpha) - matt) * row.metallic
    base = scaled(row.base, kept)
    if kept > 1:
        base = base.clamped() if isinstance(base, Image) else np.minimum(base, 1.0)
    return replace(
        row, base=base, metallic=0.0, alpha=1.0, specular=0.0, disney=False, gloss=None, normal=None
    )


class Palette:
    """Lambertian BSDFs as plugin descriptions; what several rows have in common is there once."""

    def __init__(self) -> None:
        self.plugins: dict[str, Any] = {}  # as inside a scene dictionary; BSDFs refer to textures by name
        self._names: dict[Any, str] = {}

    def bsdf(self, row: Row) -> str:
        """Name of the BSDF for a row, entered where it is new."""
        described: dict[str, Any] = {"type": "diffuse", "reflectance": self._reflectance(row)}
        if row.double_sided:
            described = {"type": "twosided", "nested": described}
        if isinstance(row.opacity, Image):
            opacity = _multiplied(self._texture(row.opacity, channels=1), row.vertex_opacity)
            described = {"type": "mask", "opacity": opacity, "nested": described}
        elif row.vertex_opacity is not None:
            described = {"type": "mask", "opacity": _attribute(row.vertex_opacity), "nested": described}
        elif row.opacity < 1:  # Mitsuba lets no mask into `twosided`: it is the outermost
            described = {"type": "mask", "opacity": float(row.opacity), "nested": described}
        return self._name("bsdf", repr(described), described)

    def _reflectance(self, row: Row) -> dict[str, Any]:
        value = row.base
        if isinstance(value, Image):
            return _multiplied(self._texture(value, channels=3), row.vertex_color)
        if row.vertex_color is not None:
            return _attribute(row.vertex_color)
        return {"type": "rgb", "value": [float(x) for x in value]}

    def _texture(self, image: Image, channels: int) -> dict[str, Any]:
        """Reference to a texture that reads the image's texels as our own lookup does."""
        rows = [[float(x) for x in row] for row in (*image.to_uv, (0, 0, 1))]
        described = {
            "type": "bitmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(image.texels[..., :channels])),
            "raw": True,  # the texels are linear
            "wrap_mode": WRAP_MODES[image.wrap],
            "filter_type": "nearest" if image.nearest else "bilinear",
            "to_uv": mi.ScalarTransform3f(rows),  # of a 4 x 4 one Mitsuba drops the translation
        }
        return {"type": "ref", "id": self._name("texture", (id(image), channels), described)}

    def _name(self, kind: str, key: Any, described: dict[str, Any]) -> str:
        if key not in self._names:
            self._names[key] = f"{kind}-{len(self._names)}"
            self.plugins[self._names[key]] = described
        return self._names[key]


def _multiplied(picture: dict[str, Any], values: VertexValues | None) -> dict[str, Any]:
    if values is None:
        return picture
    return {"type": product_texture.PLUGIN, "picture": picture, "tint": _attribute(values)}


def _attribute(values: VertexValues) -> dict[str, Any]:
    return {"type": "mesh_attribute", "name": values.name, "scale": values.scale}


def _paint(tree: PluginTree, owner: int | mi.Shape, bsdf: int) -> None:
    """Give a shape, a node or an object, the BSDF that is node `bsdf`."""
    if not isinstance(owner, int):
        owner.set_bsdf(tree.build(bsdf))
        return
    for key, child in tree.children(owner):
        found = (
            tree.kind(child) == mi.ObjectType.BSDF if isinstance(child, int) else isinstance(child, mi.BSDF)
        )
        if found:
            tree.drop(owner, key)
    tree.refer(owner, BSDF_KEY, bsdf)


def _drop_unused(tree: PluginTree) -> None:
    """What nothing needs any more: BSDFs and textures directly in the scene, and groups without shapes.

    Lamps refer to their textures themselves. An empty group would stop Mitsuba from tracing.
    """
    for key, child in tree.children(0):
        if not isinstance(child, int):
            continue
        material = tree.kind(child) in (mi.ObjectType.BSDF, mi.ObjectType.Texture)
        if material or (tree.plugin(child) in ("shapegroup", "merge") and not tree.children(child)):
            tree.drop(0, key)
