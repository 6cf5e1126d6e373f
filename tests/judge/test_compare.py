"""A comparison from end to end, on pictures small enough to be quick."""

from dataclasses import replace

import numpy as np
import pytest

import ddgi
from ddgi.config import load_settings
from ddgi.errors import DDGIError
from ddgi.judge import denoiser, sheet
from ddgi.judge.cache import Key
from ddgi.judge.compare import _doubts, _still_dark, compare
from ddgi.judge.false_colour import BLUE_RED, INFERNO, coloured
from ddgi.judge.lettering import text_width, wrapped
from ddgi.judge.path_tracer import PathTracer, Samples
from ddgi.judge.rival import in_steps, kept_samples, sample_ms, samples_in
from ddgi.judge.table import DOUBTED, front, reference_lines, table
from ddgi.judge.trial import Trial, run
from ddgi.judge.view import look, remarks
from ddgi.scene.camera import look_at

QUICK = ("rays.per_probe=32", "grid.budget=200")


def trial(name: str, *sets: str) -> Trial:
    return Trial(name, load_settings("default", None, (*QUICK, *sets)))


@pytest.fixture(scope="module")
def scene():
    return ddgi.load_scene("cornell-point", size=(40, 40))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("references")


@pytest.fixture(scope="module")
def found(scene, folder):
    trials = [
        trial("default"),
        trial("no field", "gather.energy_preservation=0"),
        trial("leaky", "query.visibility=false"),
    ]
    return compare(scene, trials, frames=24, target=0.1, most_seconds=30, folder=folder)


def test_figures_are_those_of_the_contract(found):
    figures = found.figures()
    assert figures.keys() >= {
        "flip_mean", "flip_p99", "reference_flip", "luminance_error", "rel_mse", "mff_mean", "mff_max",
        "reference_spp", "reference_luminance", "reference_rel_mse", "rival", "frames", "valid",
        "leak", "dark",
    }  # fmt: skip
    for name in ("leak", "dark"):
        assert figures[name].keys() == {"mean", "max"}
    for name in ("frame", "still"):
        assert figures["rival"][name].keys() == {"spp", "flip_mean", "time_ms", "denoise_ms"}
    assert figures["valid"] is True
    assert figures["frames"] == 24
    assert list(figures["configurations"]) == ["default", "no field", "leaky"]
    assert figures["configurations"]["default"]["flip_mean"] == figures["flip_mean"]


def test_light_that_bounces_once_only_is_found_too_dark(found):
    full, once, _ = found.judged
    assert abs(full.difference.luminance_error) < 0.05
    assert once.difference.luminance_error < -0.05
    assert once.difference.flip_mean > full.difference.flip_mean


def test_parts_add_up(found):
    for j in found.judged:
        np.testing.assert_allclose(j.outcome.direct + j.outcome.indirect, j.outcome.picture, atol=1e-5)
    direct_only = found.reference.direct
    assert 0.3 < direct_only.mean() / found.reference.picture.mean() < 0.9
    np.testing.assert_allclose(found.judged[0].outcome.direct.mean(), direct_only.mean(), rtol=0.02)


def test_a_rival_with_more_time_is_better(found):
    assert found.rivals["still"].spp > found.rivals["frame"].spp
    assert found.rivals["still"].difference.flip_mean < found.rivals["frame"].difference.flip_mean


def test_rivals_get_as_many_samples_as_fit():
    assert samples_in(100, 40) == 2
    assert samples_in(100, 41) == 2
    assert samples_in(10, 40) == 1, "one at least"


@pytest.mark.parametrize(
    "spp, step", [(1, 1), (7, 7), (8, 8), (298, 304), (330, 304), (340, 362), (4096, 4096)]
)
def test_long_rivals_go_in_steps_of_a_quarter_octave(spp, step):
    assert in_steps(spp) == step


