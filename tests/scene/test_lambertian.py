"""Lambertian everywhere: our table and Mitsuba's parsed scene say the same of every point."""

from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError
from ddgi.trace import disney
from ddgi.trace.albedo import rough_share

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "scenes"
SAMPLES = 1024
TOLERANCE = 5 * 0.5 / np.sqrt(SAMPLES)
"""Five standard errors of a mean of values in [0, 1], which deviate by at most 1/2 each."""


def load(source, materials="diffuse", **keywords):
    from ddgi.scene.load import load_scene

    return load_scene(source, materials=materials, **keywords)


def built(scene):
    """As a path tracer renders it."""
    return mi.parser.instantiate(mi.parser.ParserConfig(mi.variant()), scene.source)


def rgb(*value):
    return {"type": "rgb", "value": list(value)}


def picture(channels, seed=1, **keywords):
    texels = np.random.default_rng(seed).random((5, 4, channels)).astype(np.float32)
    return {"type": "bitmap", "raw": True, "bitmap": mi.Bitmap(texels), **keywords}


def cut(*rows):
    values = np.array(rows, np.float32)[..., None]
    return {"type": "bitmap", "raw": True, "filter_type": "nearest", "bitmap": mi.Bitmap(values)}


DIFFUSE = {"type": "diffuse", "reflectance": rgb(0.2, 0.4, 0.6)}
METAL = {"type": "roughconductor", "material": "Au", "alpha": 0.2}

BSDFS = {
    "diffuse": DIFFUSE,
    "conductor": METAL,
    "plastic": {"type": "plastic", "diffuse_reflectance": rgb(0.1, 0.5, 0.3)},
    "principled": {"type": "principled", "base_color": rgb(0.8, 0.4, 0.2), "metallic": 0.7, "roughness": 0.3},
    "clear-plastic": {"type": "principled", "base_color": rgb(0.8, 0.4, 0.2), "spec_trans": 0.5},
    "measured": {"type": "pplastic", "diffuse_reflectance": rgb(0.5, 0.5, 0.5)},
    "blend": {"type": "blendbsdf", "weight": 0.25, "a": DIFFUSE, "b": METAL},
    "mask": {"type": "mask", "opacity": 0.3, "nested": DIFFUSE},
    "twosided-metal": {"type": "twosided", "nested": METAL},
    "masked-twosided": {"type": "mask", "opacity": 0.6, "nested": {"type": "twosided", "nested": DIFFUSE}},
}


def textured():
    """Made late: bitmaps need a backend."""
    turned = mi.ScalarTransform3f(np.array([[2.0, 0.5, 0.1], [-0.3, 3.0, 0.2], [0, 0, 1]]))
    return {
        "bitmap": {"type": "diffuse", "reflectance": picture(3)},
        "turned": {"type": "diffuse", "reflectance": picture(3, to_uv=turned, wrap_mode="mirror")},
        "clamped": {"type": "diffuse", "reflectance": picture(3, to_uv=turned, wrap_mode="clamp")},
        "nearest": {"type": "plastic", "diffuse_reflectance": picture(3, filter_type="nearest")},
        "grey": {"type": "twosided", "nested": {"type": "diffuse", "reflectance": picture(1)}},
        "metal": {"type": "conductor", "material": "Au", "specular_reflectance": picture(3)},
        "holes": {"type": "mask", "opacity": cut([1, 0], [0, 1]), "nested": METAL},
        "soft-holes": {
            "type": "mask",
            "opacity": picture(1),
            "nested": {"type": "twosided", "nested": METAL},
        },
        "one-texel": {"type": "mask", "opacity": cut([0.4]), "nested": DIFFUSE},
    }


