"""Texture plugins to constants or images, in linear Rec.709."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.luminance import LUMINANCE
from ddgi.scene import product_texture
from ddgi.scene.image import WRAP, Image
from ddgi.scene.mesh_keys import mesh_attribute_mean, vertex_attribute
from ddgi.scene.notes import Notes
from ddgi.scene.plugin_parts import parts
from ddgi.scene.plugin_tree import PluginTree
from ddgi.scene.validate import check_finite, check_light

BAKED_SIZE = 512
"""Width and height of textures that are functions and not pictures [texels]."""

Value = np.ndarray | Image
"""(3,) linear RGB, the same everywhere; or an image."""


@dataclass(frozen=True, eq=False)
class VertexValues:
    """A mesh attribute of V vertices."""

    name: str
    scale: float
    faces: np.ndarray  # (F, 3)
    values: np.ndarray  # (V, 1 or 3), scale included, in [0, 1]


class TextureReader:
    """Reads every texture of a scene once."""

    def __init__(self, tree: PluginTree, notes: Notes) -> None:
        self._tree = tree
        self._notes = notes
        self._read: dict[Any, tuple[mi.Texture, Value]] = {}  # the texture too: ids of lost objects return
        self.met_attribute = False  # a value depended on the shape since this was last reset

    def read(self, texture: mi.Texture, shape: mi.Shape | None = None, owner: str | None = None) -> Value:
        """The texture's colour: (3,) if constant, else an image.

        Args:
            texture: Any texture plugin; of spectra, what Mitsuba's RGB variants see.
            shape: Whose vertex colours a `mesh_attribute` means.
            owner: What to call the value in messages; by default the texture itself.

        Raises:
            SceneError: A value is negative, NaN or infinite.
        """
        if texture.class_name() == "MeshAttribute":
            self.met_attribute = True
            return self._attribute(texture, shape)
        key = self._key(texture)
        if key not in self._read:
            value = self._value(texture, owner or f"{self._tree.label_of(texture)}: a value")
            self._read[key] = texture, value
        return self._read[key][1]

    def normals(self, texture: mi.Texture) -> Image | None:
        """A normal map, whose values may lie outside [0, 1]; None where it is no picture.

        Raises:
            SceneError: A value is NaN or infinite.
        """
        if texture.class_name() == "MeshAttribute" or not texture.is_spatially_varying():
            return None
        key = "normals", self._key(texture)
        if key not in self._read:
            value = self._picture(texture, f"{self._tree.label_of(texture)}: a value", check_finite)
            self._read[key] = texture, value
        found = self._read[key][1]
        assert isinstance(found, Image)
        return found

    def of_vertices(self, texture: mi.Texture, shape: mi.Shape | None) -> VertexValues | None:
        """What the vertices of a shape say, where a texture asks them.

        Raises:
            SceneError: A value is negative, NaN or infinite.
        """
        properties = self._tree.properties_of(texture)
        if texture.class_name() != "MeshAttribute" or shape is None or properties is None:
            return None
        name, scale = properties.get("name", ""), properties.get("scale", 1.0)
        found = vertex_attribute(shape, name)
        if found is None or found[1].shape[1] not in (1, 3):
            return None
        values = scale * found[1]
        check_light(values, f"{self._tree.label_of(texture)}: a value")
        self.met_attribute = True
        return VertexValues(name, scale, found[0], np.minimum(values, 1.0))

    def factors(self, texture: mi.Texture) -> tuple[mi.Texture, mi.Texture] | None:
        """Picture and tint of a product of the two; None for other textures."""
        properties = self._tree.properties_of(texture)
        if properties is None or properties.plugin_name() != product_texture.PLUGIN:
            return None
        made_of = parts(texture)
        return made_of["picture"], made_of["tint"]

    def mean(self, texture: mi.Texture, shape: mi.Shape | None = None) -> np.ndarray:
        """(3,) mean colour; a note says if that dropped a texture."""
        value = self.read(texture, shape)
        if isinstance(value, Image):
            self._notes.add("a texture where one number per material is kept: its mean is used")
            return value.mean
        return value

    def number(self, texture: mi.Texture, shape: mi.Shape | None = None) -> float:
        """Mean of a one-channel texture."""
        return float(self.mean(texture, shape) @ LUMINANCE)

    def _key(self, texture: mi.Texture) -> Any:
        """Equal for textures that read the same file in the same way."""
        properties = self._tree.properties_of(texture)
        if properties is None or "filename" not in properties:
            return id(texture)
        path = str(mi.file_resolver().resolve(properties["filename"]))
        return path, tuple((k, str(properties[k])) for k in sorted(properties.keys()) if k != "filename")

    def _value(self, texture: mi.Texture, what: str) -> Value:
        if not texture.is_spatially_varying():
            color = _constant(texture)
            check_light(color, what)
            return color
        return self._picture(texture, what, check_light)

    def _picture(self, texture: mi.Texture, what: str, check: Callable[[Any, str], None]) -> Image:
        if texture.class_name().startswith("BitmapTexture"):
            values, keywords = self._bitmap(texture)
        else:
            values, keywords = self._baked(texture)
        check(values, what)
        return Image.from_array(values, **keywords, to_uv=_to_uv(texture))

    def _bitmap(self, texture: mi.Texture) -> tuple[np.ndarray, dict[str, Any]]:
        """(H, W, C) linear values as stored, with wrap mode and filter."""
        properties = self._tree.properties_of(texture)
        values = mi.traverse(texture)["data"].numpy()
        if values.dtype == np.uint8:  # stored as in the file: decoded when read, unless raw
            raw = properties is not None and properties.get("raw", False)
            levels = np.arange(256) / 255
            values = (levels if raw else srgb_to_linear(levels)).astype(np.float16)[values]
        if properties is None:
            return values, {}
        wrap = WRAP[properties.get("wrap_mode", "repeat")]
        return values, {"wrap": wrap, "nearest": properties.get("filter_type", "bilinear") == "nearest"}

    def _baked(self, texture: mi.Texture) -> tuple[np.ndarray, dict[str, Any]]:
        """(H, W, 3) values over one period of the texture's own coordinates."""
        # A checkerboard changes at halves and wholes only: two by two texels without a filter are exact.
        exact = texture.class_name() == "Checkerboard"
        size = 2 if exact else BAKED_SIZE
        if not exact:
            self._notes.add(f"{texture.class_name()} textures are baked to {size} x {size} texels")
        inside = (np.arange(size) + 0.5) / size
        u, v = np.meshgrid(inside, inside)
        matrix = np.eye(3)
        matrix[:2] = _to_uv(texture)
        uv = np.linalg.pinv(matrix) @ np.stack([u.ravel(), v.ravel(), np.ones(size * size)])
        si = dr.zeros(mi.SurfaceInteraction3f, size * size)
        si.uv = mi.Point2f(np.float32(uv[:2]))
        return np.array(texture.eval(si)).T.reshape(size, size, 3), {"nearest": exact}

    def _attribute(self, texture: mi.Texture, shape: mi.Shape | None) -> np.ndarray:
        properties = self._tree.properties_of(texture)
        name = properties.get("name", "") if properties is not None else ""
        mean = mesh_attribute_mean(shape, name) if shape is not None else None
        self._notes.add(f"mesh attribute {name!r}: its mean is used")
        if mean is None:
            return np.full(3, 0.5)
        value = mean * (properties.get("scale", 1.0) if properties is not None else 1.0)
        check_light(value, f"{self._tree.label_of(texture)}: a value")
        return np.resize(value, 3) if value.size < 3 else value[:3]


def _constant(texture: mi.Texture) -> np.ndarray:
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.uv = mi.Point2f(0.5)
    return np.resize(np.array(texture.eval(si), np.float64).ravel(), 3)


def _to_uv(texture: mi.Texture) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Two rows of the texture's own transform of coordinates."""
    parameters = mi.traverse(texture)
    matrix = np.array(parameters["to_uv"].matrix) if "to_uv" in parameters else np.eye(3)
    return tuple(map(float, matrix[0])), tuple(map(float, matrix[1]))


def srgb_to_linear(x: np.ndarray) -> np.ndarray:
    """Decode the sRGB curve; values in [0, 1]."""
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