def test_a_long_rival_is_traced_once(scene, tmp_path):
    """Later it comes from the cache, and a damaged file is made anew."""

    class Counted(PathTracer):
        renders = 0

        def render(self, camera, spp, seed):
            self.renders += 1
            return super().render(camera, spp, seed)

    tracer, key = Counted(scene), Key.of(scene, scene.camera, tmp_path)

    def traced():
        return kept_samples(tracer, scene.camera, 8, 7, 2.5, key)

    first, again = traced(), traced()
    assert tracer.renders == 1
    assert np.array_equal(first.picture, again.picture)
    assert (again.spp, again.ms) == (8, 20.0), "the time is what 8 samples take now"
    (file,) = tmp_path.iterdir()
    file.write_bytes(b"no picture")
    assert np.array_equal(traced().picture, first.picture)
    assert tracer.renders == 2


def test_a_folder_that_takes_no_files_costs_no_rival(scene, tmp_path):
    (tmp_path / "file").write_text("")
    key = Key.of(scene, scene.camera, tmp_path / "file")
    assert kept_samples(PathTracer(scene), scene.camera, 4, 7, 2.5, key).spp == 4


def test_a_sample_costs_what_one_more_takes():
    """A tracer that needs 5 ms to start and 2 for each sample."""

    class Slow:
        def render(self, camera, spp, seed):
            return Samples(np.zeros((1, 1, 3)), spp, 5.0 + 2.0 * spp)

    assert sample_ms(Slow(), None) == pytest.approx(2.0)


@pytest.mark.parametrize("frames, told", [(10, True), (400, False)])
def test_without_a_warm_up_the_dark_start_is_told_of(found, frames, told):
    settings = ddgi.RenderSettings.preset("scale")
    outcome = replace(found.judged[0].outcome, trial=Trial("scale", settings), frames=frames)
    lines = _still_dark([replace(found.judged[0], outcome=outcome)])
    assert bool(lines) == told
    assert all("blend.warm_up" in line for line in lines)


def test_too_bright_pictures_point_at_leaks(found):
    bright = replace(found.judged[0].difference, luminance_error=0.08)
    assert not any("leak" in line for line in _doubts(found.reference, 0.1, found.judged))
    for sight, told in (
        ("maps", True),
        ("rays", False),
    ):  # where rays find out what is hidden it is something else
        outcome = replace(found.judged[0].outcome, trial=trial(sight, f"query.sight={sight}"))
        doubts = _doubts(found.reference, 0.1, [replace(found.judged[0], outcome=outcome, difference=bright)])
        assert any("ddgi info" in line for line in doubts) == told


def test_tone_is_said_to_change_nothing(found):
    darker = trial("darker", "tone.exposure=-2")
    outcome = replace(found.judged[0].outcome, trial=darker)
    assert not any("tone" in line for line in found.notes)
    doubts = _doubts(found.reference, 0.1, [replace(found.judged[0], outcome=outcome)])
    assert any("tone" in line for line in doubts)


@pytest.mark.parametrize("empty, told", [(0.05, False), (0.4, True), (1.0, True)])
def test_empty_pixels_are_told_of(scene, empty, told):
    assert bool(remarks(replace(look(scene), empty=empty))) == told


def test_table_names_every_configuration_and_the_front(found):
    text = table(found)
    for name in ("default", "no field", "leaky", "rival, frame", "rival, still", "good enough"):
        assert name in text
    assert "NOT good enough" not in text
    assert f"rel. MSE + {found.reference.rel_mse_noise:.4f}" in text


def test_figures_that_the_reference_cannot_carry_are_marked(found):
    noisy = replace(found, reference=replace(found.reference, noise=10.0))
    marked = table(noisy)
    assert f"{found.judged[0].difference.flip_mean:.4f}{DOUBTED}" in marked
    assert "own noise may be more than half" in marked
    exact = table(replace(found, reference=replace(found.reference, noise=0.0)))
    assert DOUBTED not in exact


def test_rivals_stand_beside_the_time_of_ours(found):
    first, r = found.judged[0], found.rivals["still"]
    whole = first.outcome.frame_ms * first.outcome.frames
    (line,) = [line for line in table(found).splitlines() if line.startswith("rival, still")]
    assert f"in {r.ms:.0f} ms" in line
    assert f"default in {whole:.0f} ms: {first.difference.flip_mean:.4f}" in line


@pytest.mark.parametrize("seconds", [0.0, 0.5])
def test_a_noisy_reference_says_what_it_lacks(found, seconds):
    """Four times the noise that is allowed: 16 times the samples, of which one part is there."""
    truth = replace(found.reference, noise=0.2, spp=10, sample_seconds=seconds)
    (line,) = _doubts(truth, 0.1, found.judged)[:1]
    assert "takes 16 times the samples" in line
    assert ("some 75 s" in line) == (seconds > 0)


