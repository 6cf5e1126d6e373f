"""The GGX lobe: reciprocal, never more than it receives, and the same microfacets as Mitsuba's."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.lighting import brdf
from probing import points, sphere_points, surface_at


def hemisphere(count, seed):
    v = sphere_points(count, seed)
    v[:, 2] = np.abs(v[:, 2]) + 1e-3
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def ggx(viewer, light, **material):
    """(N,) of grey materials."""
    light = np.broadcast_to(light, viewer.shape)
    surface = surface_at(np.zeros_like(viewer), (0, 0, 1), viewer=viewer, **material)
    return np.array(brdf.ggx(surface, mi.Vector3f(points(light))), np.float64)[0]


MATERIALS = [{"metallic": 1.0, "base": 1.0, "alpha": a} for a in (0.05, 0.2, 0.5, 1.0)] + [
    {"metallic": 0.0, "specular": f, "base": 0.5, "alpha": a} for f in (0.04, 1.0) for a in (0.1, 0.6)
]


@pytest.mark.parametrize("material", MATERIALS, ids=str)
def test_reciprocal(material):
    a, b = hemisphere(2000, 1), hemisphere(2000, 2)
    assert np.allclose(ggx(a, b, **material), ggx(b, a, **material), rtol=1e-3, atol=1e-7)


@pytest.mark.parametrize("material", MATERIALS, ids=str)
def test_white_furnace(material):
    """Under even light of 1 no view sees more than 1: the integral of f cos over all light directions."""
    # Half vectors, denser near the pole where narrow lobes live: tan(theta_h) = alpha t / (1 - t).
    n = 256
    t, phi = (
        a.ravel()
        for a in np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n * 2 * np.pi, indexing="ij")
    )
    tan = material["alpha"] * t / (1 - t)
    cos_h = 1 / np.sqrt(1 + tan * tan)
    sin_h = cos_h * tan
    half = np.stack([sin_h * np.cos(phi), sin_h * np.sin(phi), cos_h], 1)
    dtheta = material["alpha"] / (1 - t) ** 2 * cos_h**2  # d theta / d t
    solid = sin_h * dtheta * (1 / n) * (2 * np.pi / n)
    for degrees in (0, 30, 60, 80, 87):
        view = np.array([np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))])
        v_h = half @ view
        light = 2 * v_h[:, None] * half - view
        up = (light[:, 2] > 1e-4) & (v_h > 0)
        f = ggx(np.tile(view, (up.sum(), 1)), light[up], **material)
        energy = (f * light[up, 2] * 4 * v_h[up] * solid[up]).sum()  # d light = 4 (v.h) d half
        assert energy <= 1.01  # quadrature: below 1 %
        if degrees == 0 and material["metallic"] == 1 and material["alpha"] == 0.05:
            # Little is masked, and alpha^2 / (1 + alpha^2) = 0.25 % of the half vectors lie beyond 45
            # degrees and send the light below the surface: nearly all must come back.
            assert energy >= 0.98


def test_flat_mirror_has_its_fresnel_reflectance():
    """A narrow lobe seen straight on returns F0 of the light: 4 % for a dielectric."""
    material = {"metallic": 0.0, "specular": 0.04, "base": 0.5}
    wide, narrow = (
        ggx(np.array([[0, 0, 1.0]]), np.array([0, 0, 1.0]), alpha=a, **material)[0] for a in (0.4, 0.2)
    )
    # At the peak f = F D / 4 with D = 1 / (pi alpha^2).
    assert narrow == pytest.approx(0.04 / (4 * np.pi * 0.2**2), rel=1e-3)
    assert wide == pytest.approx(0.04 / (4 * np.pi * 0.4**2), rel=1e-3)


@pytest.mark.parametrize("alpha", [0.1, 0.3, 0.8])
def test_microfacets_are_mitsubas(alpha):
    """D and G1 from Mitsuba, joined by the height-correlated G2 = 1 / (1 + L(v) + L(l)) (Heitz 2014).

    Of the distribution itself and not of `roughconductor`, whose evaluation aborts LLVM on AVX-512.
    """
    a, b = hemisphere(1000, 3), hemisphere(1000, 4)
    half = (a + b) / np.linalg.norm(a + b, axis=1, keepdims=True)
    ggx_distribution = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, alpha, False)
    h = mi.Vector3f(points(half))
    d = np.array(ggx_distribution.eval(h), np.float64)
    shadow_a, shadow_b = (
        1 / np.array(ggx_distribution.smith_g1(mi.Vector3f(points(v)), h), np.float64) - 1 for v in (a, b)
    )
    theirs = d / (1 + shadow_a + shadow_b) / (4 * a[:, 2] * b[:, 2])
    ours = ggx(a, b, metallic=1.0, base=1.0, alpha=alpha)  # F0 = 1: no Fresnel
    seen = (a[:, 2] > 0.05) & (b[:, 2] > 0.05) & (theirs > 1e-5)
    assert seen.sum() > 500
    assert np.allclose(ours[seen], theirs[seen], rtol=5e-3)


def test_black_material_reflects_nothing():
    a, b = hemisphere(100, 5), hemisphere(100, 6)
    assert (ggx(a, b, metallic=1.0, base=0.0, alpha=0.2) == 0).all()
    assert (ggx(a, b, metallic=0.0, specular=0.0, base=0.9, alpha=0.2) == 0).all()


def test_grazing_and_opposite_directions_stay_numbers():
    view = np.array([[1, 0, 0], [1, 0, 1e-7], [0, 0, 1], [0, 0, -1]], float)
    view /= np.linalg.norm(view, axis=1, keepdims=True)
    for light in ([0, 0, 1.0], [-1.0, 0, 0], [1.0, 0, 0], [0, 0, -1.0]):
        assert np.isfinite(ggx(view, np.array(light), metallic=1.0, alpha=0.05)).all()


@pytest.mark.parametrize("disney", [False, True])
def test_metals_have_no_matt_part(disney):
    metal = surface_at(np.zeros((1, 3)), (0, 0, 1), base=0.8, metallic=1.0, disney=disney)
    assert np.allclose(np.array(brdf.matt(metal, mi.Vector3f(0, 0, 1))), 0)
    assert np.allclose(np.array(brdf.matt_under_even_light(metal)), 0)


def test_lamberts_matt_part():
    surface = surface_at(np.zeros((1, 3)), (0, 0, 1), base=0.8)
    assert np.allclose(np.array(brdf.matt(surface, mi.Vector3f(0.6, 0, 0.8))), 0.8 / np.pi)
    assert np.allclose(np.array(brdf.matt_under_even_light(surface)), 0.8 / np.pi)


@pytest.mark.parametrize("roughness", [0.2, 0.6, 1.0])
def test_disneys_matt_part_is_mitsubas(roughness):
    """`principled` without its gloss (a specular of 0 leaves none)."""
    view, light = hemisphere(2000, 1), hemisphere(2000, 2)
    surface = surface_at(
        np.zeros_like(view), (0, 0, 1), viewer=view, base=0.7, alpha=roughness**2, disney=True
    )
    ours = np.array(brdf.matt(surface, mi.Vector3f(points(light))))[0]
    plugin = mi.load_dict(
        {
            "type": "principled",
            "base_color": {"type": "rgb", "value": 0.7},
            "roughness": roughness,
            "specular": 0.0,
        }
    )
    si = dr.zeros(mi.SurfaceInteraction3f, len(view))
    si.wi = mi.Vector3f(points(view))
    theirs = np.array(plugin.eval(mi.BSDFContext(), si, mi.Vector3f(points(light))))[0] / light[:, 2]
    np.testing.assert_allclose(ours, theirs, rtol=2e-3)
    assert ours.std() > 0.02 * ours.mean(), "it is not Lambert's"