def ours(scene, origin, direction):
    """(N, 3) share of light reflected and (N,) share let through, of the first surface met; and the table's look."""
    from ddgi.trace.materials import lookup

    si = scene.mi_scene.ray_intersect(mi.Ray3f(mi.Point3f(origin.T), mi.Vector3f(direction.T)))
    valid = si.is_valid()
    material = lookup(scene.materials, dr.reinterpret_array(mi.UInt32, si.shape), si.uv, valid)
    front = dr.dot(si.sh_frame.n, mi.Vector3f(direction.T)) < 0
    lit = valid & (front | material.double_sided)
    color = dr.select(lit, material.base * material.opacity, 0)
    through = dr.select(valid, 1 - material.opacity, 1)
    return np.array(color).T, np.array(through), np.array(si.t)


def theirs(mi_scene, origin, direction):
    """The same of Mitsuba's scene, by sampling its BSDFs."""
    count = len(origin)
    repeated = [np.repeat(a, SAMPLES, 0).T.astype(np.float32) for a in (origin, direction)]
    si = mi_scene.ray_intersect(mi.Ray3f(mi.Point3f(repeated[0]), mi.Vector3f(repeated[1])))
    random = mi.PCG32(count * SAMPLES)
    u = random.next_float32()
    v = mi.Point2f(random.next_float32(), random.next_float32())
    sample, weight = si.bsdf().sample(mi.BSDFContext(), si, u, v, si.is_valid())
    null = mi.has_flag(sample.sampled_type, mi.BSDFFlags.Null)
    weight = dr.select(si.is_valid() & (sample.pdf > 0), weight, 0)
    back = np.array(dr.select(null, 0, weight)).T.reshape(count, SAMPLES, 3).mean(1)
    through = np.array(dr.select(si.is_valid(), dr.select(null, weight.x, 0), 1))
    return back, through.reshape(count, SAMPLES).mean(1), np.array(si.t).reshape(count, SAMPLES)[:, 0]


def rays(count=48, z=5.0, half=1.0, seed=0):
    """Down (z > 0) or up at random points of the square around the origin."""
    random = np.random.default_rng(seed)
    origin = np.append(random.uniform(-half, half, (count, 2)), np.full((count, 1), z), axis=1)
    direction = np.tile([0.0, 0.0, -np.sign(z)], (count, 1))
    return np.float32(origin), np.float32(direction)


def check_same(scene, origin, direction):
    expected, through, distance = ours(scene, origin, direction)
    color, passed, met = theirs(built(scene), origin, direction)
    np.testing.assert_allclose(met, distance, rtol=1e-4)
    np.testing.assert_allclose(color, expected, atol=TOLERANCE)
    np.testing.assert_allclose(passed, through, atol=TOLERANCE)
    return expected, through


def wall(bsdf, **keywords):
    return {"type": "scene", "wall": {"type": "rectangle", "bsdf": bsdf}, **keywords}


@pytest.mark.parametrize("name", [*BSDFS, "bitmap", "turned", "clamped", "nearest", "grey", "metal", "holes",
                                  "soft-holes", "one-texel"])  # fmt: skip
def test_both_sides_say_the_same_from_front_and_back(name):
    bsdf = {**BSDFS, **textured()}[name]
    scene = load(wall(bsdf))
    assert not scene.materials.any_specular
    surface = np.array(scene.materials.surface).reshape(-1, 4)[scene.shapes["wall"]]
    np.testing.assert_array_equal(surface[:3], [0, 1, 0])
    front, _ = check_same(scene, *rays())
    back, _ = check_same(scene, *rays(z=-5.0))
    assert front.max() > 0
    double_sided = "twosided" in str(bsdf)
    assert surface[3] == double_sided
    assert (back.max() > 0) == double_sided


@pytest.mark.parametrize("name", BSDFS)
def test_albedo_opacity_and_sides_are_those_of_the_full_materials(name):
    full, diffuse = (load(wall(BSDFS[name]), m).materials for m in ("full", "diffuse"))
    surface = np.array(full.surface).reshape(-1, 4)
    # Of their base colour rough metals keep a share, and Disney's matt part sends back more or less.
    matt = np.where(np.array(full.disney), disney.even(np.sqrt(surface[:, 1])), 1)
    kept = np.ones((len(surface), 4))
    kept[:, :3] = (matt + surface[:, 0] * (rough_share(surface[:, 1]) - matt))[:, None]
    np.testing.assert_allclose(diffuse.base, np.array(full.base) * kept.ravel(), atol=1e-6)
    assert not np.array(diffuse.disney).any()
    np.testing.assert_array_equal(surface[:, 3], np.array(diffuse.surface)[3::4])


