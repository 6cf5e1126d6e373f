"""A pixel explained, in rooms whose light is known."""

from dataclasses import replace

import numpy as np
import pytest

import ddgi
from ddgi.errors import SettingsError
from ddgi.judge.bars import bars
from ddgi.judge.explain import Explanation, _only, explain, luminance
from ddgi.scene.camera import camera_rays
from probing import camera_in, diffuse, load, rgb, room, small

import mitsuba as mi  # isort: skip  # after the backend's choice


@pytest.fixture(scope="module")
def furnace():
    """A closed room whose walls all shine 1 and reflect half: 2 arrives from everywhere, 1 of it indirectly."""
    lit = room(diffuse(0.5))
    lit["room"]["emitter"] = {"type": "area", "radiance": rgb(1.0)}
    return replace(load(lit), cameras=(camera_in(),))


@pytest.fixture(scope="module")
def found(furnace):
    return explain(furnace, small(direct_area="field"), (16, 12), frames=24, seconds=1)


def test_in_a_furnace_every_step_is_right(found):
    """With its lamps left to the field all light is the field's: 2 pi, half of it straight from the walls."""
    for name, light in found.steps.items():
        assert luminance(light) == pytest.approx(2 * np.pi, rel=0.03), name
    assert found.noise < 0.05


def test_shares_add_up_and_make_the_field(found):
    assert sum(p.share for p in found.probes) == pytest.approx(1, abs=1e-4)
    total = sum(p.share * np.array(p.irradiance) for p in found.probes)
    assert total == pytest.approx(np.array(found.field), rel=1e-3)
    assert sum(p.trilinear for p in found.probes) == pytest.approx(1, abs=1e-4)
    assert all(p.sees for p in found.probes)


def test_it_says_where_probes_stand(furnace, found):
    grid = ddgi.IrradianceField.fit(furnace, small()).volumes[0].grid
    for p in found.probes:
        x, y, z = p.coordinates
        assert p.number == x + grid.counts[0] * (y + grid.counts[1] * z)
        place = np.array(grid.position(mi.UInt32(p.number))).ravel()
        assert p.position == pytest.approx(tuple(place), abs=1e-4)


def test_hidden_probes_are_told():
    """A sheet through the middle: of the probes of a cell that it parts, those beyond do not see the point."""
    t = mi.ScalarTransform4f
    lit = room(diffuse(0.5, two_sided=True)) | {
        "sheet": {"type": "rectangle", "bsdf": diffuse(0.5, two_sided=True), "to_world": t().scale(2)},
        "bulb": {"type": "point", "position": [0.0, 0.5, 0.6], "intensity": rgb(1.0)},
    }
    scene = replace(load(lit), cameras=(camera_in(),))
    s = small(grid_box=((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)), grid_counts=(4, 4, 4), relocation_method="off")
    seen = explain(scene, s, (16, 12), frames=4, seconds=0)
    assert abs(seen.position[2]) < 1e-3, "the pixel shows the sheet"
    behind = [p for p in seen.probes if p.position[2] < 0]
    assert behind and not any(p.sees for p in behind)
    assert sum(p.share for p in behind) < 0.01


def test_its_figures_are_plain(found):
    import json

    assert json.loads(json.dumps(found.figures()))["pixel"] == [16, 12]


def test_probes_know_what_rays_from_them_find(found):
    """In a furnace the same from everywhere, 2 pi; maps and rays agree."""
    for p in found.probes:
        assert p.exact == pytest.approx((2 * np.pi,) * 3, rel=0.03)
        assert p.exact == pytest.approx(p.irradiance, rel=0.05)
        assert p.quiet == pytest.approx(p.exact, rel=0.02)


def test_many_rays_take_the_noise_of_maps_away():
    """Eight rays and no mean over updates: maps of many rays are nearer to what rays from the probes find."""
    lit = room(diffuse(0.5)) | {"bulb": {"type": "point", "position": [0.0, 0.5, 0.6], "intensity": rgb(1.0)}}
    scene = replace(load(lit), cameras=(camera_in(),))
    noisy = small(rays_per_probe=8, blend_hysteresis=0.0, rays_from_lamps=0)
    seen = explain(scene, noisy, (16, 12), frames=4, seconds=0)
    far = lambda p, light: np.abs(np.subtract(light, p.exact)).sum()  # noqa: E731
    told = sum(far(p, p.quiet) for p in seen.probes)
    assert told < 0.3 * sum(far(p, p.irradiance) for p in seen.probes)