def test_where_a_reference_comes_from_is_said(found):
    def said(**change):
        return "\n".join(reference_lines(replace(found, reference=replace(found.reference, **change))))

    assert "(new)" in said(spp=64, fresh=64)
    assert "(kept from before)" in said(spp=64, fresh=0)
    assert "(48 of them new)" in said(spp=64, fresh=48)


def test_differences_within_the_noise_of_timing_decide_nothing(found):
    one = found.judged[0]
    slower = replace(one, outcome=replace(one.outcome, frame_ms=1.05 * one.outcome.frame_ms))
    worse = replace(one, difference=replace(one.difference, flip_mean=1.01 * one.difference.flip_mean))
    assert front([one, slower, worse], 0.0) == {0, 1, 2}
    both = replace(one, difference=replace(one.difference, flip_mean=1.1 * one.difference.flip_mean))
    assert front([one, both], 0.0) == {0}
    assert front([one, both], one.difference.flip_mean) == {0, 1}  # the reference cannot tell them apart


def test_the_front_holds_what_nothing_beats(found):
    one, two, three = found.judged
    cheap = replace(two, outcome=replace(two.outcome, frame_ms=one.outcome.frame_ms / 2))
    dear = replace(
        three,
        difference=replace(three.difference, flip_mean=1.0),
        outcome=replace(three.outcome, frame_ms=1e6),
    )
    assert front([one, cheap, dear], 0.0) == {0, 1}


def test_a_configuration_that_comes_twice_is_rendered_once(scene, folder):
    twice = [trial("one"), trial("again")]
    first, second = compare(scene, twice, frames=2, rivals=False, most_seconds=0, folder=folder).judged
    assert [first.outcome.trial.name, second.outcome.trial.name] == ["one", "again"]
    assert first.outcome.picture is second.outcome.picture


