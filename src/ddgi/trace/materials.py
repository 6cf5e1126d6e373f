"""The material table: what light meets, one row per shape, looked up by the shape's number.

Every importer reduces its materials to one metallic-roughness model (base colour, metallic,
roughness, specular reflectance at normal incidence, opacity, sidedness, emission). A hit then
reads its row with a few packet loads instead of virtual calls, and a kernel does not grow with
the number of materials.

Two lobes: a matt part, Lambert's or Disney's, with base_color * (1 - metallic), and GGX with F0 =
lerp(specular, base_color, metallic). Camera pixels see them apart; the field takes every opaque material
as Lambertian with what both together send back of even light (`ddgi.trace.albedo`).
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ddgi.extrema import at_least
from ddgi.trace import textures, vertex_colors
from ddgi.trace.vertex_colors import Corner, VertexColors

NO_TEXTURE = 0xFFFFFFFF
"""In a texture column: this row has no texture there; the constant column holds its value."""


@dataclass
class Textures:
    """All bitmaps of a scene in one buffer. T textures, N texels in all, linear Rec.709."""

    texels: mi.Float16  # (4 N,) RGBA, half precision, row by row, first row at v = 0 side as stored
    offset: mi.UInt32  # (T,) first texel of each texture
    width: mi.UInt32  # (T,)
    height: mi.UInt32  # (T,)
    wrap: mi.UInt32  # (T,) 0 repeat, 1 clamp, 2 mirror
    nearest: mi.Bool  # (T,) no bilinear filter
    to_uv: mi.Float  # (8 T,) per texture the two rows of the affine UV transform: a b c 0, d e f 0


@dataclass
class Materials:
    """One row per shape, indexed by Dr.Jit's registry number of the shape (S rows, row 0 unused)."""

    base: mi.Float  # (4 S,) base colour r g b in [0, 1], then opacity in [0, 1]
    surface: mi.Float  # (4 S,) metallic [0, 1], GGX alpha (0, 1], specular F0 [0, 1], double-sided 0 or 1
    disney: mi.Bool  # (S,) the matt part is Disney's and not Lambert's (`ddgi.trace.disney`)
    emission: mi.Float  # (4 S,) emitted radiance r g b >= 0, then what remains of it >= 0: 0 off, 1 all
    base_texture: mi.UInt32  # (S,) replaces base colour; NO_TEXTURE for none
    opacity_texture: mi.UInt32  # (S,) replaces opacity (first channel)
    emission_texture: mi.UInt32  # (S,) replaces emission
    gloss_texture: mi.UInt32  # (S,) replaces metallic (red) and alpha (green)
    normal_texture: mi.UInt32  # (S,) a normal n in the axes of the texture's coordinates, as (n + 1) / 2
    textures: Textures | None  # None where no row has a texture
    vertex_colors: VertexColors | None = None  # multiplied with base colour and opacity
    # What no row of this scene needs is compiled out:
    any_opacity: bool = False  # some surface may be passed through
    any_specular: bool = False  # some surface has metallic > 0 or specular F0 > 0
    any_single_sided: bool = True
    any_disney: bool = False
    any_emission: bool = False
    any_gloss_texture: bool = False
    any_normal_texture: bool = False


@dataclass
class Material:
    """The rows of N hits, textures applied. Units as in `Materials`."""

    base: mi.Color3f
    opacity: mi.Float
    metallic: mi.Float
    alpha: mi.Float
    specular: mi.Float
    disney: mi.Bool
    double_sided: mi.Bool
    emission: mi.Color3f


def lookup(
    materials: Materials, row: mi.UInt32, uv: mi.Point2f, active: mi.Bool, corner: Corner | None = None
) -> Material:
    """Material of each hit. row: (N,) registry number of the shape; uv: (N,); inactive lanes give zeros.

    Vertex colours count where `corner` says which triangle was hit.
    """
    base = dr.gather(mi.Vector4f, materials.base, row, active)
    surface = dr.gather(mi.Vector4f, materials.surface, row, active)
    color, opacity = mi.Color3f(base.x, base.y, base.z), base.w
    emission, share = mi.Color3f(0), mi.Float(1)
    if materials.any_emission:
        glow = dr.gather(mi.Vector4f, materials.emission, row, active)
        emission, share = mi.Color3f(glow.x, glow.y, glow.z), glow.w
    metallic, alpha = surface.x, surface.y
    if materials.textures is not None:
        color = _textured(materials, materials.base_texture, color, row, uv, active)
        if materials.any_gloss_texture:
            flat = mi.Color3f(metallic, alpha, 0)
            varied = _textured(materials, materials.gloss_texture, flat, row, uv, active)
            metallic, alpha = varied.x, varied.y
        if materials.any_opacity:
            opacity = _textured(materials, materials.opacity_texture, mi.Color3f(opacity), row, uv, active).x
        if materials.any_emission:
            emission = _textured(materials, materials.emission_texture, emission, row, uv, active)
    if materials.vertex_colors is not None and corner is not None:
        tint, share_there = vertex_colors.lookup(materials.vertex_colors, row, corner, active)
        color, opacity = color * tint, opacity * share_there
    disney = dr.gather(mi.Bool, materials.disney, row, active) if materials.any_disney else mi.Bool(False)
    return Material(color, opacity, metallic, alpha, surface.z, disney, surface.w > 0.5, emission * share)


def lookup_normal(materials: Materials, row: mi.UInt32, uv: mi.Point2f, active: mi.Bool) -> mi.Vector3f:
    """Normals of normal maps, in the axes of the texture's coordinates; +z where there is none. (N,) unit.

    One with a length of zero is +z as well.
    """
    stored = _textured(materials, materials.normal_texture, mi.Color3f(0.5, 0.5, 1), row, uv, active)
    normal = dr.fma(mi.Vector3f(stored), 2, -1)
    length2 = dr.squared_norm(normal)
    return dr.select(length2 > 0, normal * dr.rsqrt(at_least(length2, 1e-20)), mi.Vector3f(0, 0, 1))


def lookup_opacity(
    materials: Materials, row: mi.UInt32, uv: mi.Point2f, active: mi.Bool, corner: Corner | None = None
) -> mi.Float:
    """Opacity of each hit, in [0, 1]; what rays that may pass through surfaces ask for."""
    opacity = dr.gather(mi.Vector4f, materials.base, row, active).w
    if materials.textures is not None:
        opacity = _textured(materials, materials.opacity_texture, mi.Color3f(opacity), row, uv, active).x
    if materials.vertex_colors is not None and corner is not None:
        opacity = opacity * vertex_colors.lookup(materials.vertex_colors, row, corner, active)[1]
    return opacity


def _textured(materials, column, constant, row, uv, active):
    """The constant, or the texture's colour on lanes whose row names one."""
    texture = dr.gather(mi.UInt32, column, row, active)
    has = active & (texture != NO_TEXTURE)
    color, _ = textures.lookup(materials.textures, texture, uv, has)
    return dr.select(has, color, constant)
