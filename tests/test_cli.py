"""The command line: what it prints and writes, and that each failure is one line, one code, no file."""

import json
import os
import signal
import subprocess
import sys
import time

import mitsuba as mi
import numpy as np
import pytest

from ddgi.cli.progress import Progress
from ddgi.cli.request import SceneRequest, SettingsRequest
from ddgi.cli.values import parse_numbers
from ddgi.scene.library import BUILT_IN
from ddgi.settings import PRESETS

QUICK = ["--size", "24x16", "--frames", "3", "--set", "grid.budget=64", "--set", "rays.per_probe=16"]


def ddgi(*arguments: str, **keywords) -> subprocess.CompletedProcess:
    """The command in a process of its own."""
    command = [sys.executable, "-m", "ddgi", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=300, **keywords)


# ---- what works --------------------------------------------------------------------------------


def test_render_writes_pictures_and_figures(run, tmp_path):
    png, exr, figures = tmp_path / "a.png", tmp_path / "a.exr", tmp_path / "a.json"
    code, out, err = run("render", "cornell-point", "-o", png, "-o", exr, "--json", figures, *QUICK)
    assert (code, out) == (0, "")
    assert "cornell-point, 24x16: " in err.splitlines()[-1]
    assert np.array(mi.Bitmap(str(png))).shape == (16, 24, 3)
    assert "indirect.R" in [f.name for f in mi.Bitmap(str(exr)).struct_()]
    found = json.loads(figures.read_text())
    assert found["size"] == [24, 16]
    assert found["frames"] == 3
    assert found["non_finite"] == {"rays": 0, "pixels": 0}
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.exr", "a.json", "a.png"]


SMALL = QUICK[:2] + QUICK[4:]
"""QUICK for commands whose number of frames is part of what they measure."""


@pytest.mark.slow
def test_flicker_measures_and_shows_where(run, tmp_path):
    figures, png, exr = tmp_path / "a.json", tmp_path / "a.png", tmp_path / "a.exr"
    code, out, _ = run("flicker", "cornell-point", "--json", figures, "-o", png, *SMALL)
    assert code == 0
    found = json.loads(figures.read_text())
    assert 0 < found["flicker_mean"] < found["flicker_max"] < 3
    assert (found["frames"], found["warm_up"], found["hysteresis"]) == (50, 200, 0.97)
    assert f"mean         {found['flicker_mean']:.5f}" in out
    assert "the brightest yellow" in out.splitlines()[-1]
    assert np.array(mi.Bitmap(str(png))).shape == (23, 24, 3)  # seven rows of scale
    assert run("flicker", "cornell-point", "-o", exr, *SMALL)[0] == 0
    assert np.array(mi.Bitmap(str(exr))).mean() == pytest.approx(found["flicker_mean"], rel=1e-4)


def test_explain_lists_probes_and_steps(run, tmp_path):
    figures, png = tmp_path / "a.json", tmp_path / "a.png"
    code, out, _ = run(
        "explain", "cornell-point", "--pixel", "12,8", "--seconds", "0", "--json", figures, "-o", png, *QUICK
    )
    assert code == 0
    found = json.loads(figures.read_text())
    assert len(found["probes"]) == 8
    assert sum(p["share"] for p in found["probes"]) == pytest.approx(1, abs=1e-3)
    for step in ("field", "true visibility", "no probes between", "path traced"):
        assert f"\n{step}" in out
    assert np.array(mi.Bitmap(str(png))).shape[2] == 3


def test_debug_writes_a_picture(run, tmp_path):
    png = tmp_path / "a.png"
    assert run("debug", "cornell-point", "--view", "weights", "-o", png, *QUICK)[0] == 0
    assert np.array(mi.Bitmap(str(png))).shape == (16, 24, 3)
    code, _, err = run("debug", "cornell-point", "--view", "everything", "-o", png)
    assert code == 2
    assert "irradiance-atlas" in err


@pytest.mark.parametrize(
    "command", [("explain", "--pixel", "1,1", "-o"), ("flicker", "-o"), ("render", "-o")]
)
def test_a_picture_and_figures_do_not_go_to_one_file(run, command, tmp_path):
    png = tmp_path / "a.png"
    name, *options = command
    code, _, err = run(name, "cornell", *options, png, "--json", png)
    assert code != 0
    assert "cannot go to one file" in err
    assert not png.exists()