def test_errors_are_those_of_the_light_that_is_sent_on(found):
    """Of a red surface red counts alone, whatever its other channels would have to reflect."""
    red = replace(found, albedo=(0.5, 0.0, 0.0), field=(2.0, 9.0, 9.0), reference=(4.0, 1.0, 1.0))
    assert red.errors["field"] == pytest.approx(-0.5)
    assert red.errors["path traced"] == 0
    black = replace(found, albedo=(0.0, 0.0, 0.0))
    assert black.errors["field"] is None


def test_it_says_which_step_is_largest(found):
    one, half = (1.0,) * 3, (0.5,) * 3
    steps = replace(
        found, field=half, quiet=half, exact=half, seen=half, gathered=one, reference=one, noise=0.01
    )
    assert "from true visibility to no probes between" in steps.largest_step
    assert "no step" in replace(steps, gathered_noise=0.6).largest_step
    none = (0.0,) * 3
    dark = replace(steps, field=none, quiet=none, exact=none, seen=none, gathered=none, reference=none)
    assert "no indirect light here, nor is there any" in dark.largest_step
    leak = replace(dark, field=one, quiet=one, exact=one).largest_step
    assert "no indirect light here; the largest step is from exact maps to true visibility" in leak


def test_its_picture_has_longer_bars_for_more_light(found):
    half = replace(found, gathered=tuple(0.5 * x for x in found.gathered))
    lengths = [(bars(x).astype(int).sum(-1) > 300).sum() for x in (found, half)]
    assert lengths[1] < lengths[0]
    dark = replace(
        found,
        field=(0.0,) * 3,
        quiet=(0.0,) * 3,
        exact=(0.0,) * 3,
        seen=(0.0,) * 3,
        gathered=(0.0,) * 3,
        reference=(0.0,) * 3,
    )
    assert bars(dark).ndim == 3
    assert isinstance(dark, Explanation)


@pytest.mark.parametrize("pixel", [(32, 0), (0, 24), (-1, 3)])
def test_pixels_outside_are_refused(furnace, pixel):
    with pytest.raises(SettingsError, match="outside the picture of 32x24"):
        explain(furnace, small(), pixel)


def test_pixels_without_a_surface_are_refused():
    scene = ddgi.load_scene("courtyard", look=(0, 1, 0, 0, 90, 1), size=(16, 16))
    with pytest.raises(SettingsError, match="nothing of the scene"):
        explain(scene, small(), (8, 8))


@pytest.mark.parametrize("scene", ["cornell"])
def test_the_camera_of_a_pixel_looks_through_it(scene):
    camera = ddgi.load_scene(scene, size=(64, 36)).camera
    origin = mi.Point3d(0)
    _, whole = camera_rays(camera, origin, mi.UInt32(40 + 64 * 7), mi.Point2f(0.5))
    small_one = _only(camera, (40, 7))
    _, corner = camera_rays(small_one, origin, mi.UInt32(0), mi.Point2f(0.0))
    middle = np.mean(
        [np.ravel(camera_rays(small_one, origin, mi.UInt32(n), mi.Point2f(0.5))[1]) for n in range(16)], 0
    )
    assert np.allclose(middle / np.linalg.norm(middle), np.ravel(whole), atol=1e-4)
    assert np.allclose(np.ravel(corner), np.ravel(whole), atol=1e-5), (
        "of the middle, which is explained, alone"
    )


@pytest.mark.slow
def test_on_an_edge_the_reference_is_of_the_point_that_is_explained():
    """A floor of black and white squares finer than a pixel: dividing the pixel's mean by a square's colour would blame bounces."""
    squares = {
        "type": "checkerboard", "color0": rgb(0.05), "color1": rgb(0.8),
        "to_uv": mi.ScalarTransform4f().scale([300, 300, 1]),
    }  # fmt: skip
    lit = room(diffuse(0.5)) | {
        "floor": {
            "type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": squares},
            "to_world": mi.ScalarTransform4f().translate([0, -0.9, 0]).rotate([1, 0, 0], -90),
        },
        "bulb": {"type": "point", "position": [0.0, 0.5, 0.6], "intensity": rgb(1.0)},
    }  # fmt: skip
    scene = replace(load(lit), cameras=(camera_in((16, 12)),))
    for x in (6, 7, 8, 9):
        seen = explain(scene, small(), (x, 10), frames=24, seconds=1)
        assert min(seen.albedo) > 0.7 or max(seen.albedo) < 0.1
        assert luminance(seen.reference) == pytest.approx(luminance(seen.gathered), rel=0.15)