def test_sheet_shows_every_configuration(found):
    page = sheet.sheet(found)
    rows, columns = 4, 5
    times = -(-sheet.NARROWEST // 40)  # tiny pictures are shown larger
    assert page.dtype == np.uint8
    pictures = rows * (40 * times + sheet.CAPTION + sheet.GAP) + sheet.GAP
    assert page.shape[0] >= pictures + 3 * sheet.CAPTION, "three lines at the foot"
    assert (page[pictures:] != sheet.BACKGROUND).any(-1).mean() > 0.01, "with something in them"
    assert page.shape[1] >= columns * (40 * times + sheet.GAP) + sheet.GAP


def test_captions_keep_apart_on_tiny_pictures():
    def row(*captions):
        return [sheet.Tile(caption, np.full((9, 16, 3), 99, np.uint8)) for caption in captions]

    page = sheet.laid_out(
        [row("a caption that is a good deal wider than its picture", "b"), row("c")], ["foot"]
    )
    line = page[sheet.GAP : sheet.GAP + sheet.CAPTION]
    written = np.flatnonzero((line != sheet.BACKGROUND).any((0, 2)))
    picture = np.flatnonzero((page[sheet.GAP + sheet.CAPTION] == 99).all(-1))
    second = picture[16 * -(-sheet.NARROWEST // 16)]
    assert written[-1] >= second, "the second caption stands over its own picture"
    assert written[written < second][-1] < second - sheet.GAP, "and the first has ended by then"


def test_lines_at_the_foot_are_as_wide_as_there_is_room():
    text = "red is too bright, blue too dark"
    lines = list(wrapped(text, 90))
    assert len(lines) > 1
    assert all(text_width(line) <= 90 for line in lines)
    assert " ".join(lines) == text
    assert list(wrapped(text, 10**4)) == [text]
    assert list(wrapped("word", 1)) == ["word"]


def test_colours_of_errors():
    none, some, much, unknown = coloured(np.array([[0.0, 0.5, 1.0, np.nan]]), INFERNO).sum(-1)[0]
    assert unknown == none < some < much
    blue, white, red = coloured(np.array([[0.0, 0.5, 1.0]]), BLUE_RED)[0]
    assert blue[2] > blue[0]
    assert red[0] > red[2]
    assert white.min() > 0.95
    reference = np.full((2, 2, 3), 0.5)
    assert (sheet.relative_excess(reference * 1.2, reference) > 0.1).all()
    assert (sheet.relative_excess(reference * 0.8, reference) < -0.1).all()


def test_a_reference_too_noisy_is_said_to_be(scene, tmp_path):
    found = compare(
        scene, [trial("default")], frames=2, target=1e-3, most_seconds=0, rivals=False, folder=tmp_path
    )
    assert not found.valid
    assert any("too noisy for a target of 0.001" in note for note in found.notes)
    assert "NOT good enough" in table(found)
    assert found.figures()["rival"] == {}


def test_a_black_scene_has_an_answer(tmp_path):
    import mitsuba as mi

    ddgi.use_backend("auto")
    black = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}
    lamp = {"type": "point", "position": [0, 0, -5], "intensity": {"type": "rgb", "value": 1.0}}
    description = {"type": "scene", "card": {"type": "rectangle", "bsdf": black}, "lamp": lamp}
    view = look_at((0, 0, 1), (0, 0, 0), fov=40, size=(16, 16))
    scene = ddgi.load_scene(description, camera=view)
    assert isinstance(scene.mi_scene, mi.Scene)
    found = compare(scene, [trial("default")], frames=2, most_seconds=5, rivals=False, folder=tmp_path)
    assert found.figures()["flip_mean"] == 0
    assert found.figures()["luminance_error"] == 0
    assert "the reference is black: there is nothing to compare with" in found.notes
    assert "FLIP" not in table(found)  # nor figures that look perfect
    assert not any("too noisy" in note for note in found.notes)
    assert "nothing to compare with" in table(found) and "good enough" not in table(found)
    assert not found.valid, "nothing to be right about"
    assert sheet.sheet(found).size > 0


def test_a_camera_inside_a_wall_is_noticed(tmp_path):
    inside = look_at((0.33, -0.7, 0.37), (0.33, -0.7, 0), fov=60, size=(16, 16))  # in the short block
    scene = ddgi.load_scene("cornell-point", camera=inside)
    found = compare(
        scene, [trial("default")], frames=2, target=10, most_seconds=0, rivals=False, folder=tmp_path
    )
    assert any("from behind: does the camera stand inside a wall?" in note for note in found.notes)


def test_without_a_denoiser_there_is_no_rival(scene, folder, monkeypatch):
    monkeypatch.setattr(denoiser, "installed", lambda: False)
    found = compare(scene, [trial("default")], frames=2, target=0.1, most_seconds=0, folder=folder)
    assert found.rivals == {}
    assert any("pip install mitsuba-oidn" in note for note in found.notes)


def test_what_is_not_installed_is_named(found, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "PIL", None)
    with pytest.raises(DDGIError, match="pip install pillow"):
        sheet.sheet(found)
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    assert not denoiser.installed()
    with pytest.raises(DDGIError, match="pip install mitsuba-oidn"):
        denoiser.denoise(np.zeros((4, 4, 3)), denoiser.Guides(np.zeros((4, 4, 3)), np.zeros((4, 4, 3))))


def test_denoising_removes_noise():
    truth = np.full((64, 64, 3), 0.5, np.float32)
    noisy = truth + np.random.default_rng(0).normal(0, 0.1, truth.shape).astype(np.float32)
    guides = denoiser.Guides(np.full_like(truth, 0.5), np.tile(np.float32([0, 0, 1]), (64, 64, 1)))
    clean, ms = denoiser.denoise(noisy, guides)
    assert np.abs(clean - truth).mean() < 0.2 * np.abs(noisy - truth).mean()
    assert ms > 0


def test_nothing_to_compare_is_refused(scene, tmp_path):
    for trials, frames in (([], 4), ([trial("default")], 0)):
        with pytest.raises(ddgi.SettingsError, match="at least"):
            compare(scene, trials, frames=frames, folder=tmp_path)


def test_a_single_frame_is_the_converged_fields(scene):
    outcome = run(scene, trial("default"), 12)
    assert outcome.frames == 12
    assert outcome.single.mean() == pytest.approx(outcome.picture.mean(), rel=0.05)
    assert outcome.non_finite == 0