@pytest.mark.parametrize("pixel", ["3", "3,4,5", "-1,2", "a,b", "1.5,2"])
def test_what_is_no_pixel_is_refused(run, pixel):
    code, _, err = run("explain", "cornell", "--pixel", pixel)
    assert code == 2
    assert "is not a pixel such as 120,45" in err


@pytest.mark.slow
def test_respond_counts_frames(run, tmp_path):
    faster = ["--set", "blend.hysteresis=0.8", "--set", "rays.per_probe=64"]
    figures = tmp_path / "a.json"
    code, out, _ = run(
        "respond", "cornell-point", "--light", "point-light", "--json", figures, *SMALL, *faster
    )
    assert code == 0
    found = json.loads(figures.read_text())
    assert found["light"] == "point-light"
    assert 11 < found["off_frames"] < 60  # one bounce takes 11
    assert len(found["off_curve"]) == found["off_frames"] + 1
    assert len(found["on_curve"]) == found["on_frames"] + 1
    first, *lines = out.splitlines()
    assert first.startswith("cornell-point, 24x16, light point-light: ")
    assert lines[:2] == [f"off  {found['off_frames']}", f"on   {found['on_frames']}"]


def test_info_prints_what_there_is(run):
    code, out, err = run("info", "cornell-point", "--set", "grid.counts=[4,5,6]")
    assert code == 0, err
    first, *rows = out.splitlines()
    rows = dict(row.split(maxsplit=1) for row in rows)
    assert first == "cornell-point"
    assert rows["geometry"] == "34 triangles in 7 shapes"
    assert rows["lights"] == "1 point"
    assert rows["units"].startswith("metres, ")
    assert rows["probes"].startswith("120 (4x5x6, ")
    assert rows["memory"].startswith("7,328 bytes per probe, 0.879 MB")
    assert "warning:" not in out


def test_info_warns_and_still_succeeds(run):
    code, out, _ = run("info", "cornell-point", "--set", "grid.box=[[-0.2,-0.2,-0.2],[0.2,0.2,0.2]]")
    assert code == 0
    warnings = [line for line in out.splitlines() if line.startswith("warning: ")]
    assert any("lies outside the volume" in line for line in warnings)


@pytest.mark.slow
def test_info_figures(run, tmp_path):
    path = tmp_path / "a.json"
    code, out, _ = run("info", "cornell-point", "--point", "0,9,0,1,1,1", "--size", "40x30", "--json", path)
    assert code == 0
    assert out.startswith("cornell-point\n")
    found = json.loads(path.read_text())
    assert found["cameras"][0]["size"] == [40, 30]
    assert [light["name"] for light in found["lights"] if light["outside"]] == ["added-light-0"]
    assert [warning["kind"] for warning in found["warnings"]] == ["light-outside"]
    code, out, _ = run("info", "cornell-point", "--point", "0,9,0,1,1,1", "--size", "40x30", "--json", "-")
    assert json.loads(out) == found


@pytest.mark.slow
def test_same_seed_same_picture(run, tmp_path):
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        assert run("render", "cornell", "-o", tmp_path / f"{name}.exr", "--seed", seed, *QUICK)[0] == 0
    a, b, c = (np.array(mi.Bitmap(str(tmp_path / f"{n}.exr"))) for n in "abc")
    assert np.array_equal(a, b)
    assert not np.array_equal(a, c)


def test_figures_on_stdout(run, tmp_path):
    code, out, _ = run("render", "cornell-point", "-o", tmp_path / "a.png", "--json", "-", *QUICK)
    assert code == 0
    assert json.loads(out)["scene"] == "cornell-point"


@pytest.mark.parametrize(
    "options",
    [
        ["--look", "-0.5,0,3,0,0,0"],
        ["--look=0,0,3,0,0,0", "--up", "-y"],
        ["--up", "0,1,0", "--near", "3"],
        ["--camera", "0"],
        ["--camera", "front"],
        ["--sun", "-30,40,5"],
        ["--sky", "sunsky"],
        ["--sky", "0.1,0.2,0.3", "--sun", "0,90,1"],
        ["--point", "0,0,0,1,1,1", "--point", "-0.5,0,0,1,0,0"],
        ["--spot", "0,0.9,0,0,-1,0,5,5,5,40", "--spot", "0,0,0.9,0,0,-1,1,1,1,20"],
        ["--preset", "mff", "--set", "gather.path_length=2"],
        ["--materials", "diffuse"],
        ["--ceiling", "auto"],
        ["--ceiling", "0.9"],
        ["--clear", "small-box", "--clear", "GREEN-wall"],
    ],
)
def test_options_are_understood(run, tmp_path, options):
    code, _, err = run("render", "cornell-point", "-o", tmp_path / "a.png", *options, *QUICK)
    assert code == 0, err
    assert (tmp_path / "a.png").exists()