def test_masks_keep_their_holes():
    scene = load(wall({"type": "mask", "opacity": cut([1, 0], [0, 1]), "nested": METAL}))
    _, through = check_same(scene, *rays())
    assert set(np.round(through)) == {0, 1}


@pytest.mark.parametrize("plugin", ["dielectric", "thindielectric", "roughdielectric", "null"])
def test_clear_shapes_are_gone_on_both_sides(plugin):
    ball = {
        "type": "sphere",
        "to_world": mi.ScalarTransform4f().translate([0, 0, 2]),
        "bsdf": {"type": plugin},
    }
    scene = load(wall(DIFFUSE, ball=ball))
    assert [len(s.shapes()) for s in (scene.mi_scene, built(scene))] == [1, 1]
    check_same(scene, *rays())


def test_a_clear_shape_that_shines_is_a_black_lamp():
    scene = load(
        {
            "type": "scene",
            "wall": {
                "type": "rectangle",
                "bsdf": {"type": "null"},
                "emitter": {"type": "area", "radiance": 2.0},
            },
        }
    )
    front, through = check_same(scene, *rays())
    assert front.max() == through.max() == 0
    assert len(built(scene).emitters()) == 1


def group(glass_only=False):
    """An instanced group of a metal and a glass rectangle; a floor below."""
    above = mi.ScalarTransform4f().translate([0, 0, 1])
    inner = {"pane": {"type": "rectangle", "to_world": above, "bsdf": {"type": "dielectric"}}}
    if not glass_only:
        inner["metal"] = {"type": "rectangle", "bsdf": {"type": "twosided", "nested": METAL}}
    floor = mi.ScalarTransform4f().translate([0, 0, -1]).scale(3)
    return {
        "type": "scene",
        "group": {"type": "shapegroup", **inner},
        "copy": {
            "type": "instance",
            "to_world": mi.ScalarTransform4f().translate([0.5, 0, 0]),
            "shapes": {"type": "ref", "id": "group"},
        },
        "floor": {"type": "rectangle", "to_world": floor, "bsdf": DIFFUSE},
    }


def test_shapes_of_an_instanced_group():
    scene = load(group())
    front, _ = check_same(scene, *rays(half=2.0, count=96))
    assert len(np.unique(front[:, 0].round(3))) == 2  # metal, floor


def test_an_instanced_group_of_glass_alone():
    scene = load(group(glass_only=True))
    check_same(scene, *rays(half=2.0))
    assert len(built(scene).shapes()) == 1


def test_a_group_that_came_as_an_object():
    description = group()
    description["group"] = description["copy"]["shapes"] = mi.load_dict(description["group"])
    scene = load(description)
    assert scene.materials.any_opacity  # the pane cannot be removed: rays pass it
    front, through = check_same(scene, *rays(half=2.0))
    assert front[through == 1].max() == 0
    assert (through == 1).any()


def test_shapes_and_materials_that_came_as_objects():
    ball = mi.load_dict({"type": "rectangle", "bsdf": METAL})
    scene = load({"type": "scene", "ball": ball})
    check_same(scene, *rays())
    scene = load(wall(mi.load_dict({"type": "twosided", "nested": METAL})))
    check_same(scene, *rays(z=-5.0))


def test_members_of_a_merge():
    pieces = {
        "glass": {"type": "cube", "bsdf": {"type": "dielectric"}},
        "metal": {"type": "cube", "to_world": mi.ScalarTransform4f().translate([0.7, 0, -3]), "bsdf": METAL},
    }
    scene = load({"type": "scene", "all": {"type": "merge", **pieces}})
    front, _ = check_same(scene, *rays())
    assert front.max() > 0


