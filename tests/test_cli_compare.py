"""`ddgi compare`: what it prints and writes, and how it is asked."""

import json

import mitsuba as mi
import numpy as np
import pytest

from ddgi.cli.compare import _assignments, _trials
from ddgi.cli.request import SettingsRequest
from ddgi.config import load_settings, override
from ddgi.errors import SettingsError
from ddgi.settings import RenderSettings

QUICK = ["--size", "24x16", "--frames", "4", "--set", "grid.budget=64", "--set", "rays.per_probe=16"]


@pytest.fixture(autouse=True, scope="module")
def cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DDGI_CACHE_DIR", str(tmp_path_factory.mktemp("references")))
        yield


@pytest.mark.slow
def test_everything_is_written(run, tmp_path):
    page, figures = tmp_path / "a.png", tmp_path / "a.json"
    code, out, err = run("compare", "cornell-point", "-o", page, "--json", figures, "--target", "0.4", *QUICK)
    assert code == 0, err
    assert "FLIP" in out
    assert "rival, frame" in out
    assert np.array(mi.Bitmap(str(page))).shape[2] == 3
    found = json.loads(figures.read_text())
    assert found["scene"] == "cornell-point"
    assert found["frames"] == 4
    assert found["valid"] is True
    assert 0 < found["flip_mean"] < 1


def test_figures_alone_on_stdout(run):
    code, out, _ = run("compare", "cornell-point", "--json", "-", "--no-rivals", "--target", "0.4", *QUICK)
    assert code == 0
    assert json.loads(out)["rival"] == {}


@pytest.mark.slow
def test_several_configurations(run):
    code, out, err = run(
        "compare", "cornell-point", "--json", "-", "--no-rivals", "--seconds", "0",
        "--presets", "default,classic", "--sweep", "query.crush=0,0.4", *QUICK,
    )  # fmt: skip
    assert code == 0, err
    names = ["default", "default query.crush=0", "default query.crush=0.4"]
    assert list(json.loads(out)["configurations"]) == names + [n.replace("default", "classic") for n in names]


def test_figures_hold_what_it_takes_to_repeat_them(run):
    code, out, _ = run(
        "compare", "cornell-point", "--json", "-", "--no-rivals", "--seconds", "0", "--seed", "7",
        "--sweep", "blend.gamma=5", *QUICK,
    )  # fmt: skip
    assert code == 0
    found = json.loads(out)
    assert found["seed"] == 7
    assert found["backend"] == mi.variant()
    assert found["versions"].keys() == {"ddgi", "mitsuba", "drjit"}
    assert all(found["versions"].values())
    for name, gamma in (("default", 1), ("blend.gamma=5", 5)):
        settings = override(RenderSettings(), found["configurations"][name]["settings"])
        sets = ("grid.budget=64", "rays.per_probe=16", "seed=7", f"blend.gamma={gamma}")
        assert settings == load_settings("default", None, sets)


def test_one_preset_beside_several_is_refused(refused):
    both = ["cornell", "--preset", "default", "--presets", "scale,classic"]
    assert "--preset or --presets, not both" in refused("compare", *both, code=2)


@pytest.mark.slow
def test_frames_that_are_all_warm_up_are_noted(run):
    few = ["compare", "cornell-point", "--no-rivals", "--seconds", "0", *QUICK]
    _, _, err = run(*few, "--sweep", "blend.warm_up=3,4,16")
    noted = [line for line in err.splitlines() if "warm-up" in line]
    assert [line.split(": ")[2] for line in noted] == ["default, blend.warm_up=16", "blend.warm_up=4"]
    assert "4 frames, no more than" in noted[0]


def test_a_noisy_reference_is_said_to_be(run):
    code, out, err = run(
        "compare", "cornell-point", "--no-rivals", "--seconds", "0", "--target", "0.0001", *QUICK
    )
    assert code == 0
    assert "NOT good enough for a target of 0.0001" in out
    assert "too noisy" in err


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("query.crush=0,0.2", ["query.crush=0", "query.crush=0.2"]),
        ("query.wrap = sharp, off", ["query.wrap=sharp", "query.wrap=off"]),
        ("grid.counts=[4,4,4],[8,8,8]", ["grid.counts=[4,4,4]", "grid.counts=[8,8,8]"]),
    ],
)
def test_sweeps_are_taken_apart(text, found):
    assert _assignments(text) == found


@pytest.mark.parametrize("text", ["query.crush", "=1", "query.crush=", "query.crush=1,,2"])
def test_sweeps_that_say_nothing(text):
    with pytest.raises(SettingsError, match="does not read"):
        _assignments(text)


def test_settings_apply_to_every_configuration():
    request = SettingsRequest(set=("rays.per_probe=77",))
    trials = list(_trials(request, "default,scale,default", ("blend.gamma=1,5,1",)))
    assert [t.name for t in trials] == [
        f"{preset} {change}".strip()
        for preset in ("default", "scale")
        for change in ("", "blend.gamma=1", "blend.gamma=5")
    ]
    assert all(t.settings.rays.per_probe == 77 for t in trials)
    assert [t.settings.blend.gamma for t in trials] == [1, 1, 5, 5, 1, 5]
    assert trials[3].settings.query.wrap_offset == 0.2, "scale's own"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["no-such-scene"], "no scene"),
        (["cornell", "--sweep", "query.crush"], "does not read"),
        (["cornell", "--sweep", "query.crsh=1"], "did you mean"),
        (["cornell", "--presets", "default,best"], "unknown preset 'best'"),
        (["cornell", "-o", "a.jpg"], "ends in .png"),
        (["cornell", "-o", "a.exr"], "ends in .png"),
        (["cornell", "--json", "none/a.json"], "there is no folder"),
        (["cornell", "-o", "a.png", "--json", "a.png"], "cannot go to one file"),
    ],
)
def test_bad_input_is_one_line(refused, arguments, message):
    assert message in refused("compare", *arguments)


@pytest.mark.parametrize("value", ["0", "-1", "much", "nan", "inf"])
def test_targets_that_are_none(refused, value):
    assert "--target" in refused("compare", "cornell", "--target", value, code=2)