@pytest.mark.slow
def test_near_plane_cuts_what_the_camera_sees(run, tmp_path):
    for name, options in (("all", []), ("cut", ["--near", "3.5"])):
        path = tmp_path / f"{name}.exr"
        assert run("render", "cornell-point", "-o", path, *options, *QUICK)[0] == 0
    depth = {n: np.array(mi.Bitmap(str(tmp_path / f"{n}.exr"))) for n in ("all", "cut")}
    assert not np.array_equal(depth["all"], depth["cut"])


def test_lists(run):
    code, out, _ = run("scenes")
    assert code == 0
    assert [line.split()[0] for line in out.splitlines()] == list(BUILT_IN)
    code, out, _ = run("presets")
    assert [line.split()[0] for line in out.splitlines()] == list(PRESETS)


def test_printed_preset_is_a_config(run, tmp_path):
    _, text, _ = run("presets", "ctu")
    file = tmp_path / "ctu.toml"
    file.write_text(text)
    settings = SettingsRequest(config=file).settings()
    assert settings == PRESETS["ctu"]


def test_help_and_version(run):
    for arguments in (
        ["--help"],
        ["render", "--help"],
        ["bench", "-h"],
        ["flicker", "-h"],
        ["respond", "-h"],
        ["explain", "-h"],
        ["debug", "-h"],
        ["info", "-h"],
        ["--version"],
    ):
        code, out, err = run(*arguments)
        assert (code, err) == (0, "")
        assert "ddgi" in out


