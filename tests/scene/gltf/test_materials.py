"""Materials: the same linear numbers in the material table and in Mitsuba's BSDF, texel by texel."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi import load_scene
from ddgi.errors import SceneError
from ddgi.trace import disney
from gltf_writing import SQUARE_UV, Writer

QUARTERS = [[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]]
"""Red and green above blue and white."""
RED, GREEN, BLUE, WHITE = ([1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1])


def loaded(folder, material, uv=None, **options):
    writer = Writer()
    made = material(writer) if callable(material) else material
    writer.square(made, **({} if uv is None else {"uv": uv}))
    return load_scene(writer.glb(folder), sky=[1, 1, 1], **options)


def matt(writer, **pbr):
    return {"pbrMetallicRoughness": {"metallicFactor": 0, **pbr}}


def row(scene, name="square"):
    """Base colour and opacity; metallic, alpha, specular, double-sided."""
    number = scene.shapes[name]
    return (
        np.array(table).reshape(-1, 4)[number] for table in (scene.materials.base, scene.materials.surface)
    )


def seen(scene, points, from_behind=False):
    """(N, 3) albedo of our table at points of the unit square, seen along -z or +z."""
    from ddgi.sampling import clock

    points = np.array(points, np.float32)
    side = -1 if from_behind else 1
    origin = mi.Point3f(np.column_stack([points, np.full(len(points), side, np.float32)]).T)
    surface = scene.tracer.intersect(
        origin, mi.Vector3f(0, 0, -side), mi.Bool(True), time=clock(0, 0), stream=0
    )
    return np.where(surface.lit, surface.base, 0).T.reshape(-1, 3)


def mitsuba_hit(scene, x, y):
    """BSDF and interaction where the reference sees a point of the square from +z."""
    built = mi.parser.instantiate(mi.parser.ParserConfig(mi.variant()), scene.source)
    scene.built = built  # must outlive what points into it
    si = built.ray_intersect(mi.Ray3f(mi.Point3f(x, y, 1), mi.Vector3f(0, 0, -1)))
    return si.bsdf(), si


def mitsuba_diffuse(scene, x, y):
    """pi f of the reference, light and eye aslant so that no highlight is met. (3,)."""
    bsdf, si = mitsuba_hit(scene, x, y)
    si.wi = mi.Vector3f(0.6, 0, 0.8)
    value = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(0.6, 0, 0.8))
    return np.array(value).ravel() / 0.8 * np.pi


CENTERS = [[0.25, 0.75], [0.75, 0.75], [0.25, 0.25], [0.75, 0.25]]


def test_a_constant_colour_is_linear(tmp_path):
    scene = loaded(
        tmp_path,
        {
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.25, 0.125, 1],
                "metallicFactor": 0.25,
                "roughnessFactor": 0.5,
            }
        },
    )
    base, surface = row(scene)
    np.testing.assert_allclose(base, [0.5, 0.25, 0.125, 1])
    np.testing.assert_allclose(surface, [0.25, 0.25, 0.04, 0], atol=1e-6)


def test_without_a_material_the_default_counts(tmp_path):
    base, surface = row(loaded(tmp_path, None))
    np.testing.assert_allclose(base, 1)
    np.testing.assert_allclose(surface, [1, 1, 0.04, 0], atol=1e-6)


def test_pictures_are_decoded_and_multiplied(tmp_path):
    def grey(writer):
        texture = writer.texture(np.full((2, 2, 3), 188))
        return matt(writer, baseColorFactor=[1, 0.5, 0, 1], baseColorTexture={"index": texture})

    scene = loaded(tmp_path, grey)
    expected = 0.5028865 * np.array([1, 0.5, 0])  # ((188 / 255 + 0.055) / 1.055)^2.4
    np.testing.assert_allclose(seen(scene, [[0.5, 0.5]]), [expected], atol=1e-3)
    flat = load_scene(tmp_path / "thing.glb", sky=[1, 1, 1], materials="diffuse")
    np.testing.assert_allclose(mitsuba_diffuse(flat, 0.5, 0.5), expected * disney.even(1.0), atol=2e-3)


def nearest(writer, **more):
    texture = writer.texture(QUARTERS, magFilter=9728, minFilter=9728)
    return matt(writer, baseColorTexture={"index": texture, **more})


def test_pictures_stand_upright(tmp_path):
    """v runs down the picture, in our table and in Mitsuba."""
    scene = loaded(tmp_path, nearest, materials="diffuse")
    np.testing.assert_allclose(seen(scene, CENTERS), [RED, GREEN, BLUE, WHITE], atol=1e-3)
    for (x, y), color in zip(CENTERS, [RED, GREEN, BLUE, WHITE], strict=True):
        np.testing.assert_allclose(mitsuba_diffuse(scene, x, y), color, atol=1e-3)


@pytest.mark.parametrize(
    ("transform", "at_centers"),
    [
        ({"offset": [0.5, 0]}, [GREEN, RED, WHITE, BLUE]),
        ({"offset": [0, 0.5]}, [BLUE, WHITE, RED, GREEN]),
        ({"scale": [0.5, 0.5]}, [RED, RED, RED, RED]),
        # Coordinates turn counter-clockwise, the picture clockwise.
        ({"rotation": np.pi / 2, "offset": [0, 1]}, [BLUE, RED, WHITE, GREEN]),
    ],
)
def test_texture_transforms(tmp_path, transform, at_centers):
    scene = loaded(
        tmp_path,
        lambda w: nearest(w, extensions={"KHR_texture_transform": transform}),
        materials="diffuse",
    )
    np.testing.assert_allclose(seen(scene, CENTERS), at_centers, atol=1e-3)
    for (x, y), color in zip(CENTERS, at_centers, strict=True):
        np.testing.assert_allclose(mitsuba_diffuse(scene, x, y), color, atol=1e-3)


REPEAT, CLAMP, MIRROR = 10497, 33071, 33648
BEYOND = {REPEAT: [0, 1, 0, 1], CLAMP: [0, 1, 1, 1], MIRROR: [0, 1, 1, 0]}
"""Texel that coordinates 1/4, 3/4, 5/4, 7/4 read of two."""


@pytest.mark.parametrize("across", [REPEAT, CLAMP, MIRROR])
@pytest.mark.parametrize("down", [REPEAT, CLAMP, MIRROR])
def test_wrap_modes_of_each_direction(tmp_path, across, down):
    def material(writer):
        texture = writer.texture(QUARTERS, magFilter=9728, wrapS=across, wrapT=down)
        return matt(writer, baseColorTexture={"index": texture})

    scene = loaded(tmp_path, material, uv=[[0, 2], [2, 2], [2, 0], [0, 0]])
    centers = (np.arange(4) + 0.5) / 4
    points = [[x, 1 - y] for y in centers for x in centers]
    colors = np.array(QUARTERS)[BEYOND[down]][:, BEYOND[across]].reshape(-1, 3) / 255
    np.testing.assert_allclose(seen(scene, points), colors, atol=1e-3)


def test_the_second_set_of_coordinates(tmp_path):
    writer = Writer()
    material = writer.add("materials", nearest(writer, texCoord=1))
    corner = writer.accessor([[0.9, 0.1]] * 4)  # green everywhere
    mesh = writer.mesh(
        primitive={"material": material}, TEXCOORD_0=writer.accessor([[0, 0]] * 4), TEXCOORD_1=corner
    )
    writer.node(mesh=mesh)
    scene = load_scene(writer.glb(tmp_path), sky=[1, 1, 1])
    np.testing.assert_allclose(seen(scene, CENTERS), [GREEN] * 4, atol=1e-3)


def test_metallic_and_roughness_are_blue_and_green(tmp_path):
    def material(writer):
        texture = writer.texture(np.full((2, 2, 3), [255, 128, 51]))
        return {"pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": texture}}}

    _, surface = row(loaded(tmp_path, material))
    np.testing.assert_allclose(surface[:2], [0.2, (128 / 255) ** 2], atol=1e-3)


def test_vertex_colours_reach_both_sides(tmp_path):
    writer = Writer()
    colors = writer.accessor(
        [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]], "u1", normalized=True
    )
    material = writer.add("materials", matt(writer, baseColorFactor=[0.5, 0.5, 0.5, 1]))
    writer.node(name="square", mesh=writer.mesh(primitive={"material": material}, COLOR_0=colors))
    scene = load_scene(writer.glb(tmp_path), sky=[1, 1, 1], materials="diffuse")
    points = [[0.5, 0.25], [0.25, 0.75]]
    expected = [[0.25, 0.125, 0.125], [0.375, 0.25, 0.375]]  # half of the barycentric mixture
    np.testing.assert_allclose(seen(scene, points), expected, atol=1e-3)
    for point, color in zip(points, expected, strict=True):
        np.testing.assert_allclose(mitsuba_diffuse(scene, *point), color, atol=1e-3)


@pytest.mark.parametrize(
    ("mode", "cutoff", "opacities"),
    [("MASK", 0.5, [0, 1]), ("BLEND", 0.5, [0.2, 0.8]), ("OPAQUE", 0.5, [1, 1]), ("MASK", 0.9, [0, 0])],
)
def test_alpha(tmp_path, mode, cutoff, opacities):
    def material(writer):
        texels = np.full((2, 2, 4), 255)
        texels[:, 0, 3], texels[:, 1, 3] = 51, 204
        texture = writer.texture(texels, magFilter=9728)
        return (
            matt(writer, baseColorTexture={"index": texture})
            | {"alphaMode": mode}
            | ({"alphaCutoff": cutoff} if mode == "MASK" else {})
        )

    scene = loaded(tmp_path, material)
    for x, opacity in zip((0.25, 0.75), opacities, strict=True):
        bsdf, si = mitsuba_hit(scene, x, 0.25)
        np.testing.assert_allclose(
            1 - np.array(bsdf.eval_null_transmission(si)).ravel()[0], opacity, atol=1e-3
        )
        down = mi.Point3f(x, 0.25, 1), mi.Vector3f(0, 0, -1)
        through = scene.tracer.visible(*down, mi.Float(2), mi.Bool(True))
        np.testing.assert_allclose(1 - np.array(through), opacity, atol=1e-3)


def test_vertex_opacity(tmp_path):
    writer = Writer()
    colors = writer.accessor([[1, 1, 1, 0.5]] * 4)
    material = writer.add("materials", {**matt(writer, baseColorFactor=[1, 1, 1, 0.5]), "alphaMode": "BLEND"})
    writer.node(name="square", mesh=writer.mesh(primitive={"material": material}, COLOR_0=colors))
    scene = load_scene(writer.glb(tmp_path), sky=[1, 1, 1])
    through = scene.tracer.visible(mi.Point3f(0.5, 0.2, 1), mi.Vector3f(0, 0, -1), mi.Float(2), mi.Bool(True))
    np.testing.assert_allclose(np.array(through), 0.75, atol=1e-3)
    bsdf, si = mitsuba_hit(scene, 0.5, 0.2)
    np.testing.assert_allclose(np.array(bsdf.eval_null_transmission(si)).ravel()[0], 0.75, atol=1e-3)


@pytest.mark.parametrize("double_sided", [True, False])
def test_sidedness(tmp_path, double_sided):
    scene = loaded(
        tmp_path, lambda w: matt(w, baseColorFactor=[0.5, 0.5, 0.5, 1]) | {"doubleSided": double_sided}
    )
    np.testing.assert_allclose(seen(scene, [[0.5, 0.5]])[0], 0.5, atol=1e-6)
    np.testing.assert_allclose(seen(scene, [[0.5, 0.5]], from_behind=True)[0], 0.5 * double_sided, atol=1e-6)
    bsdf, si = mitsuba_hit(scene, 0.5, 0.5)
    si.wi = mi.Vector3f(0.6, 0, -0.8)
    behind = np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(0, 0, -1))).max()
    assert (behind > 0) == double_sided


def test_what_emits_is_a_light_of_that_radiance(tmp_path):
    """emissiveFactor times strength in nits is taken as W/(m^2 sr)."""
    material = {
        "emissiveFactor": [1, 0.5, 0],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 20}},
    }
    scene = loaded(tmp_path, material)
    assert ("square", "area") in [(light.name, light.kind) for light in scene.named_lights]
    _, si = mitsuba_hit(scene, 0.5, 0.5)
    np.testing.assert_allclose(np.array(si.shape.emitter().eval(si)).ravel(), [20, 10, 0])
    emission = np.array(scene.materials.emission).reshape(-1, 4)[scene.shapes["square"]]
    np.testing.assert_allclose(emission, [20, 10, 0, 1])


def test_an_emissive_picture(tmp_path):
    def material(writer):
        return {
            "emissiveFactor": [1, 1, 1],
            "emissiveTexture": {"index": writer.texture(QUARTERS, magFilter=9728)},
        }

    scene = loaded(tmp_path, material)
    _, si = mitsuba_hit(scene, 0.75, 0.75)
    np.testing.assert_allclose(np.array(si.shape.emitter().eval(si)).ravel(), GREEN, atol=1e-3)


def test_unlit_shows_its_colour_and_nothing_else(tmp_path):
    scene = loaded(
        tmp_path,
        lambda w: {**matt(w, baseColorFactor=[0.5, 0.25, 0, 1]), "extensions": {"KHR_materials_unlit": {}}},
    )
    base, _ = row(scene)
    np.testing.assert_allclose(base[:3], 0)
    emission = np.array(scene.materials.emission).reshape(-1, 4)[scene.shapes["square"]]
    np.testing.assert_allclose(emission[:3], [0.5, 0.25, 0])


@pytest.mark.parametrize(
    ("extensions", "specular"),
    [
        ({"KHR_materials_ior": {"ior": 2.0}}, 1 / 9),
        ({"KHR_materials_ior": {"ior": 1.2}}, (0.2 / 2.2) ** 2),
        ({"KHR_materials_specular": {"specularFactor": 0.5}}, 0.02),
        ({"KHR_materials_specular": {"specularFactor": 0}}, 0),
    ],
)
def test_reflectance_at_normal_incidence(tmp_path, extensions, specular):
    _, surface = row(loaded(tmp_path, lambda w: {**matt(w), "extensions": extensions}))
    np.testing.assert_allclose(surface[2], specular, atol=1e-4)


@pytest.mark.parametrize("volume", [{}, {"KHR_materials_volume": {"thicknessFactor": 1.0}}])
def test_glass_is_left_out_of_what_is_traced(tmp_path, volume):
    writer = Writer()
    writer.square(
        {**matt(writer), "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, **volume}},
        name="pane",
    )
    writer.square(translation=[0, 0, -1])
    scene = load_scene(writer.glb(tmp_path), sky=[1, 1, 1])
    assert set(scene.shapes) == {"square"}
    assert any("clear" in note for note in scene.notes)


def test_a_normal_map_turns_the_reference(tmp_path):
    """A map of +x everywhere, half way up: the shading normal leans to +x by 45 degrees."""
    lean = [128 + 90, 128, 128 + 90]

    def material(writer):
        return {**matt(writer), "normalTexture": {"index": writer.texture(np.full((2, 2, 3), lean))}}

    scene = loaded(tmp_path, material)
    bsdf, si = mitsuba_hit(scene, 0.5, 0.5)
    si.wi = mi.Vector3f(0, 0, 1)
    to, away = (np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(x, 0, 0.6))).max() for x in (0.8, -0.8))
    assert to > 5 * away


def leaning_up(writer, scale=1.0):
    """A normal map that leans by 45 degrees to where green points: up, in a picture as it is seen."""
    lean = np.full((2, 2, 3), [128, 128 + 90, 128 + 90])
    return {
        **matt(writer),
        "doubleSided": True,
        "normalTexture": {"index": writer.texture(lean), "scale": scale},
    }


def bumped_normal(scene, x=0.5, y=0.5):
    """(3,) the normal that the camera sees from +z, if smooth +z."""
    from ddgi.sampling import clock

    surface = scene.tracer.intersect(
        mi.Point3f(x, y, 1), mi.Vector3f(0, 0, -1), mi.Bool(True), time=clock(0, 0), stream=0, bumps=True
    )
    return np.ravel(surface.normal)


def test_green_of_a_normal_map_is_up_in_the_picture(tmp_path):
    """Mirrored pictures and mirrored nodes included, in ours and in the reference."""
    upright = np.array(
        [[0, 1], [1, 1], [1, 0], [0, 0]], np.float32
    )  # of a square counted from (0, 0) to (0, 1)
    for number, (uv, node) in enumerate(
        [
            (upright, {}),
            (upright * (-1, 1) + (1, 0), {}),
            (upright, {"scale": [-1, 1, 1], "translation": [1, 0, 0]}),
        ]
    ):
        writer = Writer()
        writer.square(leaning_up(writer), uv=uv.astype(np.float32), **node)
        folder = tmp_path / str(number)
        folder.mkdir()
        scene = load_scene(writer.glb(folder), sky=[1, 1, 1])
        np.testing.assert_allclose(bumped_normal(scene), [0, np.sqrt(0.5), np.sqrt(0.5)], atol=0.01)
        bsdf, si = mitsuba_hit(scene, 0.5, 0.5)
        si.wi = mi.Vector3f(0, 0, 1)
        up, down = (
            np.array(bsdf.eval(mi.BSDFContext(), si, si.to_local(mi.Vector3f(0, y, 0.6)))).max()
            for y in (0.8, -0.8)
        )
        assert up > 5 * down


@pytest.mark.parametrize("scale", [0.0, -1.0, 2.0, 8.0])
def test_slopes_of_a_normal_map_are_scaled(tmp_path, scale):
    scene = loaded(tmp_path, lambda writer: leaning_up(writer, scale))
    x, y, z = bumped_normal(scene)
    assert np.hypot(x, y) / z == pytest.approx(abs(scale), rel=0.02, abs=0.01)


def test_a_mesh_that_is_mirrored_in_part_is_told_of(tmp_path):
    """The last corner has the coordinates of the second: both triangles show the same half, one as in a mirror."""
    notes = loaded(tmp_path, leaning_up, uv=[[0, 1], [1, 1], [1, 0], [1, 1]]).notes
    assert any("mirrored" in note for note in notes)
    (tmp_path / "whole").mkdir()
    assert not any("mirrored" in note for note in loaded(tmp_path / "whole", leaning_up).notes)


def test_refinements_are_noted_once(tmp_path):
    writer = Writer()
    writer.use("KHR_materials_clearcoat", "VENDOR_sparkle")
    writer.json["extensionsRequired"] = ["KHR_materials_clearcoat"]
    writer.square()
    notes = load_scene(writer.glb(tmp_path), sky=[1, 1, 1]).notes
    assert "KHR_materials_clearcoat refines the picture: left out" in notes
    assert "VENDOR_sparkle is not read" in notes


def test_materials_and_pictures_are_made_once(tmp_path):
    writer = Writer()
    writer.square(nearest(writer), name="a")
    writer.node(name="b", mesh=0)
    scene = load_scene(writer.glb(tmp_path), sky=[1, 1, 1])
    columns = np.array(scene.materials.base_texture)
    assert columns[scene.shapes["a"]] == columns[scene.shapes["b"]] == 0
    assert dr.width(scene.materials.textures.width) == 1


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"\x89PNG\r\n\x1a\n" + b"garbage" * 9, "cannot be used|cannot be decoded|broken"),
        (b"RIFF1234WEBPVP8 ", "WebP picture: convert it"),
        (b"\xabKTX 20\xbb\r\n\x1a\n", "KTX2 picture: convert it"),
        (b"hello", "neither PNG nor JPEG"),
        (b"\xff\xd8\xff\xe0\x00\x04ab", "broken"),
    ],
)
def test_pictures_that_cannot_be_read(tmp_path, data, message):
    def material(writer):
        image = writer.add("images", {"bufferView": writer.view(data), "mimeType": "image/png"})
        return matt(writer, baseColorTexture={"index": writer.add("textures", {"source": image})})

    with pytest.raises(SceneError, match=rf"thing.glb: images\[0\].*{message}") as caught:
        loaded(tmp_path, material)
    assert "\n" not in str(caught.value)


def test_pictures_and_vertex_colours_multiply(tmp_path):
    """Picture x factor x vertex colour, and as much for opacity."""
    writer = Writer()
    texels = np.dstack([QUARTERS, np.full((2, 2), 204)])
    texture = writer.texture(texels, magFilter=9728)
    look = matt(writer, baseColorTexture={"index": texture}, baseColorFactor=[0.5, 0.5, 0.5, 0.5])
    material = writer.add("materials", look | {"alphaMode": "BLEND"})
    colors = writer.accessor([[0.25, 0.5, 1, 0.5]] * 4)
    mesh = writer.mesh(
        primitive={"material": material}, TEXCOORD_0=writer.accessor(SQUARE_UV), COLOR_0=colors
    )
    writer.node(name="square", mesh=mesh)
    expected = 0.5 * np.array([RED, GREEN, BLUE, WHITE]) * [0.25, 0.5, 1]
    for materials in ("full", "diffuse"):
        scene = load_scene(writer.glb(tmp_path), sky=[1, 1, 1], materials=materials)
        bsdf, si = mitsuba_hit(scene, 0.25, 0.75)
        np.testing.assert_allclose(np.array(bsdf.eval_null_transmission(si)).ravel()[0], 0.8, atol=1e-3)
        down = mi.Point3f(0.25, 0.75, 1), mi.Vector3f(0, 0, -1)
        np.testing.assert_allclose(
            np.array(scene.tracer.visible(*down, mi.Float(2), mi.Bool(True))), 0.8, atol=1e-3
        )
    expected *= disney.even(1.0)  # as Lambert's colour
    np.testing.assert_allclose(mitsuba_diffuse(scene, 0.25, 0.75) / 0.2, expected[0], atol=2e-3)
    writer.json["materials"][0].pop("alphaMode")
    scene = load_scene(writer.glb(tmp_path), sky=[1, 1, 1], materials="diffuse")
    np.testing.assert_allclose(seen(scene, CENTERS), expected, atol=1e-3)
    for point, color in zip(CENTERS, expected, strict=True):
        np.testing.assert_allclose(mitsuba_diffuse(scene, *point), color, atol=1e-3)


def test_a_fingerprint_sees_what_the_file_says(tmp_path):
    from ddgi.scene.fingerprint import fingerprint

    def printed(change=None, **square):
        writer = Writer()
        writer.square(nearest(writer), **square)
        if change:
            change(writer.json)
        return fingerprint(load_scene(writer.glb(tmp_path), sky=[1, 1, 1]))

    same = printed()
    assert printed(name="other") == same
    assert printed(translation=[0, 0, 1e-3]) != same
    assert printed(lambda j: j["samplers"][0].update(wrapS=CLAMP, wrapT=CLAMP)) != same
    assert printed(lambda j: j["materials"][0].update(doubleSided=True)) != same
