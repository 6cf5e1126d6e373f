"""Pictures in files: what they hold, and that nothing half-written stays behind."""

import os
from dataclasses import replace

import mitsuba as mi
import numpy as np
import pytest

from ddgi import output
from ddgi.errors import OutputError
from ddgi.frame import Frame
from ddgi.output import check_writable, save
from ddgi.passes import picture as pictures
from ddgi.passes import tone
from ddgi.passes.picture import CHANNELS
from ddgi.scene.camera import look_at

WIDTH, HEIGHT = 5, 3


def picture_array() -> np.ndarray:
    return np.linspace(0, 4, WIDTH * HEIGHT * 3, dtype=np.float32).reshape(HEIGHT, WIDTH, 3)


def frame_with_layers() -> Frame:
    pixels = mi.Float(np.arange(WIDTH * HEIGHT, dtype=np.float32))
    layers = {
        name: mi.Color3f(pixels, pixels + k, pixels + 2 * k) if n == 3 else pixels + k
        for k, (name, n) in enumerate(CHANNELS.items())
    }
    kept = pictures.empty((WIDTH, HEIGHT), pictures.Settings(layers=True))
    assert kept.layers.keys() == layers.keys()
    return Frame(look_at((0, 0, 1), (0, 0, 0), size=(WIDTH, HEIGHT)), replace(kept, layers=layers))


def channels(path) -> dict[str, np.ndarray]:
    bitmap = mi.Bitmap(str(path))
    names = [field.name for field in bitmap.struct_()]
    return {name: np.array(bitmap)[..., i] for i, name in enumerate(names)}


def test_exr_keeps_radiance_exactly(tmp_path):
    save(tmp_path / "a.exr", picture_array())
    found = channels(tmp_path / "a.exr")
    assert np.array_equal(np.stack([found[c] for c in "RGB"], -1), picture_array())


def test_exr_names_layers(tmp_path):
    frame = frame_with_layers()
    save(tmp_path / "a.exr", frame)
    found = channels(tmp_path / "a.exr")
    assert {n.split(".")[0] for n in found} == {"R", "G", "B", *CHANNELS}
    for name, layer in frame.layers.items():
        components = {"normal": "XYZ", "depth": "Z"}.get(name, "RGB")
        for i, c in enumerate(components):
            assert np.array_equal(found[f"{name}.{c}"], np.array(layer)[..., i]), (name, c)


def test_exr_says_who_wrote_it(tmp_path):
    save(tmp_path / "a.exr", picture_array())
    assert mi.Bitmap(str(tmp_path / "a.exr")).metadata()["software"].startswith("ddgi ")


def test_png_is_the_tone_mapped_picture(tmp_path):
    settings = tone.Settings(exposure=0.0, curve="linear")
    save(tmp_path / "a.png", picture_array(), settings)
    found = np.array(mi.Bitmap(str(tmp_path / "a.png"))).astype(int)
    expected = np.rint(tone.tone_map(picture_array(), settings) * 255)
    assert found.shape == (HEIGHT, WIDTH, 3)
    assert np.array_equal(found, expected)


def test_tensors_and_frames_are_pictures(tmp_path):
    save(tmp_path / "a.png", mi.TensorXf(picture_array()))
    save(tmp_path / "b.png", frame_with_layers())
    assert (tmp_path / "a.png").exists()
    assert (tmp_path / "b.png").exists()


def test_replaces_a_file_through_a_link_and_leaves_nothing_else(tmp_path):
    real, link = tmp_path / "real.png", tmp_path / "link.png"
    real.write_text("old")
    link.symlink_to(real)
    save(link, picture_array())
    assert link.is_symlink()
    assert real.read_bytes().startswith(b"\x89PNG")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["link.png", "real.png"]


def test_new_files_have_the_usual_permissions(tmp_path):
    (tmp_path / "plain").touch()
    save(tmp_path / "a.png", picture_array())
    assert (tmp_path / "a.png").stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.parametrize("failing", ["write", "replace"])
def test_a_failure_keeps_the_old_file_and_no_part(tmp_path, monkeypatch, failing):
    target = tmp_path / "a.png"
    target.write_text("old")

    def fail(*_):
        raise OSError(28, "No space left on device")

    class Failing:
        def write(self, path, *_):
            with open(path, "w") as file:
                file.write("half")
            fail()

    if failing == "write":
        monkeypatch.setattr(output, "display_bitmap", lambda *_: Failing())
    else:
        monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OutputError, match=r"a.png: cannot be written: .*No space left"):
        save(target, picture_array())
    assert target.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("a.jpg", r"unknown kind of picture '.jpg', choose .png or .exr"),
        ("a", r"unknown kind of picture ''"),
        ("none/a.png", "there is no folder"),
        ("folder.png", "is a folder"),
    ],
)
def test_bad_places(tmp_path, name, message):
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(OutputError, match=message):
        check_writable(tmp_path / name)


def test_special_files_are_no_place(tmp_path):
    pipe = tmp_path / "pipe.png"
    os.mkfifo(pipe)
    with pytest.raises(OutputError, match="not a plain file"):
        check_writable(pipe)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_no_permission(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(OutputError, match="no permission"):
        check_writable(tmp_path / "a.png")


def test_permission_is_asked_for(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(OutputError, match="no permission to write in"):
        check_writable(tmp_path / "a.png")


@pytest.mark.parametrize("what", [np.zeros((4, 4)), np.zeros((0, 4, 3)), np.zeros((4, 4, 4)), "text", None])
def test_what_is_no_picture(tmp_path, what):
    with pytest.raises(OutputError, match="a picture must be"):
        save(tmp_path / "a.png", what)
    assert list(tmp_path.iterdir()) == []
