"""`ddgi bench`: that every preset can be measured, and that its figures agree with each other."""

import json

import pytest

SMALL = ["--no-starts", "--size", "32x18", "--set", "grid.counts=[4,4,4]", "--set", "rays.per_probe=16"]
STAGES = {
    "spawn rays",
    "trace and shade",
    "blend irradiance",
    "blend distance",
    "camera rays",
    "field in pixels",
    "light pixels",
}

OURS = {"light paths", "see lamplit points", "blend radiance"}


@pytest.mark.parametrize(
    ("preset", "more"),
    [("default", OURS), ("fine", OURS), ("scale", set())],
)
def test_figures(run, tmp_path, preset, more):
    file = tmp_path / "bench.json"
    code, out, err = run("bench", "cornell-point", *SMALL, "--preset", preset, "--json", file)
    assert code == 0, err
    figures = json.loads(file.read_text())["scenes"]["cornell-point"]
    assert set(figures["stages"]) == STAGES | more | {"add to picture"}
    assert figures["update_over_limit"] == pytest.approx(figures["update_ms"] / figures["limit_ms"])
    assert figures["frame_ms"] > 0 and figures["overhead_ms"] > 0
    assert "update / limit" in out
