"""The fingerprint changes with whatever changes a path-traced picture, and with nothing else."""

import os
import subprocess
import sys
import time
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "scenes"


def load(source, **keywords):
    from ddgi.scene.load import load_scene

    return load_scene(source, **keywords)


def fingerprint(source, **keywords):
    from ddgi.scene.fingerprint import fingerprint

    return fingerprint(load(source, **keywords))


ROOM = """<scene version="3.0.0">
    <sensor type="perspective"><float name="fov" value="{fov}"/>
        <transform name="to_world"><translate z="{eye}"/></transform>
        <film type="hdrfilm"><integer name="width" value="{width}"/></film></sensor>
    <texture type="bitmap" id="wood"><string name="filename" value="wood.png"/>
        <string name="wrap_mode" value="{wrap}"/></texture>
    <bsdf type="diffuse" id="unused"/>
    <bsdf type="roughconductor" id="gold"><string name="distribution" value="{distribution}"/>
        <float name="alpha" value="{alpha}"/></bsdf>
    <shape type="rectangle"><bsdf type="diffuse"><ref id="wood" name="reflectance"/></bsdf>
        <transform name="to_world"><scale value="{scale}"/></transform></shape>
    <shape type="obj"><string name="filename" value="a.obj"/><ref id="gold"/></shape>
    <emitter type="point"><rgb name="intensity" value="{lamp}"/></emitter>
</scene>"""
VALUES = {
    "fov": 50, "eye": 4, "width": 64, "wrap": "repeat", "distribution": "ggx", "alpha": 0.1, "scale": 2,
    "lamp": "1, 2, 3",
}  # fmt: skip
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 {} 0\nf 1 2 3\n"


@pytest.fixture
def room(tmp_path):
    """Writes the room; its path."""
    texels = np.random.default_rng(1).integers(0, 255, (4, 4, 3)).astype(np.uint8)
    mi.Bitmap(texels).write(str(tmp_path / "wood.png"))
    (tmp_path / "a.obj").write_text(TRIANGLE.format(1))

    def write(**values):
        path = tmp_path / "room.xml"
        path.write_text(ROOM.format(**{**VALUES, **values}))
        return path

    return write


def test_the_same_twice(room):
    first = fingerprint(room())
    assert first == fingerprint(room())
    assert len(first) == 64
    int(first, 16)


