"""Sight: who sees whom in a cell, and what a point believes of it."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.probes import query, sight
from ddgi.probes.field import irradiance
from ddgi.scene.camera import look_at
from ddgi.scene.library.house import house, sealed_room
from ddgi.settings import RenderSettings
from probing import (
    changed,
    dark_light,
    diffuse,
    hand_made,
    lattice,
    load,
    receiver,
    small,
    surfaces_in,
    updated,
)

# ---- between probes ----------------------------------------------------------------------------------


def sheet(**place):
    """A square without thickness, 4 m wide, in the plane z = 0 unless placed elsewhere."""
    return {"type": "rectangle", "bsdf": diffuse(0.5, two_sided=True)} | place


def half_metre_up(size=2.0):
    return {"to_world": mi.ScalarTransform4f().translate([0.5, 0.5, 0.5]).scale([size, size, 1])}


def scene_of(**shapes):
    return load({"type": "scene", "light": dark_light(), **shapes})


def seen_in(scene, counts=(2, 2, 2)):
    """Cells x pairs: whether probes a metre apart, the first at the origin, see one another."""
    bits = np.array(sight.look(scene.tracer, lattice(counts)))
    return (bits[:, None] >> np.arange(len(sight.PAIRS)) & 1).astype(bool)


def test_a_sheet_parts_the_probes_before_it_from_those_behind():
    seen = seen_in(scene_of(sheet=sheet(**half_metre_up())))[0]
    across = np.array([(i ^ j) & 4 != 0 for i, j in sight.PAIRS])  # probe k stands at z = k // 4
    assert (seen == ~across).all()


def test_in_the_open_all_see_one_another():
    assert seen_in(scene_of(far=sheet(to_world=mi.ScalarTransform4f().translate([9, 0, 0])))).all()


def test_cells_are_numbered_like_probes():
    """A sheet in one cell of many: that one alone is parted."""
    scene = scene_of(sheet=sheet(**half_metre_up(0.3)))
    counts = (4, 3, 3)
    seen = seen_in(scene, counts)
    cell = sight.cell_number(lattice(counts), mi.Vector3f(0, 0, 0))
    assert [n for n in range(3 * 2 * 2) if not seen[n].all()] == [int(cell[0])]
    assert int(sight.cell_number(lattice(counts), mi.Vector3f(2, 1, 1))[0]) == 11


# ---- what a point believes ---------------------------------------------------------------------------


def asked(seen, place, normal, tracer=None, kind="rays"):
    """Irradiance over pi at a point of one cell whose probe k has radiance 2^k."""
    s = small(query_sight=kind, query_bias="off", query_visibility=False, query_crush=0.0)
    vol = hand_made(lattice((2, 2, 2)), s, np.repeat(2.0 ** np.arange(8)[:, None], 3, 1))
    vol.sight = mi.UInt32(seen)
    at = receiver(np.array([place]), np.array([normal]), np.array([normal]), [True])
    return float(query.irradiance(vol, at, s.volume, s.query, tracer)[0][0]) / np.pi


ACROSS_Z = sum(1 << bit for bit, (i, j) in enumerate(sight.PAIRS) if (i ^ j) & 4 == 0)
BELOW = (0.5, 0.5, 0.5), (0, 0, -1)
MEAN_BELOW, MEAN = 15 / 4, 255 / 8


def test_probes_behind_a_wall_do_not_count():
    assert asked(ACROSS_Z, *BELOW) == pytest.approx(MEAN_BELOW, rel=1e-4)
    assert asked(ACROSS_Z, *BELOW, kind="cells") == pytest.approx(MEAN_BELOW, rel=1e-4)


def test_probes_behind_an_edge_count():
    """Where those in front see them, as past the edge of a table."""
    with_all = asked(sight.ALL, *BELOW)
    assert with_all == pytest.approx(asked(sight.ALL, *BELOW, kind="maps"), rel=1e-4)
    assert with_all > 1.2 * MEAN_BELOW


def test_where_probes_in_front_do_not_see_one_another_rays_decide():
    """A floor on both sides of a wall: the map of neither side is asked, a ray is."""
    wall = scene_of(
        sheet=sheet(
            to_world=mi.ScalarTransform4f().translate([0.5, 0, 0]).rotate([0, 1, 0], 90).scale([3, 3, 1])
        )
    )
    across_x = sum(1 << bit for bit, (i, j) in enumerate(sight.PAIRS) if (i ^ j) & 1 == 0)
    for x, probes in ((0.45, (4, 6)), (0.55, (5, 7))):
        place, up = (x, 0.5, 0.1), (0, 0, 1)
        # Below the floor's plane, those of the same side may count a little.
        assert asked(across_x, place, up, wall.tracer) < np.mean([2.0**k for k in probes]) * 1.001


def shares_under(size, x, y, z):
    """What the probes count for a floor in one cell, of which it hides the lower half, under a small sheet; it is seen from above."""
    small_sheet = sheet(to_world=mi.ScalarTransform4f().translate([x, y, z]).scale([size, size, 1]))
    below = sheet(
        to_world=mi.ScalarTransform4f().translate([0, 0, -3]).scale([9, 9, 1])
    )  # the origin stays where it is
    scene = scene_of(sheet=small_sheet, below=below)
    s = small(
        query_sight="rays", query_visibility=False, query_crush=0.0
    )  # with a bias: maps are asked from 0.36 m up
    vol = hand_made(lattice((2, 2, 2)), s, np.ones((8, 3)))
    vol.sight = mi.UInt32(ACROSS_Z)
    up = np.array([[0, 0, 1.0]])
    at = receiver(np.array([[0.5, 0.5, 0.05]]), up, up, [True])
    found = query.shares(vol, at, s.volume, s.query, scene.tracer)
    assert [int(number[0]) for number, _ in found] == list(range(8))
    return np.array([float(share[0]) for _, share in found])


def test_what_hides_a_probe_from_the_very_point_counts_though_the_air_before_it_sees_it():
    # Halfway up to 0.2 m, on the way to the probe (1, 1, 1) alone.
    found = shares_under(0.03, 0.579, 0.579, 0.2)
    assert found[7] == 0
    assert found[4:7] == pytest.approx(found[4], rel=1e-4)
    assert found[4] > 0.2


def test_a_point_from_which_nothing_is_seen_asks_from_the_air():
    """As in the folds of a curtain."""
    free = shares_under(0.03, 5, 5, 0.2)
    assert shares_under(0.2, 0.5, 0.5, 0.1) == pytest.approx(free, rel=1e-4)
    assert free[4:].sum() > 0.9


def test_a_point_that_no_probe_sees_is_lit_like_the_air_before_it():
    """All probes of its cell stand behind it: it reads the cell that its viewer looks through."""
    s = small(query_bias="off", query_visibility=False, query_crush=0.0)
    counts = (2, 2, 3)
    vol = hand_made(lattice(counts), s, np.repeat(np.arange(12)[:, None] // 4 + 1.0, 3, 1))
    # A sheet just below the plane of probes z = 1, and a point on its lower side, seen from below.
    scene = scene_of(
        sheet=sheet(to_world=mi.ScalarTransform4f().translate([0.5, 0.5, 0.05]).scale([3, 3, 1]))
    )
    vol.sight = sight.look(scene.tracer, vol.grid)
    up = np.array([[0, 0, 1.0]])
    at = receiver(np.array([[0.5, 0.5, 1.99]]), up, up, [True])
    e = float(query.irradiance(vol, at, s.volume, s.query, scene.tracer)[0][0]) / np.pi
    assert e == pytest.approx(3.0, rel=0.02)


@pytest.mark.parametrize("kind", ["maps", "cells", "rays"])
def test_a_constant_field_stays_one(kind):
    scene = scene_of(sheet=sheet(**half_metre_up(0.8)))
    s = small(query_sight=kind)
    vol = hand_made(lattice((3, 3, 3)), s, np.ones((27, 3)))
    vol.sight = sight.look(scene.tracer, vol.grid)
    rng = np.random.default_rng(4)
    normal = rng.normal(size=(500, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    at = receiver(rng.uniform(0, 2, (500, 3)), normal, normal, np.ones(500, bool))
    e = np.array(query.irradiance(vol, at, s.volume, s.query, scene.tracer)).T
    lit = e[:, 0] > 0  # a point between the sheet and nothing else may be seen by no probe at all
    assert np.allclose(e[lit], np.pi, rtol=1e-4)
    assert lit.mean() > 0.97


# ---- leaks -------------------------------------------------------------------------------------------


def leak(scene, settings, room, ticks=16):
    """Irradiance of surfaces in a room that light cannot reach [W/m^2]: mean and 99.9th percentile."""
    field = updated(scene, settings, ticks)
    found = surfaces_in(scene, *room)
    e = irradiance(field, query.Receiver.on(found), settings.volume, settings.query, scene.tracer)
    y = np.array(mi.luminance(e))[np.array(found.lit)]
    return y.mean(), np.percentile(y, 99.9)


def cube_in_the_open():
    """A closed cube of sheets under an even sky of radiance 1: E = pi outside, 0 inside."""
    scene = load(
        {
            "type": "scene",
            "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [1.0, 1.0, 1.0]}},
            "cube": {"type": "cube", "bsdf": diffuse(0.5, two_sided=True)},
        },
        size=(32, 24),
    )
    scene.cameras = (look_at((0, 0, 4), (0, 0, 0), size=(32, 24)),)
    return scene


@pytest.mark.parametrize("spacing", [0.37, 0.61])
def test_nothing_leaks_through_walls_without_thickness(spacing):
    scene, room = cube_in_the_open(), ((-1, -1, -1), (1, 1, 1))
    s = small(grid_counts=None, grid_spacing=spacing, grid_box=((-1.7, -1.7, -1.7), (1.7, 1.7, 1.7)))
    mean, most = leak(scene, s, room)
    assert mean < 1e-4 * np.pi
    assert most < 1e-3 * np.pi
    by_maps, _ = leak(scene, changed(s, query_sight="maps"), room)
    assert by_maps > 20 * mean  # else this would show nothing


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wall", "spacing"),
    [
        (0.02, 0.5),
        (0.3, 0.5),
        (0.3, 1.0),
        (0.1, 1.0),
        (0.02, 1.0),
        (0.001, 1.0),
    ],
)
def test_the_sealed_room_stays_black(wall, spacing):
    """BLOG's house: mean at most 1e-4, and 99.9 in 100 points at most 1e-3, of what the sun gives outside."""
    sun = 1e4
    scene = load(house(wall=wall, sun_irradiance=sun).description, camera="sealed", size=(32, 24))
    s = changed(RenderSettings.preset("default"), grid_spacing=spacing)
    mean, most = leak(scene, s, sealed_room(wall), ticks=20)
    outside = sun / np.sqrt(0.45**2 + 1 + 0.6**2)
    assert mean < 1e-4 * outside
    assert most < 1e-3 * outside
