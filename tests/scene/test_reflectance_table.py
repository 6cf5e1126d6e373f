"""The albedo of each BSDF plugin in our table against what `bsdf.sample` sends back.

`measured` and `measured_polarized` need data files and are not here.
"""

import mitsuba as mi
import numpy as np
import pytest


def rgb(value):
    return {"type": "rgb", "value": [value, 0.6 * value, 0.3 * value]}


def plastic(plugin):
    return {"type": plugin, "diffuse_reflectance": rgb(0.7)}


def principled(**more):
    return {"type": "principled", "base_color": rgb(0.7), **more}


def around(plugin, **more):
    return {"type": plugin, "nested": DIFFUSE, **more}


DIFFUSE = {"type": "diffuse", "reflectance": rgb(0.7)}
DARKER = {"type": "diffuse", "reflectance": rgb(0.3)}
NOISE = 0.001  # of 32,768 points of a Halton sequence
FIT = 0.008  # of what rough facets and coats reflect (`trace/albedo.py`), noise included
UNREAD = 0.06  # sheen, a clear coat, the gloss of thin sheets
EXACT = {
    "diffuse": DIFFUSE,
    "twosided": around("twosided"),
    "pplastic": plastic("pplastic"),
    "mask": around("mask", opacity=0.4),
    "blendbsdf": {"type": "blendbsdf", "weight": 0.25, "a": DIFFUSE, "b": DARKER},
    "hair": {"type": "hair"},
}
FITTED = {
    "conductor": {"type": "conductor", "material": "Cu"},
    "plastic": plastic("plastic"),
    "plastic-nonlinear": {**plastic("plastic"), "nonlinear": True},
    "plastic-dense": {**plastic("plastic"), "int_ior": 1.9, "nonlinear": True},
    "principled-metal": principled(metallic=1.0, roughness=0.5),
    "principled-rough-metal": principled(metallic=1.0, roughness=1.0),
    "principled-half-metal": principled(metallic=0.5, roughness=0.7),
}
FITTED |= {
    f"roughconductor-{a}": {"type": "roughconductor", "material": "Cu", "alpha": a, "distribution": "ggx"}
    for a in (0.1, 0.3, 0.8)
}
FITTED |= {
    f"roughplastic-{a}-{nonlinear}": {**plastic("roughplastic"), "alpha": a, "distribution": "ggx", "nonlinear": nonlinear}
    for a in (0.05, 0.2, 0.6) for nonlinear in (False, True)
}  # fmt: skip
FITTED |= {f"principled-{r}": principled(roughness=r) for r in (0.0, 0.3, 0.6, 1.0)}
PARTLY_READ = {"principled-sheen": principled(sheen=1.0), "principled-clearcoat": principled(clearcoat=1.0)}
PARTLY_READ["principledthin"] = {"type": "principledthin", "base_color": rgb(0.7), "diff_trans": 0.6}
CLEAR = ("dielectric", "thindielectric", "roughdielectric", "null", "polarizer", "retarder", "circular")


def load(bsdf):
    from ddgi.scene.load import load_scene

    return load_scene({"type": "scene", "wall": {"type": "rectangle", "bsdf": bsdf}, "o": {"type": "sphere"}})


def both(bsdf):
    """(3,) what our table has, opacity included, and (3,) what is measured."""
    from ddgi.scene.reflectance import hemispherical_reflectance
    from ddgi.trace.albedo import albedo

    scene = load(bsdf)
    number = scene.shapes["wall"]
    base = np.array(scene.materials.base).reshape(-1, 4)[number]
    metallic, alpha, specular = np.array(scene.materials.surface).reshape(-1, 4)[number, :3]
    disney = bool(np.array(scene.materials.disney)[number])
    whole = [albedo(float(x), float(metallic), float(alpha), float(specular), disney) for x in base[:3]]
    return np.array(whole) * base[3], hemispherical_reflectance(mi.load_dict(bsdf))


@pytest.mark.parametrize("name", EXACT)
def test_albedo_is_the_reflectance(name):
    ours, measured = both(EXACT[name])
    np.testing.assert_allclose(ours, measured, atol=NOISE)


@pytest.mark.parametrize("name", FITTED)
def test_albedo_is_near_the_reflectance_of_what_shines(name):
    ours, measured = both(FITTED[name])
    np.testing.assert_allclose(ours, measured, atol=FIT)


@pytest.mark.parametrize("name", PARTLY_READ)
def test_albedo_lacks_what_is_not_read(name):
    ours, measured = both(PARTLY_READ[name])
    np.testing.assert_allclose(ours, measured, atol=UNREAD)


@pytest.mark.parametrize("name", ["normalmap", "bumpmap"])
def test_bumps_keep_the_albedo(name):
    flat = np.full((2, 2, 3), (0.5, 0.5, 1) if name == "normalmap" else 0.5, np.float32)
    picture = {"type": "bitmap", "raw": True, "bitmap": mi.Bitmap(flat)}
    key = "normalmap" if name == "normalmap" else "arbitrary"
    ours, measured = both(around(name, **{key: picture}))
    np.testing.assert_allclose(ours, measured, atol=NOISE)


@pytest.mark.parametrize("plugin", CLEAR)
def test_light_passes_what_is_clear(plugin):
    assert "wall" not in load({"type": plugin}).shapes
