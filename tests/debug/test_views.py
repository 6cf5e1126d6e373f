"""Debugging views: what is drawn is what the field has."""

from dataclasses import replace

import mitsuba as mi
import numpy as np
import pytest

import ddgi
from ddgi.cli.debug import VIEWS as OFFERED
from ddgi.debug.spheres import meet
from ddgi.debug.views import VIEWS, look
from ddgi.errors import SettingsError
from ddgi.probes.field import distance_map, irradiance_map
from probing import camera_in, dark_light, diffuse, lattice, load, rgb, room, small


@pytest.fixture(scope="module")
def seen():
    lamp = {"type": "point", "position": [0.4, 0.6, 0.2], "intensity": rgb(2.0)}
    scene = replace(load(room(diffuse(0.6), lamp=lamp)), cameras=(camera_in((48, 36)),))
    return look(scene, small(grid_counts=(3, 4, 5)), 3)


def test_all_views_are_offered():
    assert tuple(VIEWS) == OFFERED


@pytest.mark.parametrize("name", VIEWS)
def test_every_view_is_a_picture(seen, name):
    picture = VIEWS[name](seen)
    assert picture.dtype == np.uint8
    assert picture.ndim == 3
    assert picture.shape[2] == 3


def test_rays_meet_probes_where_they_stand():
    grid = lattice((2, 2, 2)).moved_by(np.eye(8, 3) * 0.25)
    origin = mi.Point3f([-5, -5, -5], [0, 1, 0.5], [0, 1, 0.5])
    ahead = mi.Vector3f([1, 1, 1], [0, 0, 0], [0, 0, 0])
    hits = meet(grid, origin, ahead, 0.1)
    # The first probe was moved to 0.25, its sphere begins 0.1 before; (0, 1, 1) has number 6; between them is nothing.
    assert np.array(hits.distance)[:2] == pytest.approx([5.15, 4.9], abs=1e-4)
    assert np.isinf(np.array(hits.distance)[2])
    assert list(np.array(hits.probe)[:2]) == [0, 6]
    assert np.array(hits.normal).T[0] == pytest.approx([-1, 0, 0], abs=1e-3)
    assert np.array(meet(grid, origin, ahead, 0.1, places=True).distance)[0] == pytest.approx(4.9, abs=1e-4)


def test_things_hide_the_probes_behind_them(seen):
    """From outside the closed room, none is to be seen through its walls."""
    away = replace(seen.scene, cameras=(ddgi.look_at((0, 0, 30), (0, 0, 0), fov=2, size=(48, 36)),))
    outside = look(away, seen.settings, 1)
    assert (VIEWS["probes"](outside) == 0).all(), "the walls are black from behind"
    assert (VIEWS["probes"](seen) != VIEWS["weights"](seen)).any()


def test_atlases_hold_every_map_once(seen):
    field, s = seen.done.field, seen.settings
    nx, ny, nz = field.volumes[0].grid.counts
    for name, maps in (
        ("irradiance-atlas", irradiance_map(field, s)),
        ("distance-atlas", distance_map(field, s)),
    ):
        picture, size = VIEWS[name](seen), maps.shape[1]
        assert picture.shape[0] * picture.shape[1] >= nx * ny * nz * size * size
        first = picture[:size, :size].astype(float).mean(-1)
        there = maps[0, ..., 0]
        assert np.corrcoef(first.ravel(), there.ravel())[0, 1] > 0.8


def test_moved_probes_stand_out():
    """A buried plane of probes is moved out, and drawn in warm colours; left in its place it is blue."""
    t = mi.ScalarTransform4f
    scene = load({
        "type": "scene",
        "light": dark_light(),
        "floor": {"type": "rectangle", "bsdf": diffuse(0.5, two_sided=True), "to_world": t().rotate([1, 0, 0], -90).scale(4)},
    })  # fmt: skip
    camera = ddgi.look_at((0.2, 1.5, 3.5), (0, 0, 0), fov=70, size=(64, 48))
    box = {"grid_box": ((-1.5, -0.3, -1.5), (1.5, 1.4, 1.5)), "grid_counts": (4, 2, 4), "grid_margin": 0.0}
    warm = []
    for method in ("receivers", "off"):
        picture = VIEWS["offsets"](
            look(replace(scene, cameras=(camera,)), small(**box, relocation_method=method), 1)
        )
        warm.append((picture[..., 0].astype(int) > picture[..., 2].astype(int) + 20).sum())
    assert warm[0] > 20
    assert warm[1] == 0


def test_an_atlas_too_large_is_refused(seen, monkeypatch):
    monkeypatch.setattr("ddgi.debug.atlas.LARGEST", 100)
    with pytest.raises(SettingsError, match="use fewer probes"):
        VIEWS["distance-atlas"](seen)
