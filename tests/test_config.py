"""Settings from outside: what is accepted, what is refused, and in which words."""

import json
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ddgi.config import as_table, load_settings, override, parse_assignment
from ddgi.errors import SettingsError
from ddgi.preset_text import SUMMARIES, to_toml
from ddgi.settings import PRESETS, RenderSettings


@pytest.mark.parametrize("name", PRESETS)
def test_presets_survive_toml(name):
    text = to_toml(PRESETS[name])
    assert override(RenderSettings(), tomllib.loads(text)) == PRESETS[name]
    assert override(PRESETS["mff"], tomllib.loads(text)) == PRESETS[name], "every field is printed"


def test_every_preset_has_a_summary():
    assert SUMMARIES.keys() == PRESETS.keys()


def test_later_sources_win(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text("seed = 7\n[rays]\nper_probe = 64\n[query]\ncrush = 0.1\n")
    s = load_settings("ctu", file, ["query.crush=0.3", "query.crush=0.4"])
    assert (s.seed, s.rays.per_probe, s.query.crush) == (7, 64, 0.4)
    assert s.query.bias == "ctu"


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("grid.counts=[4, 5, 6]", (4, 5, 6)),
        ("grid.counts=4,5,6", (4, 5, 6)),
        ("grid.counts=none", None),
        ("grid.box=[0,0,0],[1,2.5,1]", ((0, 0, 0), (1, 2.5, 1))),
        ("grid.spacing=2", 2.0),
        ("grid.box=[[0,0,0],[1,2.5,1]]", ((0, 0, 0), (1, 2.5, 1))),
        ("tone.exposure=auto", None),
        ("query.wrap=sharp", "sharp"),
        ('query.wrap="sharp"', "sharp"),
        ("query.trilinear=false", False),
        ("blend.gamma=1", 1.0),
    ],
)
def test_assignments(text, value):
    settings = load_settings(assignments=[text])
    for name in text.split("=")[0].split("."):
        settings = getattr(settings, name)
    assert settings == value


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("query.crush=2", "query.crush must be a number from 0 to 1, not 2"),
        ("query.crush=nan", "query.crush must be a number from 0 to 1, not nan"),
        ("grid.spacing=inf", "grid.spacing must be a number above 0 or none, not inf"),
        ("grid.spacing=-1", "grid.spacing must be a number above 0 or none, not -1"),
        ("rays.per_probe=1.5", "rays.per_probe must be a whole number from 8 to 4096, not 1.5"),
        ("rays.per_probe='64'", "not '64'"),
        ("blend.gamma='1.5'", "blend.gamma must be a number from 1 to 16, not '1.5'"),
        ("query.trilinear=1", "query.trilinear must be true or false, not 1"),
        ("query.wrap=round", "one of half_cosine, wrap, sharp, off, not 'round'"),
        ("grid.counts=[1, 2]", "grid.counts must be three whole numbers"),
        ("grid.counts=[1, 2, nan]", "grid.counts"),
        ("grid.box=[[0, 0, 0], [1, inf, 1]]", "grid.box"),
        ("query.crsh=1", "unknown setting query.crsh: did you mean query.crush?"),
        ("quer.crush=1", "unknown setting quer: did you mean query?"),
        ("counts=[1, 2, 3]", "unknown setting counts: did you mean grid.counts?"),
        ("method=off", "did you mean relocation.method or states.method?"),
        ("query.zzz=1", "unknown setting query.zzz: query has trilinear, "),
        ("query=1", "query is a group: set one of query.trilinear"),
        ("query.crush.deep=1", "query.crush must be"),
        ("nonsense", "'nonsense' does not read stage.field=value"),
        ("=1", "does not read"),
        ("query..crush=1", "does not read"),
        ("seed=-1", "seed must be a whole number from 0 to 4294967295, not -1"),
        ("seed=true", "seed must be a whole number"),
        ("seed=1\nquery.crush=0.5", "seed must be a whole number"),
        ("tone.exposure=1979-05-27", "tone.exposure must be"),
    ],
)
def test_refusals_name_the_field(text, message):
    with pytest.raises(SettingsError) as caught:
        load_settings(assignments=[text])
    assert message in str(caught.value)


def test_unknown_preset_lists_the_known_ones():
    with pytest.raises(SettingsError, match=r"unknown preset 'best': choose one of default, fine, scale"):
        load_settings("best")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"[query\ncrush = 1", "not valid TOML"),
        (b"\xff\xfe", "not valid TOML"),
        (b"[query]\ncrush = 3", "query.crush must be"),
        (b"[nothing]\n", "unknown setting nothing"),
        (b"query = 3", "query is a group"),
    ],
)
def test_bad_files(tmp_path, content, message):
    file = tmp_path / "bad.toml"
    file.write_bytes(content)
    with pytest.raises(SettingsError, match=message):
        load_settings(config=file)


def test_unreadable_files(tmp_path):
    with pytest.raises(SettingsError, match=r"none\.toml: there is no such file"):
        load_settings(config=tmp_path / "none.toml")
    with pytest.raises(SettingsError, match="Is a directory"):
        load_settings(config=tmp_path)


def test_an_empty_file_changes_nothing(tmp_path):
    file = tmp_path / "empty.toml"
    file.write_text("")
    assert load_settings(config=file) == RenderSettings()


@given(st.text())
def test_any_text_is_settings_or_a_settings_error(text):
    try:
        load_settings(assignments=[text])
    except SettingsError as error:
        assert str(error)


@given(st.text(alphabet="abc[]{}'\"=1.#\n ,", max_size=20))
def test_values_never_escape_their_field(text):
    table = parse_assignment("query.crush=" + text)
    assert list(table) == ["query"]
    assert list(table["query"]) == ["crush"]


@pytest.mark.parametrize("preset", PRESETS)
def test_settings_as_a_table_read_back(preset):
    settings = load_settings(preset, None, ["grid.counts=[4,5,6]", "tone.exposure=1.5"])
    table = json.loads(json.dumps(as_table(settings)))
    assert table["grid"]["counts"] == [4, 5, 6]
    assert override(RenderSettings(), table) == settings
