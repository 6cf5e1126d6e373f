"""Our texture lookup agrees with Mitsuba's, and wrong pictures are refused by name."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError

HALF = 1e-3  # half precision has 11 bits: 2^-11 of values up to 1, twice


def load(texture, parameter="reflectance", bsdf="diffuse"):
    from ddgi.scene.load import load_scene

    return load_scene(
        {"type": "scene", "wall": {"type": "rectangle", "bsdf": {"type": bsdf, parameter: texture}}}
    )


def interaction(uv):
    si = dr.zeros(mi.SurfaceInteraction3f, uv.shape[1])
    si.uv = mi.Point2f(np.float32(uv))
    return si


def look_up(scene, uv):
    from ddgi.trace.textures import lookup

    row = scene.shapes["wall"]
    index = dr.gather(mi.UInt32, scene.materials.base_texture, row)
    return lookup(scene.materials.textures, index, mi.Point2f(np.float32(uv)), mi.Bool(True))


@pytest.mark.parametrize("wrap", ["repeat", "clamp", "mirror"])
@pytest.mark.parametrize("filter_type", ["bilinear", "nearest"])
@pytest.mark.parametrize("kind", [np.float32, np.uint8])
def test_lookup_agrees_with_mitsuba(wrap, filter_type, kind):
    rng = np.random.default_rng(3)
    texels = rng.random((5, 7, 3)).astype(np.float32)
    if kind is np.uint8:
        texels = (texels * 255).astype(np.uint8)
    turned = mi.ScalarTransform4f().translate([0.1, 0.2, 0]).rotate([0, 0, 1], 30).scale([2.0, 3.0, 1.0])
    description = {
        "type": "bitmap",
        "bitmap": mi.Bitmap(texels),
        "wrap_mode": wrap,
        "filter_type": filter_type,
        "to_uv": turned,
    }
    uv = rng.uniform(-3, 4, (2, 4000))
    color, alpha = look_up(load(description), uv)
    expected = np.array(mi.load_dict(description).eval(interaction(uv)))
    # The nearest texel may differ where rounding puts a coordinate on the other side of an edge.
    off = np.abs(np.array(color) - expected).max(0) > HALF
    assert off.mean() <= (0.001 if filter_type == "nearest" else 0.0)
    np.testing.assert_array_equal(np.array(alpha), 1)


def test_a_file_in_many_ways(tmp_path):
    """Files keep v = 0 where Mitsuba has it, grey becomes RGB, and one file is packed once."""
    from ddgi.scene.load import load_scene

    ramp = (np.arange(48).reshape(6, 8, 1) * 5).astype(np.uint8)
    mi.Bitmap(ramp).write(str(tmp_path / "ramp.png"))
    texture = {"type": "bitmap", "filename": str(tmp_path / "ramp.png")}
    diffuse = {"type": "diffuse", "reflectance": texture}
    wall = {"type": "rectangle", "bsdf": diffuse}
    floor = {"type": "rectangle", "bsdf": {"type": "twosided", "nested": diffuse}}
    scene = load_scene({"type": "scene", "wall": wall, "floor": floor})
    assert dr.width(scene.materials.textures.width) == 1
    uv = np.random.default_rng(0).random((2, 500))
    color, _ = look_up(scene, uv)
    expected = np.array(mi.load_dict(texture).eval(interaction(uv)))
    np.testing.assert_allclose(
        np.array(color), np.broadcast_to(expected.reshape(-1, 500), (3, 500)), atol=HALF
    )


def test_checkerboard_is_exact_also_when_scaled():
    board = {"type": "checkerboard", "color0": 0.75, "color1": 0.25}
    board["to_uv"] = mi.ScalarTransform4f().scale([20.0, 80.0, 1.0])
    uv = np.random.default_rng(0).random((2, 1000)) * 0.999 + 0.0004
    color, _ = look_up(load(board), uv)
    expected = np.array(mi.load_dict(board).eval(interaction(uv))).reshape(-1, 1000)
    assert (np.abs(np.array(color)[0] - expected[0]) > HALF).mean() < 0.005  # rounding at the edges


def test_lanes_without_a_texture_read_nothing():
    from ddgi.trace.materials import NO_TEXTURE
    from ddgi.trace.textures import lookup

    scene = load({"type": "bitmap", "bitmap": mi.Bitmap(np.full((2, 2, 3), 0.5, np.float32))})
    index = mi.UInt32([0, NO_TEXTURE, 0])
    nan = float("nan")
    color, _ = lookup(
        scene.materials.textures, index, mi.Point2f([nan, 0.5, 0.5], 0.5), mi.Bool([True, True, False])
    )
    color = np.array(color)
    assert (color[:, 1:] == 0).all()


@pytest.mark.parametrize("value", [-0.5, np.nan, np.inf])
def test_bad_texels_are_refused_by_name(tmp_path, value):
    texels = np.full((4, 4, 3), 0.5, np.float32)
    texels[1, 2] = value
    path = tmp_path / "bad.exr"
    mi.Bitmap(texels).write(str(path))
    with pytest.raises(SceneError, match=r"value is (negative|not finite)") as caught:
        load({"type": "bitmap", "id": "spoiled", "filename": str(path), "raw": True})
    assert "bitmap" in str(caught.value)
    assert "bad.exr" in str(caught.value)


def test_a_missing_file_is_named():
    with pytest.raises(SceneError, match=r"bitmap.*file not found: nowhere\.png"):
        load({"type": "bitmap", "filename": "nowhere.png"})
