"""Damaged JPEG pictures: nothing on stderr but what is ours, whichever kind of file shows them."""

import os
import threading
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError
from ddgi.scene.jpeg import heard
from ddgi.scene.load import load_scene
from ddgi.scene.notes import Notes
from gltf_writing import Writer


def jpeg(tmp_path):
    """Noise, about 40 kB of it."""
    texels = np.random.default_rng(0).integers(0, 255, (256, 256, 3), np.uint8)
    path = tmp_path / "noise.jpg"
    mi.Bitmap(texels).write(str(path), mi.Bitmap.FileFormat.JPEG)
    return path.read_bytes()


def marked(data):
    """With a marker in its middle that no decoder knows."""
    return data[:9000] + b"\xff\x12" + data[9002:]


def short(data):
    return data[: len(data) // 2]


def late(data):
    """Cut where little is missing: read from memory, Mitsuba waited for the rest for ever."""
    return data[: len(data) * 99 // 100]


def gltf(folder, data):
    writer = Writer()
    image = writer.add("images", {"mimeType": "image/jpeg", "bufferView": writer.view(data)})
    texture = writer.add("textures", {"source": image})
    writer.square({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}})
    return writer.glb(folder)


def obj(folder, data):
    (folder / "b.jpg").write_bytes(data)
    (folder / "a.mtl").write_text("newmtl m\nmap_Kd b.jpg\n")
    path = folder / "a.obj"
    path.write_text("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n")
    return path


def xml(folder, data):
    (folder / "b.jpg").write_bytes(data)
    path = folder / "a.xml"
    texture = '<texture type="bitmap" name="reflectance"><string name="filename" value="b.jpg"/></texture>'
    path.write_text(
        f'<scene version="3.0.0"><shape type="sphere"><bsdf type="diffuse">{texture}</bsdf></shape></scene>'
    )
    return path


KINDS = pytest.mark.parametrize("kind", [gltf, obj, xml])


@KINDS
def test_one_line_of_our_own(refused, tmp_path, kind):
    path = kind(tmp_path, marked(jpeg(tmp_path)))
    text = refused("render", path, "-o", "picture.png", "--size", "32x18", "--frames", "1")
    assert "b.jpg" in text or "images[0]" in text


@KINDS
@pytest.mark.parametrize("damage", [short, late])
def test_what_can_be_shown_is_a_note(capfd, tmp_path, kind, damage):
    scene = load_scene(kind(tmp_path, damage(jpeg(tmp_path))), sky=[1, 1, 1])
    (note,) = (note for note in scene.notes if "damaged" in note)
    assert "b.jpg" in note or "images[0]" in note
    assert "premature end of data segment" in note
    assert capfd.readouterr().err == ""


@KINDS
def test_whole_ones_go_without_a_word(capfd, tmp_path, kind):
    scene = load_scene(kind(tmp_path, jpeg(tmp_path)), sky=[1, 1, 1])
    assert not any("damaged" in note for note in scene.notes)
    assert capfd.readouterr().err == ""


def test_what_others_write_meanwhile_comes_through(capfd):
    notes = Notes()
    with pytest.raises(SceneError), heard("a picture", notes):
        os.write(2, b"\r half of a bar Corrupt JPEG data: bad\nanother\n")
        raise SceneError
    assert capfd.readouterr().err == "\r half of a bar another\n"
    assert not notes.lines()
    os.write(2, b"after\n")
    assert capfd.readouterr().err == "after\n"


def descriptors():
    """How many the process has open, where the system tells."""
    folder = Path("/proc/self/fd")
    return len(list(folder.iterdir())) if folder.is_dir() else 0


def test_threads_take_turns(capfd):
    notes = Notes()

    def decode(number):
        for _ in range(20):
            with heard(f"picture {number}", notes):
                os.write(2, b"Premature end of JPEG file\n")

    threads = [threading.Thread(target=decode, args=(number,)) for number in range(4)]
    before = descriptors()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    os.write(2, b"ours\n")
    assert capfd.readouterr().err == "ours\n"
    assert len(notes.lines()) == 4
    assert descriptors() == before


def test_without_a_stderr(monkeypatch):
    def none(_):
        raise OSError

    monkeypatch.setattr(os, "dup", none)
    with heard("a picture", Notes()):
        pass
