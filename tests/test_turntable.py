"""Pictures all around: which cameras, which files, and that a failure leaves none of them."""

import json
import signal

import mitsuba as mi
import numpy as np
import pytest

import ddgi.output
from ddgi.errors import OutputError
from ddgi.turntable import views
from probing import diffuse, load, rgb, room

QUICK = ["--size", "32x18", "--frames", "2", "--set", "grid.counts=[3,3,3]", "--set", "rays.per_probe=16"]
BOX = "v -1 0 -2\nv 1 0 -2\nv 1 1 -2\nv -1 1 -2\nv -1 0 2\nv 1 0 2\nv 1 1 2\nv -1 1 2\n" + "".join(
    f"f {face}\n" for face in ("1 4 3 2", "5 6 7 8", "1 2 6 5", "4 8 7 3", "1 5 8 4", "2 3 7 6")
)


@pytest.fixture
def thing(tmp_path):
    """An OBJ file in a folder of its own."""
    (tmp_path / "thing").mkdir()
    file = tmp_path / "thing" / "thing.obj"
    file.write_text(BOX)
    return file


def numbers(vector) -> np.ndarray:
    return np.array(vector, np.float64).ravel()


def positions(cameras) -> np.ndarray:
    return np.stack([numbers(camera.position) for camera in cameras])


# ---- cameras -----------------------------------------------------------------------------------


def test_it_goes_around_an_object(thing):
    scene = load(thing)
    cameras = views(scene, 6)
    assert cameras[0] is scene.camera
    offset = positions(cameras) - [0, 0.5, 0]  # the middle of the box
    np.testing.assert_allclose(np.linalg.norm(offset, axis=1), np.linalg.norm(offset[0]), rtol=1e-5)
    np.testing.assert_allclose(offset[:, 1], offset[0, 1], rtol=1e-5)
    azimuth = np.unwrap(np.arctan2(offset[:, 0], offset[:, 2]))
    np.testing.assert_allclose(np.degrees(np.diff(azimuth)), 60, atol=1e-3)
    for camera, away in zip(cameras, offset, strict=True):  # all look at the axis, along their radius
        level = numbers(camera.forward)[[0, 2]]
        np.testing.assert_allclose(
            level / np.linalg.norm(level), -away[[0, 2]] / np.linalg.norm(away[[0, 2]]), atol=1e-3
        )


def test_it_goes_around_what_is_looked_at(thing):
    look = (9.0, 3.0, 1.0, 1.0, 0.0, 1.0)
    at = positions(views(load(thing, look=look), 4, look))
    np.testing.assert_allclose(at, [[9, 3, 1], [1, 3, -7], [-7, 3, 1], [1, 3, 9]], atol=1e-5)


def test_inside_a_room_it_turns_on_the_spot():
    light = {"type": "point", "position": [0.0, 0.5, 0.0], "intensity": rgb(1.0)}
    cameras = views(load(room(diffuse(0.5), lamp=light)), 4)
    np.testing.assert_allclose(positions(cameras), positions(cameras[:1] * 4), atol=1e-6)
    forward = np.stack([numbers(camera.forward) for camera in cameras])
    np.testing.assert_allclose(forward[0] + forward[2], [0, 2 * forward[0, 1], 0], atol=1e-6)
    np.testing.assert_allclose(forward[1, [0, 2]], [forward[0, 2], -forward[0, 0]], atol=1e-6)


# ---- files -------------------------------------------------------------------------------------


@pytest.mark.slow
def test_it_writes_numbered_files_and_starts_like_a_still(run, thing, tmp_path):
    # Both are laid out for what their cameras see, and a turntable's see more.
    box = ["--set", "grid.box=[[-1.1,-0.1,-2.1],[1.1,1.1,2.1]]", "--set", "relocation.method=off"]
    figures = tmp_path / "a.json"
    options = ["-o", tmp_path / "a.exr", *QUICK, *box]
    code, _, err = run(
        "render", thing, *options, "-o", tmp_path / "a.png", "--turntable", 3, "--json", figures
    )
    assert code == 0, err
    names = [f"a-00{n}.{kind}" for n in range(3) for kind in ("exr", "png")]
    assert sorted(p.name for p in tmp_path.iterdir() if p.is_file()) == sorted([*names, "a.json"])
    assert [name.rsplit("/")[-1] for name in json.loads(figures.read_text())["outputs"]] == names
    assert run("render", thing, *options)[0] == 0
    still, *around = (
        np.array(mi.Bitmap(str(tmp_path / n))) for n in ("a.exr", "a-000.exr", "a-001.exr", "a-002.exr")
    )
    assert np.array_equal(still, around[0])
    assert not np.array_equal(around[0], around[1])
    assert not np.array_equal(around[1], around[2])


@pytest.mark.slow
@pytest.mark.parametrize("interrupted", [False, True])
def test_all_files_or_none(run, thing, tmp_path, monkeypatch, interrupted):
    save, calls = ddgi.output.save, []

    def failing(*arguments):
        calls.append(arguments)
        if len(calls) == 3:
            if interrupted:
                signal.raise_signal(signal.SIGINT)
            raise OutputError("a disk is full")
        save(*arguments)

    monkeypatch.setattr(ddgi.output, "save", failing)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job ignores it
    try:
        code, _, err = run("render", thing, "-o", tmp_path / "a.png", "--turntable", 4, *QUICK)
    finally:
        signal.signal(signal.SIGINT, before)
    assert code == (130 if interrupted else 1)
    assert ("interrupted" if interrupted else "a disk is full") in err
    assert [p.name for p in tmp_path.iterdir()] == ["thing"]


def test_a_bad_place_is_refused_before_the_work(run, thing, tmp_path):
    (tmp_path / "a-002.png").mkdir()
    code, _, err = run("render", thing, "-o", tmp_path / "a.png", "--turntable", 4, *QUICK)
    assert (code, "is a folder" in err) == (1, True)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a-002.png", "thing"]
    assert run("render", thing, "-o", tmp_path / "a.png", "--turntable", 1, *QUICK)[0] == 2
    assert run("render", thing, "-o", tmp_path / "a.jpg", "--turntable", 2, *QUICK)[0] == 1
    assert run("render", thing, "-o", "/", "--turntable", 2, *QUICK)[0] == 1
