"""`ddgi render --animation`: moments to pictures and videos, in one go or several."""

import importlib.util
import json

import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import OutputError
from gltf_writing import Writer

QUICK = [
    "--size",
    "24x16",
    "--frames",
    "1",
    "--set",
    "grid.counts=[4,4,4]",
    "--set",
    "rays.per_probe=16",
    "--sky",
    "1,1,1",
]
LOOK = ["--look", "0.5,0.5,4,0.5,0.5,0"]


@pytest.fixture
def file(tmp_path):
    """A square that slides a metre to the right in a second, before a wall that stays."""
    writer = Writer()
    writer.node(name="wall", mesh=writer.mesh(), translation=[-2, -2, -1], scale=[6, 6, 1])
    sliding = writer.square({"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}})
    sampler = {
        "input": writer.accessor([0.0, 1.0], min=[0.0], max=[1.0]),
        "output": writer.accessor([[0.0, 0, 0], [1.0, 0, 0]]), "interpolation": "LINEAR",
    }  # fmt: skip
    target = {"node": sliding, "path": "translation"}
    writer.add(
        "animations", {"name": "slide", "samplers": [sampler], "channels": [{"sampler": 0, "target": target}]}
    )
    return writer.gltf(tmp_path)


def middle(path):
    """Mean column of what is red, from 0 to 1."""
    pixels = np.array(mi.Bitmap(str(path))).astype(float)[..., :3]
    red = np.maximum(pixels[..., 0] - pixels[..., 1], 0).sum(0)
    return float((red * np.linspace(0, 1, len(red))).sum() / red.sum())


def test_pictures_show_one_moment_after_another(run, tmp_path, file):
    code, out, err = run(
        "render",
        str(file),
        "--animation",
        "slide",
        "--fps",
        "4",
        *QUICK,
        *LOOK,
        "-o",
        str(tmp_path / "a.png"),
        "--json",
        "-",
    )
    assert code == 0, err
    files = sorted(tmp_path.glob("a-*.png"))
    assert [f.name for f in files] == [f"a-{n:04d}.png" for n in range(4)]
    assert json.loads(out)["outputs"] == [str(f) for f in files]
    places = [middle(f) for f in files]
    assert np.all(np.diff(places) > 0.02)
    assert not list(tmp_path.glob("*unfinished*"))


def test_a_moment_is_a_picture_of_its_own(run, tmp_path, file):
    places = []
    for time in ("0", "0.5", "1"):
        code, _, err = run("render", str(file), "--time", time, *QUICK, *LOOK, "-o", str(tmp_path / "a.png"))
        assert code == 0, err
        places.append(middle(tmp_path / "a.png"))
    assert np.all(np.diff(places) > 0.05)


@pytest.mark.slow
def test_a_moment_is_held_against_its_own_reference(run, tmp_path, file, monkeypatch):
    """At rest and moved: each is like the path tracer's picture of it, and those are not alike."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    found = []
    for time in ("0", "1"):
        options = [
            "--time",
            time,
            "--no-rivals",
            "--seconds",
            "1",
            "--size",
            "48x32",
            "--frames",
            "24",
            "--sky",
            "1,1,1",
        ]
        code, out, err = run(
            "compare", str(file), *LOOK, *options, "-o", str(tmp_path / f"{time}.png"), "--json", "-"
        )
        assert code == 0, err
        found.append(json.loads(out)["configurations"]["default"]["flip_mean"])
    assert max(found) < 0.1


def test_part_of_an_animation(run, tmp_path, file):
    options = ["--animation", "0", "--fps", "10", "--start", "0.5", "--duration", "0.2"]
    code, _, err = run("render", str(file), *QUICK, *LOOK, "-o", str(tmp_path / "a.png"), *options)
    assert code == 0, err
    assert len(list(tmp_path.glob("a-*.png"))) == 2


def test_a_video(run, tmp_path, file):
    av = pytest.importorskip("av")
    code, _, err = run(
        "render", str(file), "--animation", "--fps", "5", *QUICK, *LOOK, "-o", str(tmp_path / "a.mp4")
    )
    assert code == 0, err
    with av.open(str(tmp_path / "a.mp4")) as container:
        stream = container.streams.video[0]
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
        assert float(stream.average_rate) == pytest.approx(5)
    assert [f.shape for f in frames] == [(16, 24, 3)] * 5
    assert {p.name for p in tmp_path.iterdir()} == {"a.mp4", file.name}


def test_a_run_that_stopped_goes_on(run, tmp_path, file, monkeypatch):
    from ddgi import output

    arguments = [
        "render",
        str(file),
        "--animation",
        "--fps",
        "4",
        *QUICK,
        *LOOK,
        "-o",
        str(tmp_path / "a.png"),
    ]
    save, count = output.save, [0]

    def full(path, *what):
        count[0] += 1
        if count[0] == 3:
            raise OutputError(f"{path}: cannot be written: No space left on device")
        save(path, *what)

    monkeypatch.setattr(output, "save", full)
    code, _, err = run(*arguments)
    assert code == 1
    assert "No space left" in err
    kept = {p: p.stat().st_mtime_ns for p in sorted(tmp_path.glob("a-*.png"))}
    assert len(kept) == 2, "what is written stays"
    monkeypatch.setattr(output, "save", save)
    code, _, err = run(*arguments)
    assert code == 0
    assert "going on at picture 3 of 4" in err
    assert len(list(tmp_path.glob("a-*.png"))) == 4
    assert all(path.stat().st_mtime_ns == when for path, when in kept.items())
    code, _, err = run(*arguments[:-1], str(tmp_path / "b.png"))
    assert code == 0
    assert "shown at rest" not in err
    for stopped, whole in zip(
        sorted(tmp_path.glob("a-*.png")), sorted(tmp_path.glob("b-*.png")), strict=True
    ):
        assert stopped.read_bytes() == whole.read_bytes(), "as if it had never stopped"


def test_another_request_begins_anew(run, tmp_path, file):
    base = ["render", str(file), "--animation", *QUICK, *LOOK, "-o", str(tmp_path / "a.png")]
    assert run(*base, "--fps", "3")[0] == 0
    note = tmp_path / "a.png.unfinished.json"
    note.write_text(json.dumps({"fps": 3}))
    code, _, err = run(*base, "--fps", "4")
    assert code == 0
    assert "going on" not in err
    assert not note.exists()


@pytest.mark.parametrize(
    ("options", "code", "message"),
    [
        (["--animation", "run"], 1, "no animation 'run': there are slide"),
        (["--animation", "slide", "--duration", "1e6"], 1, "30,000,000 pictures are more than 10,000"),
        (["--animation", "slide", "--turntable", "3"], 2, "--turntable or --animation, not both"),
        (["--animation", "slide", "-o", "b.png"], 2, "one --output"),
        (["--animation", "slide", "--fps", "0"], 2, "fps"),
        (["--animation", "slide", "--time", "1"], 2, "--start instead of --time"),
        (["--time", "1", "--clip", "fly"], 1, "no animation 'fly'"),
        (["--time", "soon"], 2, "soon"),
    ],
)
def test_what_cannot_be_played(run, tmp_path, file, options, code, message):
    found, _, err = run("render", str(file), *QUICK, "-o", str(tmp_path / "a.png"), *options)
    assert found == code
    assert message in err
    assert "Traceback" not in err
    assert [p.name for p in tmp_path.iterdir()] == [file.name]


def test_scenes_at_rest_are_refused(refused):
    assert "nothing in it is animated" in refused("render", "cornell", "--animation", "-o", "a.png", *QUICK)


def test_without_pyav_it_says_what_to_install(run, tmp_path, file, monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr("ddgi.video.find_spec", lambda name: None if name == "av" else find(name))
    code, _, err = run("render", str(file), "--animation", *QUICK, "-o", str(tmp_path / "a.mp4"))
    assert code == 1
    assert "pip install 'ddgi[video]'" in err
