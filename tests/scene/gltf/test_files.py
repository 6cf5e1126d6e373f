"""Containers and what lies outside them: what is read, and what is refused with one line."""

import base64
import json
import os
import struct
import time
from pathlib import Path

import numpy as np
import pytest

import fuzz_gltf
import invalid_gltf
from ddgi import load_scene
from ddgi.errors import SceneError
from gltf_writing import Writer, glb_bytes, png, shapes_of

SHARED = Path(__file__).resolve().parents[3].parent / "shared" / "scenes"


def refused(path, *parts):
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    text = str(caught.value)
    assert "\n" not in text
    for part in parts:
        assert part in text, text
    return text


def square():
    writer = Writer()
    writer.square()
    return writer


def with_file(folder, uri, data=None):
    """The square with its buffer at a URI."""
    writer = square()
    writer.json["buffers"] = [{"byteLength": len(writer.data), "uri": uri}]
    if data is not None:
        data.write_bytes(bytes(writer.data))
    return writer.gltf(folder)


def test_one_scene_in_four_containers(tmp_path):
    plain = square()
    paths = [plain.gltf(tmp_path, "embedded.gltf"), plain.glb(tmp_path)]
    paths.append(with_file(tmp_path, "my%20data.bin", tmp_path / "my data.bin"))
    (tmp_path / "renamed.gltf").write_bytes(paths[1].read_bytes())  # its first bytes say what it is
    paths.append(tmp_path / "renamed.gltf")
    for path in paths:
        scene = load_scene(path, sky=[1, 1, 1])
        assert scene.triangles == 2
        assert set(scene.shapes) == {"square"}
        assert scene.up == (0, 1, 0)


def test_pictures_outside_and_in_data_uris(tmp_path):
    red = png(np.full((2, 2, 3), [255, 0, 0]))
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "red picture.png").write_bytes(red)
    for uri in (
        "sub/red%20picture.png",
        "sub\\red picture.png",
        "data:image/png;base64," + base64.b64encode(red).decode(),
    ):
        writer = Writer()
        texture = writer.add("textures", {"source": writer.add("images", {"uri": uri})})
        writer.square({"pbrMetallicRoughness": {"metallicFactor": 0, "baseColorTexture": {"index": texture}}})
        scene = load_scene(writer.glb(tmp_path), sky=[1, 1, 1])
        np.testing.assert_allclose(
            np.array(scene.materials.base).reshape(-1, 4)[scene.shapes["square"], :3], [1, 0, 0]
        )


@pytest.mark.parametrize(
    "uri",
    [
        "../secret.bin", "sub/../../secret.bin", "..%2Fsecret.bin", "%2e%2e/secret.bin", "..\\secret.bin", "link.bin",
        "linked/secret.bin", "/etc/hostname", "%2Fetc%2Fhostname", "\\\\server\\share", "//server/share",
    ],
)  # fmt: skip
def test_paths_out_of_the_folder_are_refused(tmp_path, uri):
    folder = tmp_path / "scene"
    (folder / "sub").mkdir(parents=True)
    (tmp_path / "secret.bin").write_bytes(bytes(square().data))
    (folder / "link.bin").symlink_to(tmp_path / "secret.bin")
    (folder / "linked").symlink_to(tmp_path)
    refused(with_file(folder, uri), "buffers[0]", "leads out of the scene's folder")


@pytest.mark.parametrize(
    "uri", ["http://example.org/a.bin", "file:///etc/hostname", "C:\\a.bin", "ftp:a", "c%3A/a.bin"]
)
def test_other_schemes_are_refused(tmp_path, uri):
    refused(with_file(tmp_path, uri), "buffers[0]")


@pytest.mark.parametrize(
    ("uri", "message"),
    [
        ("missing.bin", "file not found: missing.bin"),
        (".", "file not found"),
        ("", "is not the path of a file"),
        ("a%00b", "is not the path of a file"),
        ("%ff.bin", "is not UTF-8"),
        ("a" * 5000, "buffers[0]"),
        ("data:nothing", "without data"),
        ("data:;base64,!!!!", "not base64"),
        ("data:;base64,AAAA", "cut short"),
    ],
)
def test_buffers_that_cannot_be_read(tmp_path, uri, message):
    refused(with_file(tmp_path, uri), "thing.gltf: buffers[0]", message)


def test_pipes_are_not_read(tmp_path):
    os.mkfifo(tmp_path / "pipe.bin")
    refused(with_file(tmp_path, "pipe.bin"), "file not found")