def test_the_same_in_another_process(room):
    program = (
        "import sys, ddgi\nfrom ddgi.scene.load import load_scene\nfrom ddgi.scene.fingerprint import fingerprint\n"
        "for name in sys.argv[1:]: print(fingerprint(load_scene(name, materials='diffuse')), fingerprint(load_scene(name)))"
    )
    names = [str(room()), "cornell", "house"]
    for seed in ("1", "2"):
        environment = os.environ | {"PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(sys.path)}
        out = subprocess.run(
            [sys.executable, "-c", program, *names],
            capture_output=True,
            text=True,
            check=True,
            env=environment,
        ).stdout.split()
        assert out == [fingerprint(n, materials=m) for n in names for m in ("diffuse", "full")]


@pytest.mark.parametrize("change", [
    {"lamp": "1, 2, 4"}, {"wrap": "clamp"}, {"distribution": "beckmann"}, {"alpha": 0.2}, {"scale": 3},
])  # fmt: skip
def test_whatever_is_seen_counts(room, change):
    assert fingerprint(room()) != fingerprint(room(**change))


@pytest.mark.parametrize("change", [{"wrap": "clamp"}, {"scale": 3}, {"lamp": "1, 2, 4"}])
def test_so_it_does_where_all_is_diffuse(room, change):
    assert fingerprint(room(), materials="diffuse") != fingerprint(room(**change), materials="diffuse")


@pytest.mark.parametrize("change", [{"fov": 60}, {"eye": 5}, {"width": 128}])
def test_cameras_do_not(room, change):
    assert fingerprint(room()) == fingerprint(room(**change))


def test_nor_does_what_the_caller_asks_of_the_camera(room):
    first = fingerprint(room(), sun=(0, 40, 5))
    assert first == fingerprint(room(), sun=(0, 40, 5), size=(32, 32), camera=0)
    from ddgi.scene.camera import look_at

    assert first == fingerprint(room(), sun=(0, 40, 5), camera=look_at((0, 0, 3), (0, 0, 0)))


def test_a_second_camera_moves_nothing(room):
    first = fingerprint(room(), sun=(0, 40, 5), up="y")
    path = room()
    path.write_text(path.read_text().replace("<texture", '<sensor type="perspective"/><texture'))
    assert first == fingerprint(path, sun=(0, 40, 5), up="y")


def test_lights_added_count(room):
    found = [fingerprint(room(), **k) for k in (
        {}, {"sun": (0, 40, 5)}, {"sun": (0, 41, 5)}, {"sky": (1, 1, 1)},
        {"lights": [{"type": "point", "intensity": 1.0}]},
    )]  # fmt: skip
    assert len(set(found)) == len(found)


def test_the_mode_of_materials_counts(room):
    assert fingerprint(room()) != fingerprint(room(), materials="diffuse")
    assert fingerprint("cornell") == fingerprint("cornell")
    ball = {"type": "sphere", "bsdf": {"type": "conductor"}}
    full, diffuse = (
        fingerprint({"type": "scene", "s": mi.load_dict(ball)}, materials=m) for m in ("full", "diffuse")
    )
    assert full != diffuse


def test_content_of_files_counts(room, tmp_path):
    first = fingerprint(room())
    (tmp_path / "a.obj").write_text(TRIANGLE.format(2))
    second = fingerprint(room())
    mi.Bitmap(np.full((4, 4, 3), 90, np.uint8)).write(str(tmp_path / "wood.png"))
    assert len({first, second, fingerprint(room())}) == 3


@pytest.mark.slow
def test_a_picture_counts_by_its_texels():
    def wall(texels, **keywords):
        texture = {"type": "bitmap", "bitmap": mi.Bitmap(texels), **keywords}
        return {
            "type": "scene",
            "w": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": texture}},
        }

    texels = np.random.default_rng(1).random((4, 4, 3)).astype(np.float32)
    other = texels.copy()
    other[3, 3, 2] += 0.01
    for materials in ("full", "diffuse"):
        first = fingerprint(wall(texels), materials=materials)
        assert first == fingerprint(wall(texels), materials=materials)
        changed = [wall(other), wall(texels, filter_type="nearest"), wall(texels, wrap_mode="mirror"),
                   wall(texels, to_uv=mi.ScalarTransform3f().scale(2))]  # fmt: skip
        assert first not in [fingerprint(c, materials=materials) for c in changed]


def test_mesh_objects_count_by_their_vertices_and_materials():
    from ddgi.scene.mesh_keys import mesh

    def triangle(height=1.0, shade=0.5, **keywords):
        corners = np.array([[0, 0, 0], [1, 0, 0], [0, height, 0]])
        bsdf = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [shade, 0.2, 0.3]}}
        shape = mesh("t", corners, np.array([[0, 1, 2]]), bsdf=keywords.pop("bsdf", bsdf), **keywords)
        return fingerprint({"type": "scene", "t": shape})

    rough, smooth = ({"type": "roughconductor", "distribution": d} for d in ("ggx", "beckmann"))
    found = [
        triangle(),
        triangle(height=1.0001),
        triangle(shade=0.51),
        triangle(normals=np.array([[0, 0, 1]] * 3)),
        triangle(emitter={"type": "area", "radiance": 1.0}),
        triangle(bsdf=rough),
        triangle(bsdf=smooth),
        triangle(bsdf={"type": "twosided", "nested": rough}),
    ]
    assert len(set(found)) == len(found)
    assert found[0] == triangle()


@pytest.mark.parametrize("name", ["cornell", "house"])
def test_rendering_changes_nothing(name):
    """Building the scene and tracing it leaves its fingerprint as it was."""
    from ddgi.scene.fingerprint import fingerprint

    scene = load(name, materials="diffuse")
    first = fingerprint(scene)
    built = mi.parser.instantiate(mi.parser.ParserConfig(mi.variant()), scene.source)
    np.array(mi.render(built, integrator=mi.load_dict({"type": "path", "max_depth": 3}), spp=1))
    assert fingerprint(scene) == first


def test_names_do_not_count():
    one = {"type": "scene", "a": {"type": "sphere"}, "lamp": {"type": "point"}}
    other = {"type": "scene", "b": {"type": "sphere"}, "bulb": {"type": "point"}}
    assert fingerprint(one) == fingerprint(other)


def test_quick_on_a_large_scene():
    from ddgi.scene.fingerprint import fingerprint

    scene = load("courtyard")
    start = time.perf_counter()
    fingerprint(scene)
    assert time.perf_counter() - start < 0.5


@pytest.mark.slow
@pytest.mark.scenes
@pytest.mark.parametrize("name", ["veach-ajar", "classroom"])
def test_real_scenes(name):
    path = SHARED / name / "scene_mi3.xml"
    if not path.exists():
        pytest.skip(f"shared scenes are not at {SHARED}")
    for materials in ("full", "diffuse"):
        assert fingerprint(path, materials=materials) == fingerprint(path, materials=materials)


def test_a_scene_without_source_has_none():
    from dataclasses import replace

    from ddgi.scene.fingerprint import fingerprint

    with pytest.raises(SceneError, match="no fingerprint"):
        fingerprint(replace(load("cornell"), parsed=None))


def test_spectra_count():
    def wall(last):
        spectrum = {"type": "spectrum", "value": [(400, 0.1), (700, last)]}
        return {
            "type": "scene",
            "w": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": spectrum}},
        }

    assert fingerprint(wall(0.5)) == fingerprint(wall(0.5)) != fingerprint(wall(0.6))
