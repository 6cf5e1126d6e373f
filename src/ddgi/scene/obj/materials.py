"""MTL materials to Mitsuba's BSDFs.

`diffuse` from Kd; `roughplastic` where Ks is not black, its roughness from Blinn's exponent (Walter
et al. 2007: alpha^2 = 2 / (Ns + 2)); a mirror where illum 3 or 5 says so and Kd is next to nothing; glass for
illum 4, 6 and 7. Opacity is a `mask` around it. All are two-sided: the format knows no other.
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.beside import MissingFileError, file_beside, shown
from ddgi.scene.jpeg import heard
from ddgi.scene.mesh_keys import COLOR_ATTRIBUTE
from ddgi.scene.notes import PICTURE_MISSING, Notes
from ddgi.scene.obj.mtl import Material, Picture

GREY = 0.5
MIRRORS, GLASS = (3, 5), (4, 6, 7)
IOR = 1.5
"""Of glass and varnish where the file says none, or none above 1."""
SMOOTHEST = 0.01
NEXT_TO_NOTHING = 0.05
"""Of Ks: a Kd that mirrors may have, as with 0.01 beside 0.95 in the spheres of well-known Cornell boxes."""
Described = dict[str, Any]


def rgb(values: Any) -> Described:
    """A constant colour."""
    return {"type": "rgb", "value": [float(x) for x in np.resize(values, 3)]}


class Materials:
    """Makes BSDFs and radiances of materials."""

    def __init__(self, notes: Notes) -> None:
        self._notes = notes
        self._pictures: dict[Any, Described | None] = {}

    def bsdf(self, material: Material, vertex_colors: bool) -> Described:
        """The BSDF of a material, on a shape with or without colours of vertices.

        Raises:
            SceneError: One of its pictures lies outside the scene's folder, or cannot be decoded.
        """
        bsdf = self._surface(material, vertex_colors)
        if bsdf["type"] != "dielectric":
            bsdf = {"type": "twosided", "nested": bsdf}
        opacity = self._opacity(material)
        return bsdf if opacity is None else {"type": "mask", "opacity": opacity, "nested": bsdf}

    def radiance(self, material: Material) -> Described | None:
        """What a material emits; None if nothing."""
        factor = material.emission
        picture = material.pictures.get("emission")
        if picture is not None and (factor is None or not factor.any()):
            factor = np.ones(3)
        if factor is None or not factor.any():
            return None
        return (self._color(picture, factor) if picture is not None else None) or rgb(factor)

    def _surface(self, material: Material, vertex_colors: bool) -> Described:
        ior = material.ior if material.ior is not None and material.ior > 1 else IOR
        if material.illum in GLASS:
            tint = np.ones(3) if material.filter is None else np.minimum(material.filter, 1)
            return {"type": "dielectric", "int_ior": ior, "specular_transmittance": rgb(tint)}
        specular = np.zeros(3) if material.specular is None else np.minimum(material.specular, 1)
        diffuse = GREY if material.diffuse is None else float(np.max(material.diffuse))
        dark = diffuse <= NEXT_TO_NOTHING * float(specular.max())
        if material.illum in MIRRORS and dark and specular.any() and not material.pictures.get("diffuse"):
            return {
                "type": "roughconductor", "material": "none", "alpha": _alpha(material),
                "specular_reflectance": rgb(specular),
            }  # fmt: skip
        base = self._base(material, vertex_colors)
        if not specular.any() or material.illum in (0, 1):
            return {"type": "diffuse", "reflectance": base}
        return {
            "type": "roughplastic", "diffuse_reflectance": base, "alpha": _alpha(material),
            "int_ior": min(ior, 2.5), "specular_reflectance": rgb(specular),
        }  # fmt: skip

    def _base(self, material: Material, vertex_colors: bool) -> Described:
        picture, factor = material.pictures.get("diffuse"), material.diffuse
        if picture is not None:
            if factor is not None and not factor.any():
                self._notes.add("Kd is black beside a map_Kd: the picture is shown as it is")
                factor = None
            factor = np.ones(3) if factor is None else factor
            return self._color(picture, np.minimum(factor, 1)) or rgb(GREY)
        if vertex_colors:
            return {"type": "mesh_attribute", "name": COLOR_ATTRIBUTE}  # Kd is in the colours
        if factor is not None and (factor > 1).any():
            self._notes.add("a Kd above 1: taken as 1")
        return rgb(GREY if factor is None else np.minimum(factor, 1))

    def _opacity(self, material: Material) -> Described | None:
        opacity = material.opacity
        if opacity is None and material.transparency is not None:
            opacity = 1 - material.transparency
        opacity = 1.0 if opacity is None else min(max(opacity, 0.0), 1.0)
        picture = material.pictures.get("opacity")
        found = None
        if picture is not None:
            found = self._picture(picture, f"opacity {opacity}", lambda texels: _coverage(texels) * opacity)
        if found is None and opacity < 1 and material.illum not in GLASS:
            found = {"type": "rgb", "value": opacity}
        return found

    # Pictures -------------------------------------------------------------------------------------------

    def _color(self, picture: Picture, factor: np.ndarray) -> Described | None:
        return self._picture(picture, f"color {factor.tolist()}", lambda texels: texels[..., :3] * factor)

    def _picture(self, picture: Picture, what: str, read: Any) -> Described | None:
        """A texture of texels that are read from linear RGBA; None, and a note, where the file is missing."""
        key = picture.file, picture.folder, picture.offset, picture.scale, picture.clamp, what
        if key not in self._pictures:
            self._pictures[key] = self._made(picture, read)
        return self._pictures[key]

    def _made(self, picture: Picture, read: Any) -> Described | None:
        try:
            path = file_beside(picture.file, picture.folder, picture.owner, any_case=True)
        except MissingFileError:
            self._notes.add(f"{PICTURE_MISSING}: {shown(picture.file)}")
            return None
        try:
            with heard(shown(picture.file), self._notes):
                bitmap = mi.Bitmap(str(path))
        except Exception as error:
            raise SceneError(f"{picture.owner}: {shown(picture.file)} cannot be decoded") from error
        linear = bitmap.convert(mi.Bitmap.PixelFormat.RGBA, mi.Struct.Type.Float32, srgb_gamma=False)
        texels = np.ascontiguousarray(read(np.array(linear)), np.float16)
        (x, y), (across, down) = picture.offset, picture.scale
        # The file's v runs upwards, ours down from a picture's first row.
        matrix = [[across, 0, x], [0, down, 1 - down - y], [0, 0, 1]]
        return {
            "type": "bitmap", "bitmap": mi.Bitmap(texels), "raw": True,
            "wrap_mode": "clamp" if picture.clamp else "repeat",
            "to_uv": mi.ScalarTransform3f(matrix),
        }  # fmt: skip


def _coverage(texels: np.ndarray) -> np.ndarray:
    """(H, W, 1) alpha where the picture has some, else how bright it is."""
    alpha = texels[..., 3:]
    return alpha if (alpha < 1).any() else _encoded(texels[..., :3].mean(-1, keepdims=True))


def _encoded(linear: np.ndarray) -> np.ndarray:
    """Back to the number as stored: pictures of opacity hold no light."""
    bent = 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, linear * 12.92, bent)


def _alpha(material: Material) -> float:
    exponent = 10.0 if material.shininess is None else max(material.shininess, 0.0)
    return float(min(max(np.sqrt(2 / (exponent + 2)), SMOOTHEST), 1.0))