def test_help_loads_no_library_that_takes_long():
    code = (
        "import sys; from ddgi.cli import main\n"
        "try: main(['--help'])\n"
        "except SystemExit: pass\n"
        "print(sorted({'mitsuba', 'drjit', 'numpy', 'pydantic'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


# ---- bad input ---------------------------------------------------------------------------------

MITSUBA = '<scene version="3.0.0">{}</scene>'
BALL = '<shape type="sphere"><bsdf type="diffuse"/></shape>'
LAMP = '<emitter type="point"><rgb name="intensity" value="{}"/></emitter>'


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["render", "no-such-scene", "-o", "a.png"], "no scene 'no-such-scene'"),
        (["render", "corneli", "-o", "a.png"], "did you mean cornell?"),
        (["render", "none.xml", "-o", "a.png"], "none.xml: file not found"),
        (["render", ".", "-o", "a.png"], "folder"),
        (["render", "cornell", "-o", "a.jpg"], "unknown kind of picture"),
        (["render", "cornell", "-o", "none/a.png"], "there is no folder"),
        (["render", "cornell", "-o", "."], "is a folder"),
        (["render", "cornell", "-o", "a.png", "--json", "none/a.json"], "there is no folder"),
        (["render", "cornell", "-o", "a.png", "--json", "."], "is a folder"),
        (["render", "cornell", "-o", "a.png", "--preset", "best"], "unknown preset"),
        (
            ["render", "cornell", "-o", "a.png", "--config", "none.toml"],
            "none.toml: there is no such file; `ddgi presets default`",
        ),
        (["render", "cornell", "-o", "a.png", "--set", "query.crsh=1"], "did you mean query.crush?"),
        (
            ["render", "cornell", "-o", "a.png", "--set", "query.crush=7"],
            "query.crush must be a number from 0",
        ),
        (["render", "cornell", "-o", "a.png", "--set", "gather.path_length=true"], "to 32, not true"),
        (["render", "cornell", "-o", "a.png", "--camera", "back"], "no camera 'back'"),
        (
            ["render", "cornell", "-o", "a.png", "--look", "0,0,0,0,0,0"],
            "cannot look at where it stands: 0, 0, 0",
        ),
        (["render", "cornell", "-o", "a.png", "--near", "-1"], "near must be"),
        (["render", "cornell", "-o", "a.png", "--near", "nan"], "near must be"),
        (["render", "cornell", "-o", "a.png", "--sun", "0,0,-1"], "sun must be"),
        (["render", "cornell", "-o", "a.png", "--sky", "-1,0,0"], "sky must be"),
        (["render", "cornell", "-o", "a.png", "--ceiling", "-9"], "ceiling must be above"),
        (["render", "cornell", "-o", "a.png", "--ceiling", "1e9"], "no higher than"),
        (["render", "cornell", "-o", "a.png", "--clear", "box"], "the nearest are small-box, large-box"),
        (["render", "cornell", "-o", "a.png", "--point", "0,0,0,-1,0,0"], "negative"),
        (["render", "cornell", "-o", "a.png", "--env", "none.exr"], "not found"),
        (
            ["render", "cornell", "-o", "a.png", "--set", "grid.counts=[4096,4096,4096]"],
            "the budget is 4,096 MB",
        ),
        (["render", "cornell", "-o", "a.png", "--set", "grid.box=[[0,0,0],[-1,1,1]]"], "box must be"),
        (["presets", "best"], "unknown preset"),
        (["flicker", "cornell", "-o", "a.jpg"], "unknown kind of picture"),
        (["flicker", "cornell", "--json", "none/a.json"], "there is no folder"),
        (["flicker", "no-such-scene"], "no scene 'no-such-scene'"),
        (["debug", "cornell", "--view", "probes", "-o", "a.exr"], "choose a name that ends in .png"),
        (["debug", "no-such-scene", "--view", "leak", "-o", "a.png"], "no scene 'no-such-scene'"),
        (["explain", "cornell", "--pixel", "9000,3"], "pixel 9000,3 lies outside the picture of"),
        (["explain", "no-such-scene", "--pixel", "1,1"], "no scene 'no-such-scene'"),
        (["explain", "cornell", "--pixel", "1,1", "-o", "a.jpg"], "choose a name that ends in .png"),
        (["explain", "cornell", "--pixel", "1,1", "--json", "none/a.json"], "there is no folder"),
        (["respond", "cornell", "--preset", "best"], "unknown preset"),
        (["respond", "cornell", "--light", "sun"], "no light 'sun': there are light (area)"),
        (["respond", "house", "--light", "1"], "no light '1': there are sun (directional)"),
        (["bench", "--preset", "best"], "unknown preset"),
        (["info", "no-such-scene"], "no scene 'no-such-scene'"),
        (["info", "none.glb"], "none.glb: file not found"),
        (["info", "cornell", "--json", "none/a.json"], "there is no folder"),
        (["info", "cornell", "--set", "grid.box=[[5,5,5],[6,6,6]]"], "wholly outside the scene"),
        (["info", "cornell", "--set", "grid.counts=[4096,4096,4096]"], "the budget is 4,096 MB"),
    ],
)
def test_bad_input_is_one_line(refused, arguments, message):
    assert message in refused(*arguments)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "empty"),
        ("<scene", "scene.xml"),
        (MITSUBA.format(""), "no geometry"),
        (MITSUBA.format('<shape type="obj"><string name="filename" value="none.obj"/></shape>'), "none.obj"),
        (MITSUBA.format('<shape type="cubist"/>'), "cubist"),
        (
            MITSUBA.format(
                '<shape type="sphere"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">'
                '<string name="filename" value="none.png"/></texture></bsdf></shape>'
            ),
            "none.png",
        ),
        (MITSUBA.format(BALL + LAMP.format("-1, 0, 0")), "negative"),
        (MITSUBA.format(BALL + LAMP.format("nan, 0, 0")), "finite"),
        (MITSUBA.format(BALL + LAMP.format("inf, 0, 0")), "finite"),
    ],
)
def test_bad_scene_files_are_one_line(refused, tmp_path, content, message):
    (tmp_path / "scene.xml").write_text(content)
    assert message in refused("render", "scene.xml", "-o", "a.png", *QUICK)


def test_bad_pictures_are_one_line(refused, tmp_path):
    (tmp_path / "sky.exr").write_text("not a picture")
    assert "sky.exr" in refused("render", "cornell", "-o", "a.png", "--env", "sky.exr", *QUICK)