GOOD = square().glb


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda b: b[:8], "not a GLB"),
        (lambda b: b[:40], "cut short"),
        (lambda b: b[:-4], "cut short"),
        (lambda b: b"glTX" + b[4:], "not a GLB"),
        (lambda b: b[:4] + struct.pack("<I", 1) + b[8:], "version 1"),
        (lambda b: b[:12] + struct.pack("<I", 10**9) + b[16:], "beyond the end"),
        (lambda b: b[:16] + b"BIN\0" + b[20:], "first chunk must be JSON"),
        (lambda b: b[:8] + struct.pack("<I", 12) + b[12:], "first chunk must be JSON"),
        (lambda b: glb_bytes(b"{ oops", b""), "not valid JSON"),
        (lambda b: glb_bytes(b"\xff\xfe", b""), "not UTF-8"),
        (lambda b: glb_bytes(b"", b""), "no JSON"),
        (
            lambda b: glb_bytes(json.dumps(Writer().json | {"buffers": [{"byteLength": 4}]}).encode(), b""),
            "no geometry",
        ),
    ],
)
def test_binary_files_that_are_broken(tmp_path, change, message):
    path = GOOD(tmp_path)
    path.write_bytes(change(path.read_bytes()))
    refused(path, message)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[]", "not an object"),
        ("{}", "asset"),
        ('{"asset": {"version": "1.0"}}', "glTF 1.0"),
        ('{"asset": {"version": 2}}', "asset.version"),
        ('{"asset": {"version": "2.0", "minVersion": "2.1"}}', "glTF 2.1"),
        ('{"asset": {"version": "2.0"}', "not valid JSON"),
        ("[" * 100000, "not"),
        ('{"asset": {"version": "2.0"}, "nodes": 3}', "nodes: Input should be a valid list"),
        ('{"asset": {"version": "2.0"}, "nodes": [{"translation": [1, NaN, 0]}]}', "nodes[0].translation[1]"),
        ('{"asset": {"version": "2.0"}, "nodes": [{"scale": [1e999, 1, 1]}]}', "nodes[0].scale[0]"),
        ('{"asset": {"version": "2.0"}, "scene": 4}', "scene names number 4 of the scenes, but there are 0"),
        ('{"asset": {"version": "2.0"}, "scene": ' + "9" * 5000 + "}", "not usable JSON"),
        ('{"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_materials_sheen", "ACME_x"]}', "ACME_x"),
    ],
)
def test_documents_that_are_broken(tmp_path, text, message):
    path = tmp_path / "thing.gltf"
    path.write_text(text)
    refused(path, "thing.gltf", message)


def test_names_of_two_lines_give_messages_of_one(tmp_path):
    writer = square()
    writer.json["accessors"][0].update(name="two\nlines", count=10**6)
    refused(writer.glb(tmp_path), 'accessors[0] "two lines"')
    writer.json["meshes"][0]["primitives"][0]["attributes"]["TWO\nLINES"] = -1
    refused(writer.glb(tmp_path), "meshes[0].primitives[0].attributes")
    writer.json["extensionsRequired"] = ["TWO\nLINES"]
    refused(writer.glb(tmp_path), "TWO LINES")


def test_the_command_says_it_in_one_line(refused, tmp_path):
    path = square().glb(tmp_path)
    path.write_bytes(path.read_bytes()[:-8])
    assert "cut short" in refused("render", path, "-o", "x.png")


# Damage at random ---------------------------------------------------------------------------------------


def test_undamaged_files_load():
    for files in fuzz_gltf.undamaged():
        found = fuzz_gltf.loaded(files)
        assert found.what == "loaded" or "pip install" in found.how, found.how


@pytest.mark.parametrize("first", range(0, 500, 100))
def test_damaged_files_load_or_are_refused(first):
    """The first of those that `benchmarks/fuzz_gltf.py` tries 20,000 of, in processes with limits."""
    found = [fuzz_gltf.loaded(fuzz_gltf.damaged(number)) for number in range(first, first + 100)]
    assert [(first + n, f.how) for n, f in enumerate(found) if f.what == "failed"] == []
    assert sum(f.what == "loaded" for f in found) >= 10, "most damage is not read"
    assert sum(f.what == "refused" for f in found) >= 10


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 100, 50))
def test_damaged_files_that_can_be_read_become_scenes(tmp_path, first):
    """Beyond the description: Mitsuba builds it, or a line says why not."""
    for number in range(first, first + 50):
        path = fuzz_gltf.written(fuzz_gltf.damaged(number), tmp_path / str(number))
        try:
            assert load_scene(path, sky=[1, 1, 1]).triangles > 0
        except SceneError as error:
            assert "\n" not in str(error)


# Files made by others -----------------------------------------------------------------------------------


def others(folder):
    if not SHARED.is_dir():
        pytest.skip(f"shared scenes are not at {SHARED}")
    return sorted(p for p in (SHARED / folder).rglob("*") if p.suffix in (".gltf", ".glb"))


@pytest.mark.scenes
def test_no_invalid_file_gets_past():
    """None shows a triangle, as no scene in them does; most would not if it did."""
    files = others("gltf-invalid")
    refused(files[0])  # imports what the others need
    for path in files:
        start = time.process_time()
        refused(path)
        assert time.process_time() - start < 1, path


@pytest.mark.scenes
def test_what_the_validator_calls_an_error_is_refused_or_harmless():
    """With all data read and all meshes shown, what loads has no mistakes but those listed with a reason."""
    others("gltf-invalid")
    for path in invalid_gltf.paths():
        found = invalid_gltf.strict_outcome(path)
        assert found.what in ("loaded", "refused"), (path, found.how)
        if found.what == "loaded":
            assert not invalid_gltf.meaningless(path), path


EMPTY = {"00_empty_scene", "00_no_nodes", "light", "mesh-sparse", "non_sparse_accessor_without_buffer_view"}
"""Files without a triangle to show: they say so."""


@pytest.mark.slow
@pytest.mark.scenes
def test_every_feature_file_is_read():
    for path in others("gltf-features"):
        if path.stem in EMPTY:
            from ddgi.scene.gltf.document import read_container

            read_container(path)
        else:
            assert len(shapes_of(path)) > 1, path
