"""Where planes of probes stand to the walls they light."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.probes import walls
from ddgi.probes.field import IrradianceField
from ddgi.probes.walls import Walls
from ddgi.scene.load import load_scene
from probing import diffuse, load, rgb, small


def across(*places_and_facings):
    place, facing = map(np.array, zip(*places_and_facings, strict=True))
    return Walls(place.astype(float), facing.astype(float), np.full(len(place), 1 / len(place)))


def planes(low, high, count, below, above):
    spacing = (high - low) / (count - 1 - below - above)
    return low - below * spacing + spacing * np.arange(count), spacing


def test_rays_find_the_walls_of_a_box():
    """Cornell's floor and ceiling face each other across y; its open front is no wall across z."""
    scene = load_scene("cornell-point")
    _, y, z = walls.find(scene.tracer, scene.box)
    assert {(round(float(p), 2), int(f)) for p, f in zip(y.place, y.facing, strict=True)} >= {
        (-1.0, 1),
        (1.0, -1),
    }
    assert sum(w.share.sum() for w in (y, z)) == pytest.approx(2.0)
    assert not any(p > 0.99 and f < 0 for p, f in zip(z.place, z.facing, strict=True))


def test_outermost_planes_hover_inside_the_walls_of_a_room():
    below, above = walls.best_margins(across((0.0, 1), (4.0, -1)), 0.0, 4.0, 9)
    first = planes(0.0, 4.0, 9, below, above)[0]
    spacing = first[1] - first[0]
    assert 0.04 <= first[0] / spacing <= 0.15
    assert 0.04 <= (4.0 - first[-1]) / spacing <= 0.15


@pytest.mark.parametrize("inner", np.linspace(1.0, 3.0, 9))
def test_no_plane_stands_in_a_wall(inner):
    """A partition 0.1 m thick somewhere between two outer walls."""
    seen = across((0.0, 1), (4.0, -1), (inner - 0.05, -1), (inner + 0.05, 1))
    at, spacing = planes(0.0, 4.0, 9, *walls.best_margins(seen, 0.0, 4.0, 9))
    assert np.abs(at[:, None] - seen.place).min() > 0.03 * spacing


def test_nothing_seen_leaves_the_planes_just_inside_the_box():
    empty = Walls(np.zeros(0), np.zeros(0), np.zeros(0))
    assert walls.best_margins(empty, 0.0, 1.0, 5) == (-0.1, -0.1)


@pytest.mark.parametrize("two_sided", [False, True])
def test_an_object_seen_from_outside_has_probes_outside(two_sided):
    """Planes just in front of the faces that the camera sees; else only probes inside would light them."""
    cube = {"type": "cube", "bsdf": diffuse(0.5, two_sided=two_sided)}
    sky = {"type": "constant", "radiance": rgb(1.0)}
    scene = load({"type": "scene", "cube": cube, "sky": sky}, look=(4, 3, 5, 0, 0, 0), up="y")
    field = IrradianceField.fit(scene, small(grid_counts=None))
    layout = field.volumes[0].grid
    last = np.ravel(layout.position(mi.UInt32(layout.size - 1)))
    ahead = (last - 1) / np.ravel(layout.spacing)
    assert ((ahead > 0.02) & (ahead < 0.3)).all()