@pytest.mark.parametrize(
    "arguments",
    [
        ["render"],
        ["info"],
        ["info", "cornell", "-o", "a.png"],
        ["render", "cornell"],
        ["nonsense"],
        ["render", "cornell", "-o", "a.png", "--size", "0x9"],
        ["render", "cornell", "-o", "a.png", "--size", "big"],
        ["render", "cornell", "-o", "a.png", "--frames", "0"],
        ["render", "cornell", "-o", "a.png", "--look", "1,2,3"],
        ["render", "cornell", "-o", "a.png", "--look", "1,2,3,4,5,nan"],
        ["render", "cornell", "-o", "a.png", "--sun", "a,b,c"],
        ["render", "cornell", "-o", "a.png", "--sky", "blue"],
        ["render", "cornell", "-o", "a.png", "--up", "w"],
        ["render", "cornell", "-o", "a.png", "--seed", "-1"],
        ["render", "cornell", "-o", "a.png", "--spot", "0,0,0,0,0,0,1,1,1,30"],
        ["render", "cornell", "-o", "a.png", "--spot", "0,0,0,0,1,0,1,1,1,120"],
        ["render", "cornell", "-o", "a.png", "--backend", "metal"],
        ["render", "cornell", "-o", "a.png", "--materials", "glass"],
        ["render", "cornell", "-o", "a.png", "--ceiling", "high"],
        ["render", "cornell", "-o", "a.png", "--ceiling", "nan"],
        ["render", "cornell", "-o", "a.png", "--nonsense"],
    ],
)
def test_misuse_is_one_line_and_code_two(refused, arguments):
    assert "--help" in refused(*arguments, code=2)


@pytest.mark.slow
def test_a_light_without_effect_is_one_line():
    dark = ["--point", "0,0,0,0,0,0", "--light", "added-light-0"]
    done = ddgi("respond", "cornell-point", *dark, *SMALL)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.splitlines()[-1].startswith("ddgi: error: light 'added-light-0' hardly changes")
    assert "Traceback" not in done.stderr


def test_no_command_is_misuse(refused):
    assert "render, info, compare, explain, debug, flicker, respond, bench, scenes or presets" in refused(
        code=2
    )


def test_debug_shows_the_traceback(run, tmp_path):
    code, _, err = run("render", "none.xml", "-o", tmp_path / "a.png", "--debug")
    assert code == 1
    assert "Traceback" in err
    assert err.splitlines()[-1].startswith("ddgi: error: ")


def test_the_unexpected_is_one_line_too(refused, monkeypatch):
    def fail(*_, **__):
        raise ZeroDivisionError("division by zero\nin two lines")

    monkeypatch.setattr("ddgi.still.render_frame", fail)
    text = refused("render", "cornell", "-o", "a.png", *QUICK)
    assert "unexpected ZeroDivisionError: division by zero in two lines (run again with --debug" in text


def test_no_llvm_is_one_line(tmp_path):
    environment = os.environ | {"DRJIT_LIBLLVM_PATH": "/none/libLLVM.so"}
    done = ddgi("render", "cornell", "-o", str(tmp_path / "a.png"), "--backend", "llvm", env=environment)
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1
    assert "libLLVM" in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize("after", [1.0, 2.0, 5.0])
def test_interrupt_leaves_nothing(tmp_path, after):
    """At any time: during imports, while a kernel is recorded, between frames."""
    target = str(tmp_path / "a.png")
    command = [sys.executable, "-m", "ddgi", "render", "cornell", "-o", target, "--frames", "1000000"]
    # Started in the background, as CI may start the tests, a process would be told to ignore interrupts.
    heed = lambda: signal.signal(signal.SIGINT, signal.default_int_handler)  # noqa: E731
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=heed)
    time.sleep(after)
    process.send_signal(signal.SIGINT)
    try:
        _, err = process.communicate(timeout=60)
    finally:
        process.kill()  # else it would render on for days
    # Where it came inside an exec() of some import, Python ends by the signal itself: 130 to a shell too.
    assert process.returncode in (130, -signal.SIGINT), err
    assert err.splitlines()[-1] == "ddgi: interrupted"
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


def test_a_reader_that_leaves_is_no_error():
    command = f"{sys.executable} -m ddgi presets default | true"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert done.stderr == ""


@pytest.mark.parametrize(
    ("look", "black"), [("0,0,3,0,0,9", True), ("0,0,0.5,0,0,-1", True), ("0,0,3,0,0,0", False)]
)
def test_a_black_picture_is_not_passed_over_in_silence(run, tmp_path, look, black):
    """Past everything, from inside a solid, and as it should be."""
    scene = tmp_path / "ball.xml"
    scene.write_text(
        """<scene version="3.0.0"><shape type="sphere"/><emitter type="point">
        <point name="position" x="0" y="2" z="2"/></emitter></scene>"""
    )
    code, _, err = run("render", scene, "-o", tmp_path / "a.png", "--look", look, *QUICK)
    assert code == 0
    assert ("warning: the picture is black" in err) == black


