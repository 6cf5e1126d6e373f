"""BSDFs to rows of the material table: one metallic-roughness model for all.

Each rule reads the built BSDF and not its description, so that materials made by a caller count as
well as those of a file. What has no rule is measured.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.own_memory import own
from ddgi.scene.image import Image, Pack, beside
from ddgi.scene.notes import Notes
from ddgi.scene.plugin_parts import parts
from ddgi.scene.reflectance import hemispherical_reflectance
from ddgi.scene.textures import TextureReader, Value, VertexValues
from ddgi.scene.under_coat import under_coat
from ddgi.trace.albedo import facing
from ddgi.trace.materials import NO_TEXTURE, Materials
from ddgi.trace.vertex_colors import NO_COLORS, VertexColors

SMOOTH_ALPHA = 0.001
"""GGX alpha of perfectly smooth materials."""
BLACK = np.zeros(3)


@dataclass(frozen=True)
class Row:
    """One material. Units and ranges as in `ddgi.trace.materials.Materials`."""

    base: Value
    metallic: float = 0.0
    alpha: float = 1.0
    specular: float = 0.0
    opacity: float | Image = 1.0
    double_sided: bool = False
    disney: bool = False
    gloss: Image | None = (
        None  # metallic in red and alpha in green, where they vary; the numbers are their means
    )
    normal: Image | None = None  # of unit length, as (n + 1) / 2
    emission: Value | None = None
    vertex_color: VertexValues | None = None  # multiplied with the base colour
    vertex_opacity: VertexValues | None = None  # multiplied with the opacity

    @property
    def clear(self) -> bool:
        """Rays pass it everywhere, as if it were not there."""
        return not isinstance(self.opacity, Image) and self.opacity <= 0.0


class MaterialReader:
    """Turns BSDFs into rows, each BSDF once."""

    def __init__(self, textures: TextureReader, notes: Notes) -> None:
        self._textures = textures
        self._notes = notes
        self._rows: dict[int, tuple[mi.BSDF, Row]] = {}  # the BSDF too: ids of lost objects return
        self._shape: mi.Shape | None = None
        self._vertex: dict[str, VertexValues] = {}  # of the shape that is read
        self._mixing = False
        self._rules: dict[str, Callable[[mi.BSDF], Row]] = {
            "SmoothDiffuse": self._diffuse,
            "TwoSidedBRDF": self._two_sided,
            "SmoothPlastic": self._plastic,
            "RoughPlastic": self._plastic,
            "Principled": self._principled,
            "PrincipledThin": self._principled_thin,
            "SmoothConductor": self._conductor,
            "RoughConductor": self._conductor,
            "MaskBSDF": self._mask,
            "BlendBSDF": self._blend,
            "SmoothDielectric": self._dielectric,
            "ThinDielectric": self._dielectric,
            "RoughDielectric": self._dielectric,
            "Null": self._dielectric,
            "LinearPolarizer": self._dielectric,  # plates in the way of light, not surfaces
            "LinearRetarder": self._dielectric,
            "CircularPolarizer": self._dielectric,
            "NormalMap": self._normal_map,
            "BumpMap": self._bump_map,
        }

    def row(self, shape: mi.Shape) -> Row:
        """The shape's material, without emission.

        Raises:
            SceneError: A texture holds NaN, infinite or negative values.
        """
        bsdf = shape.bsdf()
        if id(bsdf) in self._rows:
            return self._rows[id(bsdf)][1]
        self._shape, self._textures.met_attribute = shape, False
        self._vertex = {}
        row = self._read(bsdf)
        row = replace(row, vertex_color=self._vertex.get("color"), vertex_opacity=self._vertex.get("opacity"))
        if not self._textures.met_attribute:  # vertex colours differ between shapes
            self._rows[id(bsdf)] = bsdf, row
        return row

    def _read(self, bsdf: mi.BSDF) -> Row:
        row = self._rules.get(bsdf.class_name(), self._measured)(bsdf)
        if not isinstance(row.base, Image):
            return replace(row, base=np.clip(row.base, 0, 1))
        # An image within its range stays the same object, so that it is packed once.
        return replace(row, base=row.base.clamped()) if row.base.texels[..., :3].max() > 1 else row

    def _color(self, bsdf: mi.BSDF, name: str) -> Value:
        texture = parts(bsdf)[name]
        picture, tint = self._textures.factors(texture) or (None, texture)
        found = None if self._mixing else self._textures.of_vertices(tint, self._shape)
        if found is not None:
            self._vertex["opacity" if name == "opacity" else "color"] = found
            return np.ones(3) if picture is None else self._textures.read(picture, self._shape)
        if picture is None:
            return self._textures.read(texture, self._shape)
        value, share = (self._textures.read(t, self._shape) for t in (picture, tint))
        return value.tinted(_plain_mean(share)) if isinstance(value, Image) else value * _plain_mean(share)

    def _number(self, bsdf: mi.BSDF, name: str, default: float = 0.0) -> float:
        """A scalar parameter, be it a number or a texture (then its mean)."""
        texture = parts(bsdf).get(name)
        if texture is not None:
            return self._textures.number(texture, self._shape)
        parameters = mi.traverse(bsdf)
        return float(np.array(parameters[name]).ravel()[0]) if name in parameters else default

    # One rule per plugin ----------------------------------------------------------------------------

    def _diffuse(self, bsdf: mi.BSDF) -> Row:
        return Row(self._color(bsdf, "reflectance"))

    def _two_sided(self, bsdf: mi.BSDF) -> Row:
        nested = parts(bsdf)
        if nested["brdf_0"] is not nested.get("brdf_1", nested["brdf_0"]):
            self._notes.add("twosided with two materials: the front's is used on both sides")
        return replace(self._read(nested["brdf_0"]), double_sided=True)

    def _plastic(self, bsdf: mi.BSDF) -> Row:
        rough = bsdf.class_name() == "RoughPlastic"
        alpha = self._number(bsdf, "alpha", 0.1) if rough else 0.0
        eta = self._number(bsdf, "eta", 1.49)
        coat = self._number(bsdf, "specular_reflectance", 1.0)
        matt = under_coat(bsdf, eta, alpha)
        color = self._color(bsdf, "diffuse_reflectance")
        return Row(
            color.mapped(matt) if isinstance(color, Image) else matt(color),
            alpha=_alpha(alpha) if rough else SMOOTH_ALPHA,
            specular=_normal_reflectance(eta) * min(coat, 1.0),
        )

    def _principled(self, bsdf: mi.BSDF) -> Row:
        eta = self._number(bsdf, "eta", 0.0)
        specular = _normal_reflectance(eta) if eta else 0.08 * self._number(bsdf, "specular", 0.5)
        metallic = self._channel(bsdf, "metallic", 0.0, lambda x: np.clip(x, 0, 1))
        alpha = self._channel(bsdf, "roughness", 0.5, lambda x: np.clip(x * x, 1e-3, 1))
        through = min(max(self._number(bsdf, "spec_trans"), 0.0), 1.0)
        return Row(
            scaled(self._color(bsdf, "base_color"), 1 - through),
            metallic=_mean(metallic),
            alpha=_mean(alpha),
            gloss=self._gloss(metallic, alpha),
            disney=True,
            specular=min(specular, 1.0),
            # Pure glass is not there; partly clear plastic keeps its share of the base colour.
            opacity=0.0 if through == 1 and _mean(metallic) == 0 else 1.0,
        )

    def _channel(
        self, bsdf: mi.BSDF, name: str, default: float, curve: Callable[[np.ndarray], np.ndarray]
    ) -> float | Image:
        """A parameter through a curve, texel by texel where it is a picture."""
        texture = parts(bsdf).get(name)
        value = self._textures.read(texture, self._shape) if texture is not None else None
        if isinstance(value, Image):
            return value.grey().mapped(curve)
        return float(curve(np.array(self._number(bsdf, name, default))))

    def _gloss(self, metallic: float | Image, alpha: float | Image) -> Image | None:
        """Both in one picture; None where neither varies."""
        if isinstance(metallic, Image) and isinstance(alpha, Image) and not metallic.laid_as(alpha):
            self._notes.add("metallic and roughness pictures lie differently: the mean of metallic is used")
            metallic = _mean(metallic)
        varied = isinstance(metallic, Image) or isinstance(alpha, Image)
        return beside(metallic, alpha) if varied else None

    def _principled_thin(self, bsdf: mi.BSDF) -> Row:
        through = min(max(self._number(bsdf, "spec_trans"), 0.0), 1.0)
        backwards = 1 - 0.5 * min(max(self._number(bsdf, "diff_trans"), 0.0), 2.0)
        if backwards < 1:
            self._notes.add("principledthin: light let through diffusely is lost")
        return Row(
            scaled(self._color(bsdf, "base_color"), (1 - through) * backwards),
            alpha=_alpha(self._number(bsdf, "roughness", 0.5) ** 2),
            disney=True,
            specular=_normal_reflectance(self._number(bsdf, "eta", 1.5)),
            opacity=0.0 if through == 1 else 1.0,
            double_sided=True,
        )

    def _conductor(self, bsdf: mi.BSDF) -> Row:
        if "alpha_u" in parts(bsdf):
            alpha = np.sqrt(self._number(bsdf, "alpha_u") * self._number(bsdf, "alpha_v"))
        else:
            rough = bsdf.class_name() == "RoughConductor"
            alpha = self._number(bsdf, "alpha", 0.1) if rough else SMOOTH_ALPHA
        return Row(self._metal(bsdf, _alpha(alpha)), metallic=1.0, alpha=_alpha(alpha))

    def _metal(self, bsdf: mi.BSDF, alpha: float) -> Value:
        """Reflectance at normal incidence; a texture that scales it stays a texture."""
        texture = parts(bsdf).get("specular_reflectance")
        scale: Value = np.ones(3) if texture is None else self._textures.read(texture, self._shape)
        # What scales the metal is divided out where it is brightest: what is left is the metal itself.
        uv, there = _brightest(texture) if isinstance(scale, Image) else (None, scale)
        whole = hemispherical_reflectance(bsdf, uv) / np.maximum(there, 1e-6)
        metal = np.clip(facing(np.minimum(whole, 1.0), alpha), 0, 1)
        return scale.tinted(metal) if isinstance(scale, Image) else scale * metal

    def _mask(self, bsdf: mi.BSDF) -> Row:
        row = self._read(parts(bsdf)["nested_bsdf"])
        opacity = self._color(bsdf, "opacity")
        if isinstance(opacity, Image):
            if row.opacity != 1.0:
                self._notes.add("a mask inside a mask: only the outer one counts")
            return replace(row, opacity=opacity.grey().clamped())
        share = float(np.clip(opacity.mean(), 0, 1))
        if isinstance(row.opacity, Image):
            return replace(row, opacity=row.opacity.tinted(share))
        return replace(row, opacity=row.opacity * share)

    def _blend(self, bsdf: mi.BSDF) -> Row:
        nested = parts(bsdf)
        weight = min(max(self._number(bsdf, "weight"), 0.0), 1.0)
        before, self._mixing = self._mixing, True  # vertex colours of a part count by their mean
        row = self._mixed(self._read(nested["bsdf_0"]), self._read(nested["bsdf_1"]), weight)
        self._mixing = before
        return row

    def _mixed(self, a: Row, b: Row, weight: float) -> Row:
        """(1 - weight) of a and weight of b. What is clear has no colour to mix in, only opacity."""
        if weight in (0.0, 1.0):
            return b if weight else a
        opacity_a, opacity_b = self._plain(a.opacity), self._plain(b.opacity)
        share_a, share_b = (1 - weight) * opacity_a, weight * opacity_b
        opacity = share_a + share_b
        t = share_b / opacity if opacity > 0 else 0.0
        if t in (0.0, 1.0):
            base = b.base if t else a.base
        else:
            base = (1 - t) * self._plain_color(a.base) + t * self._plain_color(b.base)
        return Row(
            base,
            metallic=(1 - t) * a.metallic + t * b.metallic,
            alpha=(1 - t) * a.alpha + t * b.alpha,
            specular=(1 - t) * a.specular + t * b.specular,
            opacity=opacity,
            double_sided=a.double_sided or b.double_sided,
            disney=(b if t > 0.5 else a).disney,
        )

    def _plain(self, opacity: float | Image) -> float:
        if isinstance(opacity, Image):
            self._notes.add("blendbsdf of masks: their mean opacity is used")
            return float(opacity.mean[0])
        return opacity

    def _plain_color(self, base: Value) -> np.ndarray:
        if isinstance(base, Image):
            self._notes.add("blendbsdf of textures: their mean colours are mixed")
            return base.mean
        return base

    def _dielectric(self, bsdf: mi.BSDF) -> Row:
        return Row(BLACK, opacity=0.0)

    def _normal_map(self, bsdf: mi.BSDF) -> Row:
        nested = parts(bsdf)
        row, normal = self._read(nested["nested_bsdf"]), self._textures.normals(nested["normalmap"])
        if normal is None:
            self._notes.add("NormalMap: one normal for a whole surface is left out")
            return row
        if row.normal is not None:
            self._notes.add("a normal map on another: the outer one counts")
        return replace(row, normal=normal)

    def _bump_map(self, bsdf: mi.BSDF) -> Row:
        self._notes.add("BumpMap: the bumps are ignored; a normal map would be seen")
        return self._read(parts(bsdf)["nested_bsdf"])

    def _measured(self, bsdf: mi.BSDF) -> Row:
        self._notes.add(f"{bsdf.class_name()}: taken as diffuse with its measured reflectance")
        return Row(hemispherical_reflectance(bsdf))


def material_table(rows: dict[int, Row]) -> Materials:
    """Lay rows out as the table that hits look up.

    Args:
        rows: By registry number of the shape.
    """
    size = max(rows, default=0) + 1
    base, surface, emission = (np.zeros((size, 4), np.float32) for _ in range(3))
    base[:, 3], surface[:, 1] = 1, 1
    columns = np.full((5, size), NO_TEXTURE, np.uint32)
    pack = Pack()
    for number, row in rows.items():
        opacity = row.opacity.mean[0] if isinstance(row.opacity, Image) else row.opacity
        base[number, :3], base[number, 3] = _plain_mean(row.base), opacity
        surface[number] = row.metallic, row.alpha, row.specular, row.double_sided
        if row.emission is not None:
            emission[number] = *_plain_mean(row.emission), 1
        values = (row.base, row.opacity, row.emission, row.gloss, row.normal)
        for column, value in zip(columns, values, strict=True):
            column[number] = pack.add(value if isinstance(value, Image) else None)
    present = rows.values()
    return Materials(
        base=own(base),
        surface=own(surface),
        disney=mi.Bool([number in rows and rows[number].disney for number in range(size)]),
        emission=own(emission),
        base_texture=mi.UInt32(columns[0]),
        opacity_texture=mi.UInt32(columns[1]),
        emission_texture=mi.UInt32(columns[2]),
        gloss_texture=mi.UInt32(columns[3]),
        normal_texture=mi.UInt32(columns[4]),
        textures=pack.textures(),
        vertex_colors=_vertex_colors(rows, size),
        any_opacity=any(
            isinstance(r.opacity, Image) or r.opacity < 1 or r.vertex_opacity is not None for r in present
        ),
        any_specular=any(r.metallic > 0 or r.specular > 0 for r in present),
        any_single_sided=any(not r.double_sided for r in present),
        any_disney=any(r.disney for r in present),
        any_emission=any(r.emission is not None for r in present),
        any_gloss_texture=any(r.gloss is not None for r in present),
        any_normal_texture=any(r.normal is not None for r in present),
    )


def _vertex_colors(rows: dict[int, Row], size: int) -> VertexColors | None:
    """The table of what vertices carry; None where none carries anything."""
    first = np.full(size, NO_COLORS, np.uint32)
    corners: list[np.ndarray] = []
    tables: list[np.ndarray] = []
    faces = vertices = 0
    for number, row in rows.items():
        given = row.vertex_color or row.vertex_opacity
        if given is None:
            continue
        table = np.ones((len(given.values), 4), np.float32)
        if row.vertex_color is not None:
            table[:, :3] = row.vertex_color.values
        if row.vertex_opacity is not None:
            table[:, 3] = row.vertex_opacity.values.mean(1)
        first[number] = faces
        corners.append(given.faces.astype(np.uint32) + np.uint32(vertices))
        tables.append(table)
        faces, vertices = faces + len(given.faces), vertices + len(table)
    if not tables:
        return None
    return VertexColors(
        first=mi.UInt32(first),
        corners=mi.UInt32(np.concatenate(corners).ravel()),
        values=mi.Float(np.concatenate(tables).ravel()),
    )


def _plain_mean(value: Value) -> np.ndarray:
    return value.mean if isinstance(value, Image) else value


def _mean(value: float | Image) -> float:
    """Of a picture of one channel."""
    return float(value.mean[0]) if isinstance(value, Image) else value


def scaled(value: Value, share: float) -> Value:
    """A colour or picture times a number."""
    if share == 1:
        return value  # the same image object, so that it is packed once
    return value.tinted([share] * 3) if isinstance(value, Image) else value * share


def _alpha(alpha: float) -> float:
    return float(min(max(alpha, 1e-3), 1.0))


def _normal_reflectance(eta: float) -> float:
    """Fresnel reflectance at normal incidence of a relative index of refraction."""
    return ((eta - 1) / (eta + 1)) ** 2


def _brightest(texture: mi.Texture) -> tuple[tuple[float, float], np.ndarray]:
    """Texture coordinates in [0, 1]^2 where the darkest channel is brightest, and the (3,) colour there."""
    inside = (np.arange(64) + 0.5) / 64
    u, v = (axis.ravel() for axis in np.meshgrid(inside, inside))
    si = dr.zeros(mi.SurfaceInteraction3f, u.size)
    si.uv = mi.Point2f(np.array([u, v], np.float32))
    colors = np.array(texture.eval(si)).reshape(3, -1)
    best = int(colors.min(0).argmax())
    return (float(u[best]), float(v[best])), colors[:, best]