def test_shapes_that_share_a_material_share_the_new_one():
    shared = {"type": "conductor", "id": "shared"}
    refer = {"type": "ref", "id": "shared"}
    shapes = {f"ball-{i}": {"type": "sphere", "bsdf": refer} for i in range(3)}
    bsdfs = [s.bsdf() for s in built(load({"type": "scene", "shared": shared, **shapes})).shapes()]
    assert {b.class_name() for b in bsdfs} == {"SmoothDiffuse"}
    assert bsdfs[0] is bsdfs[1] is bsdfs[2]


def test_lamps_are_as_before():
    lamp = {"type": "area", "radiance": {"type": "ref", "id": "glow"}}
    description = {
        "type": "scene",
        "glow": picture(3),
        "lamp": {"type": "rectangle", "bsdf": METAL, "emitter": lamp},
        "bulb": {"type": "point", "intensity": 3.0},
    }
    from ddgi.trace.materials import NO_TEXTURE

    full, diffuse = (load(description, m) for m in ("full", "diffuse"))
    for scene in (full, diffuse):
        number = scene.shapes["lamp"]
        assert np.array(scene.materials.emission_texture)[number] != NO_TEXTURE
    np.testing.assert_array_equal(full.lights.delta.intensity, diffuse.lights.delta.intensity)
    origin, direction = rays()
    shine = []
    for scene in map(built, (full, diffuse)):
        assert len(scene.emitters()) == 2
        si = scene.ray_intersect(mi.Ray3f(mi.Point3f(origin.T), mi.Vector3f(direction.T)))
        shine.append(np.array(si.emitter(scene).eval(si)))
    np.testing.assert_array_equal(*shine)
    assert shine[0].max() > 0


def test_smooth_shading_stays():
    from ddgi.scene.mesh_keys import mesh

    corners = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]])
    normals = np.array([[-0.6, 0, 0.8], [0.6, 0, 0.8], [0, 0.6, 0.8]])
    shape = mesh("bent", corners, np.array([[0, 1, 2]]), bsdf=METAL, normals=normals)
    scene = load({"type": "scene", "bent": shape})
    ray = mi.Ray3f([0.3, 0, 5], [0, 0, -1])
    found = [s.ray_intersect(ray).sh_frame.n for s in (scene.mi_scene, built(scene))]
    np.testing.assert_array_equal(*found)
    assert abs(found[0].x[0]) > 0.1


def test_a_path_traced_picture_of_a_diffuse_scene_stays_as_it_is():
    """Of a scene that is Lambertian already, both modes give the same radiance."""
    pictures = [
        np.array(mi.render(built(load("cornell", m)), integrator=mi.load_dict({"type": "path"}), spp=4))
        for m in ("full", "diffuse")
    ]
    np.testing.assert_allclose(*pictures, rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("name", ["house", "courtyard"])
def test_built_in_scenes(name):
    """Their shapes are mesh objects."""
    scene = load(name)
    low, high = np.array(scene.bounds)
    random = np.random.default_rng(1)
    origin = random.uniform(low, high, (64, 3))
    direction = random.normal(size=(64, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    check_same(scene, np.float32(origin), np.float32(direction))


@pytest.mark.scenes
@pytest.mark.parametrize("name", ["veach-bidir", "staircase2", "classroom"])
def test_real_scenes(name):
    path = SHARED / name / "scene_mi3.xml"
    if not path.exists():
        pytest.skip(f"shared scenes are not at {SHARED}")
    scene = load(path)
    middle = np.mean(scene.bounds, 0)
    direction = np.random.default_rng(1).normal(size=(128, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    front, _ = check_same(scene, np.float32(np.tile(middle, (128, 1))), np.float32(direction))
    assert len(np.unique(front.round(3))) > 3


@pytest.mark.parametrize("value", ["matt", None, ""])
def test_other_modes_are_refused(value):
    with pytest.raises(SceneError, match="materials must be full or diffuse"):
        load("cornell", value)