def test_non_finite_light_is_reported(run, tmp_path, monkeypatch):
    import ddgi.still

    original = ddgi.still.render_frame

    def with_a_bad_ray(*arguments):
        field, frame = original(*arguments)
        field.non_finite = mi.UInt32(3)
        return field, frame

    monkeypatch.setattr(ddgi.still, "render_frame", with_a_bad_ray)
    code, _, err = run("render", "cornell-point", "-o", tmp_path / "a.png", *QUICK)
    assert code == 0
    assert "warning: 3 probe rays and 0 pixel samples were not numbers" in err


# ---- parts -------------------------------------------------------------------------------------


def test_requests_as_arguments():
    scene = SceneRequest(
        size=(640, 360), look=(0.0, 1.0, 2.0, 3.0, 4.0, 5.0), sky="sunsky", point=((0.0,) * 6, (1.0,) * 6)
    )
    assert scene.arguments() == [
        "--size=640x360", "--look=0.0,1.0,2.0,3.0,4.0,5.0", "--sky=sunsky",
        "--point=0.0,0.0,0.0,0.0,0.0,0.0", "--point=1.0,1.0,1.0,1.0,1.0,1.0",
    ]  # fmt: skip
    settings = SettingsRequest(preset="ctu", set=("a.b=1", "c.d=2"), seed=0, debug=True)
    assert settings.arguments() == ["--preset=ctu", "--set=a.b=1", "--set=c.d=2", "--seed=0", "--debug"]
    assert SceneRequest().arguments() == SettingsRequest().arguments() == []


@pytest.mark.parametrize(
    ("text", "numbers"),
    [("1,2", (1.0, 2.0)), ("-1e3", (-1000.0,)), ("", None), ("1,,2", None), ("nan", None), ("1,inf", None)],
)
def test_numbers(text, numbers):
    assert parse_numbers(text) == numbers


def shown(monkeypatch, terminal: bool) -> str:
    monkeypatch.setattr("ddgi.cli.progress.PATIENCE", 0.01)
    monkeypatch.setattr("ddgi.cli.progress.REDRAW", 0.01)
    text: list[str] = []
    with Progress(text.append, terminal) as progress:
        progress.phase("working", 4)
        progress.step()
        time.sleep(0.2)
        progress.phase("resting")
        time.sleep(0.2)
    return "".join(text)


def test_a_log_has_a_line_now_and_then(monkeypatch):
    monkeypatch.setattr("ddgi.cli.progress.REPEAT", 0.05)
    text = shown(monkeypatch, terminal=False)
    assert "ddgi: working ...\nddgi: working: 1/4, " in text
    assert "resting:" not in text, "nothing is known of how far that is"


def test_progress_on_a_terminal_redraws_and_vanishes(monkeypatch):
    text = shown(monkeypatch, terminal=True)
    assert "working [######                  ] 1/4" in text
    assert text.endswith("\r\x1b[K")


def test_progress_in_a_log_is_one_line_a_phase(monkeypatch):
    assert shown(monkeypatch, terminal=False) == "ddgi: working ...\nddgi: resting ...\n"


def test_quick_work_shows_no_progress():
    text: list[str] = []
    with Progress(text.append, True) as progress:
        progress.phase("working")
    assert text == []


def test_materials_reach_the_scene():
    assert SceneRequest(materials="diffuse").arguments() == ["--materials=diffuse"]
    notes = SceneRequest(materials="diffuse").open("cornell-point").notes
    assert any("taken as diffuse" in note for note in notes)
    assert not any("taken as diffuse" in note for note in SceneRequest().open("cornell-point").notes)


@pytest.mark.slow
def test_a_picture_of_next_to_no_light_says_so(run, tmp_path):
    shapes = '<shape type="sphere"/><emitter type="constant"><rgb name="radiance" value="{}"/></emitter>'
    for radiance, said in ((1.0, False), (1e-6, True)):
        file = tmp_path / "ball.xml"
        file.write_text(f'<scene version="3.0.0">{shapes.format(radiance)}</scene>')
        code, _, err = run("render", file, "-o", tmp_path / "ball.png", *QUICK)
        assert code == 0, err
        assert ("warning: hardly any light" in err) == said


def test_a_damaged_environment_picture_is_named(run, tmp_path):
    picture = tmp_path / "sky.hdr"
    picture.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\nabcdef")
    code, _, err = run("render", "cornell", "-o", tmp_path / "a.png", "--env", picture)
    assert code != 0
    assert "sky.hdr: damaged" in err and "Traceback" not in err
