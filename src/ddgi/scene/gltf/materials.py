"""Materials to Mitsuba's BSDFs: metallic-roughness as `principled`, which shares its meaning.

Specular reflectance comes from KHR_materials_ior and KHR_materials_specular; transmission makes thin
or solid glass; opacity is a `mask` around all else, `twosided` says doubleSided. What emits does so
with its emissiveFactor times KHR_materials_emissive_strength, nits taken as W/(m^2 sr).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ddgi.scene import product_texture
from ddgi.scene.gltf import textures
from ddgi.scene.gltf.schema import Document, Material, MetallicRoughness, TextureInfo
from ddgi.scene.gltf.textures import Described, Filter, Textures
from ddgi.scene.mesh_keys import ALPHA_ATTRIBUTE, COLOR_ATTRIBUTE
from ddgi.scene.notes import Notes

DIELECTRIC = 0.04
"""Reflectance at normal incidence of an index of refraction of 1.5, which `principled` has by default."""
MOST_SPECULAR = 0.5
"""Beyond this a surface is a metal, and not one with an index of refraction."""


@dataclass(frozen=True)
class VertexColors:
    """What the vertices of a mesh say of its colour."""

    varied: bool = False  # colours that differ between vertices, or are not white
    alpha: bool = False  # opacities that are not all one


@dataclass(frozen=True)
class Look:
    """A material as a shape has it."""

    bsdf: Described
    radiance: Described | None  # of the area light it is; None if it does not emit
    uv_set: int | None  # number of the texture coordinates that its textures use; None without textures
    bumpy: bool = False  # it has a normal map


def rgb(values: Any) -> Described:
    """A constant colour."""
    return {"type": "rgb", "value": [float(x) for x in values]}


class Materials:
    """Makes the BSDFs of a file, each once."""

    def __init__(self, document: Document, made: Textures, notes: Notes) -> None:
        self._document = document
        self._textures = made
        self._notes = notes
        self._looks: dict[tuple[int | None, VertexColors, bool], Look] = {}
        self.plugins: dict[str, Described] = {}  # as inside a scene dictionary
        self.called: dict[str, str] = {}  # names in the file, by key of `plugins`

    def look(self, index: int | None, vertices: VertexColors, mirrored: bool = False) -> Look:
        """What a primitive looks like; without a material, as the specification's default.

        Args:
            index: Of the material.
            vertices: What they say of its colour.
            mirrored: Whether its pictures lie on it as seen in a mirror: Mitsuba takes the second axis of a
                normal map from the first and the normal, so that its green is turned around there.

        Raises:
            SceneError: One of its pictures cannot be used.
        """
        key = index, vertices, mirrored
        if key not in self._looks:
            material = Material() if index is None else self._document.materials[index]
            look = _Reader(material, self._textures, vertices, self._notes, mirrored).look()
            name = f"_material-{len(self.plugins)}"
            self.plugins[name] = look.bsdf
            self.called[name] = material.name or ("" if index is None else f"material-{index}")
            self._looks[key] = replace(look, bsdf={"type": "ref", "id": name})
        return self._looks[key]


class _Reader:
    """Reads one material."""

    def __init__(
        self, material: Material, made: Textures, vertices: VertexColors, notes: Notes, mirrored: bool
    ) -> None:
        self._material = material
        self._mirrored = mirrored
        self._textures = made
        self._vertices = vertices
        self._notes = notes
        self._pbr = self._model()
        self._uv_set = self._chosen_set()

    def look(self) -> Look:
        material = self._material
        if material.occlusion_texture is not None:
            self._notes.add("occlusion textures are left out: corners are darkened by light itself")
        if material.extensions.unlit is not None:
            self._notes.add("unlit material: it emits its colour, and reflects nothing")
            return Look(self._masked(_black(material.double_sided)), self._unlit(), self._uv_set)
        bsdf = self._surface()
        bumpy = material.normal_texture is not None and self._textures.has_picture(material.normal_texture)
        if bumpy:
            bsdf = self._bumpy(bsdf)
        if material.double_sided and "spec_trans" not in str(bsdf):
            bsdf = {"type": "twosided", "nested": bsdf}
        return Look(self._masked(bsdf), self._radiance(), self._uv_set, bumpy)

    def _model(self) -> MetallicRoughness:
        """The metallic-roughness model; of materials of the retired kind, what comes close."""
        old = self._material.extensions.glossiness
        if old is None:
            return self._material.pbr
        self._notes.add("a specular-glossiness material is taken as a dielectric of its diffuse colour")
        return MetallicRoughness.model_construct(
            base_color_factor=old.diffuse_factor, base_color_texture=old.diffuse_texture,
            metallic_factor=0.0, roughness_factor=1 - old.glossiness_factor, metallic_roughness_texture=None,
        )  # fmt: skip

    # Textures -------------------------------------------------------------------------------------------

    def _chosen_set(self) -> int | None:
        """A mesh has one set of coordinates here: that of the first of these textures."""
        uses = (
            self._pbr.base_color_texture, self._material.emissive_texture, self._material.normal_texture,
            self._pbr.metallic_roughness_texture,
        )  # fmt: skip
        return next((_uv_set(use) for use in uses if use is not None), None)

    def _shown(self, info: TextureInfo, kind: tuple[str, Filter]) -> Described:
        if _uv_set(info) == self._uv_set:
            return self._textures.shown(info, *kind)
        self._notes.add("a texture on another set of coordinates than its material's first: its mean is used")
        return rgb(self._textures.mean(info, kind[1]))

    # Parts ----------------------------------------------------------------------------------------------

    def _base(self) -> Described:
        factor, info = self._pbr.base_color_factor[:3], self._pbr.base_color_texture
        if info is not None and self._textures.has_picture(info):
            picture = self._shown(info, textures.color(factor))
            return _times_vertices(picture, COLOR_ATTRIBUTE) if self._vertices.varied else picture
        if self._vertices.varied:
            return {"type": "mesh_attribute", "name": COLOR_ATTRIBUTE}  # the factor is in the colours
        return rgb(factor)

    def _unlit(self) -> Described:
        """Base colour as radiance."""
        info = self._pbr.base_color_texture
        if info is not None and self._textures.has_picture(info):
            if self._vertices.varied:
                self._notes.add("vertex colours of an unlit picture are left out")
            return self._shown(info, textures.color(self._pbr.base_color_factor[:3]))
        return self._base()

    def _surface(self) -> Described:
        pbr = self._pbr
        through = self._transmission()
        metallic, roughness = self._metallic_roughness(pbr)
        bsdf: Described = {"base_color": self._base(), "roughness": roughness}
        if not through:
            return {"type": "principled", "metallic": metallic, **bsdf, **self._specular()}
        solid = self._material.extensions.volume
        eta = {"eta": max(self._ior(), 1.01)}
        if solid is not None and solid.thickness_factor > 0:
            return {"type": "principled", "metallic": metallic, "spec_trans": through, **bsdf, **eta}
        return {"type": "principledthin", "spec_trans": through, **bsdf, **eta}

    def _metallic_roughness(self, pbr: MetallicRoughness) -> tuple[Any, Any]:
        info = pbr.metallic_roughness_texture
        if info is None or not self._textures.has_picture(info):
            return pbr.metallic_factor, pbr.roughness_factor
        roughness = self._shown(info, textures.channel(1, pbr.roughness_factor))
        metallic = self._shown(info, textures.channel(2, pbr.metallic_factor)) if pbr.metallic_factor else 0.0
        return metallic, roughness

    def _transmission(self) -> float:
        """Mean share of light that passes."""
        through = self._material.extensions.transmission
        if through is None:
            return 0.0
        share = through.transmission_factor
        if share and through.transmission_texture is not None:
            info = through.transmission_texture
            if self._textures.has_picture(info):
                share *= float(self._textures.mean(info, textures.channel(0, 1.0)[1])[0])
        return share

    def _ior(self) -> float:
        ior = self._material.extensions.ior
        return 1.5 if ior is None else ior.ior

    def _specular(self) -> Described:
        """The parameter of `principled` for the reflectance at normal incidence."""
        extensions, ior = self._material.extensions, self._ior()
        reflectance = ((ior - 1) / (ior + 1)) ** 2
        if extensions.specular is not None:
            tint = float(np.mean(extensions.specular.specular_color_factor))
            reflectance = min(reflectance * tint, 1.0) * extensions.specular.specular_factor
        if extensions.glossiness is not None:
            reflectance = float(np.mean(extensions.glossiness.specular_factor))
        if abs(reflectance - DIELECTRIC) < 1e-6:
            return {}
        if reflectance <= 0.08:
            return {"specular": reflectance / 0.08}
        root = np.sqrt(min(reflectance, MOST_SPECULAR))
        return {"eta": float((1 + root) / (1 - root))}

    def _bumpy(self, bsdf: Described) -> Described:
        info = self._material.normal_texture
        assert info is not None
        if _uv_set(info) != self._uv_set:
            self._notes.add("a normal map on another set of coordinates than its material's is left out")
            return bsdf
        return {
            "type": "normalmap",
            "normalmap": self._textures.shown(info, *textures.normals(info.scale, self._mirrored)),
            "nested": bsdf,
        }

    def _radiance(self) -> Described | None:
        extension = self._material.extensions.emissive_strength
        strength = 1.0 if extension is None else extension.emissive_strength
        factor = [strength * f for f in self._material.emissive_factor]
        if not any(factor):
            return None
        info = self._material.emissive_texture
        if info is not None and self._textures.has_picture(info):
            if not self._textures.mean(info, textures.color([1.0, 1.0, 1.0])[1]).any():
                return None  # a black picture: no light
            return self._shown(info, textures.color(factor))
        return rgb(factor)

    def _masked(self, bsdf: Described) -> Described:
        """The material with its opacity around it."""
        opacity = self._opacity()
        return bsdf if opacity is None else {"type": "mask", "opacity": opacity, "nested": bsdf}

    def _opacity(self) -> Any:
        """None for opaque ones."""
        material = self._material
        if material.alpha_mode == "OPAQUE":
            return None
        cutoff = material.alpha_cutoff if material.alpha_mode == "MASK" else None
        factor, info = self._pbr.base_color_factor[3], self._pbr.base_color_texture
        if info is not None and self._textures.has_picture(info):
            if not self._textures.opaque(info) or self._vertices.alpha:
                picture = self._shown(info, textures.opacity(factor, cutoff))
                return _times_vertices(picture, ALPHA_ATTRIBUTE) if self._vertices.alpha else picture
        elif self._vertices.alpha:
            return {"type": "mesh_attribute", "name": ALPHA_ATTRIBUTE}  # factor and cutoff are in it
        share = factor if cutoff is None else float(factor >= cutoff)
        return None if share == 1 else share


def _times_vertices(picture: Described, attribute: str) -> Described:
    if picture["type"] == "rgb":  # the mean of one on other coordinates; Mitsuba wants a texture here
        picture = {"type": "uniform", "value": float(np.mean(picture["value"]))}
    tint = {"type": "mesh_attribute", "name": attribute}
    return {"type": product_texture.PLUGIN, "picture": picture, "tint": tint}


def _uv_set(info: TextureInfo) -> int:
    transform = info.extensions.transform
    return info.tex_coord if transform is None or transform.tex_coord is None else transform.tex_coord


def _black(double_sided: bool) -> Described:
    black = {"type": "diffuse", "reflectance": rgb((0, 0, 0))}
    return {"type": "twosided", "nested": black} if double_sided else black
