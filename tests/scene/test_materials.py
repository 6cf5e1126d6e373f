"""Rows of the material table against what the BSDFs are known to be."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError


def load(bsdf, **shape):
    from ddgi.scene.load import load_scene

    description = {"type": "scene", "wall": {"type": "rectangle", "bsdf": bsdf, **shape}}
    description["other"] = {"type": "sphere"}
    return load_scene(description)


def row(bsdf, **shape):
    """base r g b, opacity; metallic, alpha, specular, double-sided; the scene."""
    scene = load(bsdf, **shape)
    number = scene.shapes["wall"]
    base = np.array(scene.materials.base).reshape(-1, 4)[number]
    surface = np.array(scene.materials.surface).reshape(-1, 4)[number]
    return base, surface, scene


def rgb(*value):
    return {"type": "rgb", "value": list(value)}


DIFFUSE = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.2, 0.4, 0.6]}}


def test_diffuse():
    base, surface, scene = row(DIFFUSE)
    np.testing.assert_allclose(base, [0.2, 0.4, 0.6, 1], atol=1e-6)
    np.testing.assert_allclose(surface, [0, 1, 0, 0])
    assert not scene.materials.any_specular
    assert not scene.materials.any_opacity
    assert scene.materials.any_single_sided
    assert scene.materials.textures is None


def test_twosided_is_double_sided_through_whatever_it_holds():
    flat = {"type": "bitmap", "raw": True, "bitmap": mi.Bitmap(np.full((2, 2, 3), 0.5, np.float32))}
    for bsdf in (DIFFUSE, {"type": "normalmap", "normalmap": flat, "nested": DIFFUSE}):
        base, surface, _ = row({"type": "twosided", "nested": bsdf})
        np.testing.assert_allclose(base, [0.2, 0.4, 0.6, 1], atol=1e-6)
        assert surface[3] == 1


def test_plastics():
    base, surface, scene = row({"type": "plastic", "diffuse_reflectance": rgb(0.1, 0.2, 0.3)})
    # What enters and comes out again: (1 - 0.09) of it by their index of refraction, 1.49.
    np.testing.assert_allclose(base[:3], 0.91 * np.array([0.1, 0.2, 0.3]), atol=1e-3)
    np.testing.assert_allclose(surface[:3], [0, 0.001, 0.0387], atol=2e-3)
    assert scene.materials.any_specular
    _, surface, _ = row({"type": "roughplastic", "alpha": 0.3, "int_ior": 2.0, "ext_ior": 1.0})
    np.testing.assert_allclose(surface[:3], [0, 0.3, 1 / 9], atol=1e-5)


def test_principled():
    description = {"type": "principled", "base_color": rgb(0.8, 0.4, 0.2), "metallic": 0.7, "roughness": 0.5}
    base, surface, _ = row({**description, "specular": 0.25, "spec_trans": 0.5})
    np.testing.assert_allclose(base, [0.4, 0.2, 0.1, 1], atol=1e-6)
    np.testing.assert_allclose(surface, [0.7, 0.25, 0.02, 0], atol=1e-5)
    _, surface, _ = row({**description, "eta": 1.5})
    assert surface[2] == pytest.approx(0.04, abs=1e-4)


def test_plastics_darken_what_they_keep_inside():
    """`nonlinear` plastic, diffuse Fresnel reflectances 0.0918 outside and 0.5963 inside (index 1.5):

    x (1 - 0.0918)(1 - 0.5963) / (1 - 0.5963 x), of a colour as of a picture's texels.
    """
    expected = lambda x: x * (1 - 0.0918) * (1 - 0.5963) / (1 - 0.5963 * x)  # noqa: E731
    plain = {"type": "plastic", "int_ior": 1.5, "ext_ior": 1.0, "nonlinear": True}
    base, _, _ = row({**plain, "diffuse_reflectance": rgb(0.1, 0.5, 0.9)})
    np.testing.assert_allclose(base[:3], expected(np.array([0.1, 0.5, 0.9])), atol=2e-3)
    flat = {"type": "bitmap", "raw": True, "bitmap": mi.Bitmap(np.full((2, 2, 3), 0.5, np.float32))}
    _, _, scene = row({**plain, "diffuse_reflectance": flat})
    texels = np.array(scene.materials.textures.texels, np.float32).reshape(-1, 4)
    np.testing.assert_allclose(texels[:, :3], expected(0.5), atol=2e-3)


def test_a_coat_of_less_gloss():
    _, surface, _ = row(
        {"type": "plastic", "int_ior": 1.5, "ext_ior": 1.0, "specular_reflectance": rgb(0.5, 0.5, 0.5)}
    )
    assert surface[2] == pytest.approx(0.02, abs=1e-4)


def test_conductor_is_its_hemispherical_reflectance():
    """A metal that reflects everything has base 1; real ones lie near their known reflectance."""
    base, surface, _ = row({"type": "conductor", "material": "none"})
    np.testing.assert_allclose(base, 1, atol=1e-5)
    assert surface[0] == 1
    base, surface, _ = row(
        {"type": "conductor", "material": "none", "specular_reflectance": rgb(0.5, 0.25, 1)}
    )
    np.testing.assert_allclose(base[:3], [0.5, 0.25, 1], atol=1e-4)
    base, surface, _ = row({"type": "roughconductor", "material": "Au", "alpha": 0.2})
    assert base[0] > base[1] > base[2] > 0.2
    assert base[0] <= 1
    assert surface[1] == pytest.approx(0.2)
    base, surface, _ = row({"type": "roughconductor", "alpha_u": 0.1, "alpha_v": 0.4})
    assert surface[1] == pytest.approx(0.2)


def test_conductor_keeps_the_texture_that_scales_it():
    board = {"type": "checkerboard", "color0": 0.8, "color1": 0.2}
    plain, _, _ = row({"type": "conductor", "material": "Au"})
    _, _, scene = row({"type": "conductor", "material": "Au", "specular_reflectance": board})
    texels = np.array(scene.materials.textures.texels, np.float32).reshape(-1, 4)
    np.testing.assert_allclose(texels[:, :3].max(0), 0.8 * plain[:3], rtol=0.01)
    np.testing.assert_allclose(texels[:, :3].min(0), 0.2 * plain[:3], rtol=0.01)


def test_mask_constant_and_textured():
    base, _, scene = row({"type": "mask", "opacity": 0.3, "nested": DIFFUSE})
    np.testing.assert_allclose(base, [0.2, 0.4, 0.6, 0.3], atol=1e-6)
    assert scene.materials.any_opacity
    cut = np.zeros((2, 2, 1), np.float32)
    cut[0] = 1
    picture = {"type": "bitmap", "raw": True, "bitmap": mi.Bitmap(cut)}
    base, _, scene = row({"type": "mask", "opacity": picture, "nested": DIFFUSE})
    assert scene.materials.any_opacity
    assert np.array(scene.materials.opacity_texture)[scene.shapes["wall"]] == 0
    assert base[3] == pytest.approx(0.5)


def test_blends_mix_and_a_blend_with_nothing_is_a_mask():
    black = {"type": "diffuse", "reflectance": rgb(0, 0, 0)}
    base, _, _ = row({"type": "blendbsdf", "weight": 0.25, "a": DIFFUSE, "b": black})
    np.testing.assert_allclose(base, [0.15, 0.3, 0.45, 1], atol=1e-6)
    base, _, _ = row({"type": "blendbsdf", "weight": 0.25, "a": DIFFUSE, "b": {"type": "null"}})
    np.testing.assert_allclose(base, [0.2, 0.4, 0.6, 0.75], atol=1e-6)


@pytest.mark.parametrize("plugin", ["dielectric", "thindielectric", "roughdielectric", "null"])
def test_clear_shapes_are_not_traced(plugin):
    scene = load({"type": plugin})
    assert "wall" not in scene.shapes
    assert len(scene.mi_scene.shapes()) == 1
    assert any("1 clear shape" in note and '"wall"' in note for note in scene.notes)


def test_a_clear_shape_that_shines_stays():
    base, _, scene = row({"type": "null"}, emitter={"type": "area", "radiance": 2.0})
    assert base[3] == 1
    assert scene.lights.area_count == 1


def test_what_has_no_rule_is_measured():
    base, _, scene = row({"type": "pplastic", "diffuse_reflectance": rgb(0.5, 0.5, 0.5)})
    assert 0.3 < base[0] < 0.7  # part of the light is lost inside, part comes back from the coat
    assert any("PolarizedPlastic" in note for note in scene.notes)


def test_measured_reflectance_of_a_lambertian_is_its_albedo():
    from ddgi.scene.reflectance import hemispherical_reflectance

    np.testing.assert_allclose(hemispherical_reflectance(mi.load_dict(DIFFUSE)), [0.2, 0.4, 0.6], rtol=1e-3)


def test_materials_given_as_objects_count_as_well():
    base, surface, _ = row(mi.load_dict({"type": "twosided", "nested": DIFFUSE}))
    np.testing.assert_allclose(base, [0.2, 0.4, 0.6, 1], atol=1e-6)
    assert surface[3] == 1


def test_meshes_that_share_a_material_keep_their_own_vertex_colours(tmp_path):
    from ddgi.scene.load import load_scene

    header = "ply\nformat ascii 1.0\nelement vertex 3\n" + "".join(f"property float {c}\n" for c in "xyzrgb")
    header += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    shared = {
        "type": "diffuse",
        "id": "shared",
        "reflectance": {"type": "mesh_attribute", "name": "vertex_color"},
    }
    description = {"type": "scene", "shared": shared}
    for name, shade in (("dark", 0.1), ("light", 0.7)):
        path = tmp_path / f"{name}.ply"
        colours = [(shade, 0, 1), (shade, 0.3, 1), (shade, 0.6, 1)]
        places = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
        rows = [" ".join(map(str, p + c)) for p, c in zip(places, colours, strict=True)]
        path.write_text(header + "\n".join(rows) + "\n3 0 1 2\n")
        description[name] = {"type": "ply", "filename": str(path), "bsdf": {"type": "ref", "id": "shared"}}
    scene = load_scene(description)
    colors = scene.materials.vertex_colors
    corners, values = np.array(colors.corners).reshape(-1, 3), np.array(colors.values).reshape(-1, 4)
    for name, shade in (("dark", 0.1), ("light", 0.7)):
        face = np.array(colors.first)[scene.shapes[name]]
        expected = [[shade, 0, 1, 1], [shade, 0.3, 1, 1], [shade, 0.6, 1, 1]]
        np.testing.assert_allclose(values[corners[face]], expected, atol=1e-6)


def test_vertex_colours_of_objects_have_no_known_name():
    from ddgi.scene.load import load_scene

    bsdf = mi.load_dict(
        {"type": "diffuse", "reflectance": {"type": "mesh_attribute", "name": "vertex_color"}}
    )
    meshes = {}
    for name, shade in (("dark", 0.1), ("light", 0.9)):
        props = mi.Properties()
        props["bsdf"] = bsdf
        mesh = mi.Mesh(name, 3, 1, props=props)
        mesh.add_attribute("vertex_color", 3, np.full(9, shade, np.float32))
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = mi.Float([0, 0, 0, 1, 0, 0, 0, 1, 0])
        parameters["faces"] = mi.UInt32([0, 1, 2])
        parameters.update()
        meshes[name] = mesh
    scene = load_scene({"type": "scene", **meshes})
    assert any("mesh attribute" in note for note in scene.notes)
    # Without its description the attribute's name is unknown: mid-grey, said in the note.
    base = np.array(scene.materials.base).reshape(-1, 4)
    assert base[scene.shapes["dark"], 0] == pytest.approx(0.5)


def test_rows_are_where_hits_look_for_them():
    """Also for shapes inside an instanced group."""
    from ddgi.scene.load import load_scene

    scene = load_scene({
        "type": "scene",
        "group": {"type": "shapegroup", "inner": {"type": "sphere", "bsdf": DIFFUSE}, "pane": {
            "type": "rectangle", "bsdf": {"type": "dielectric"}}},
        "copy": {"type": "instance", "to_world": mi.ScalarTransform4f().translate([3, 0, 0]),
                 "shapes": {"type": "ref", "id": "group"}},
        "plain": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": 0.9}},
    })  # fmt: skip
    base = np.array(scene.materials.base).reshape(-1, 4)
    for x, expected in ((3.0, [0.2, 0.4, 0.6, 1]), (0.0, [0.9, 0.9, 0.9, 1])):
        si = scene.mi_scene.ray_intersect(mi.Ray3f([x, 0.1, 5], [0, 0, -1]))
        number = int(dr.reinterpret_array(mi.UInt32, si.shape)[0])
        np.testing.assert_allclose(base[number], expected, atol=1e-6)
    assert base.shape[0] > scene.shapes["inner"] > 0


def test_no_bsdf_means_what_mitsuba_means():
    scene = load({"type": "twosided", "nested": DIFFUSE})
    base = np.array(scene.materials.base).reshape(-1, 4)[scene.shapes["other"]]
    np.testing.assert_allclose(base, [0.5, 0.5, 0.5, 1], atol=1e-6)


def test_a_misspelt_parameter_is_named():
    with pytest.raises(SceneError, match="reflectnce"):
        load({"type": "diffuse", "reflectnce": 0.5})
