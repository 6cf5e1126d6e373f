"""Relocation: probes leave bad places, never by more than half a spacing."""

from dataclasses import replace

import mitsuba as mi
import numpy as np
import pytest

from ddgi import frame
from ddgi.errors import SettingsError
from ddgi.probes import openness, placement, receivers, region, relocation
from ddgi.probes.field import IrradianceField, irradiance_map
from ddgi.probes.relocation import Settings, relocate
from ddgi.probes.surroundings import look_around
from ddgi.scene.camera import look_at
from ddgi.settings import RenderSettings
from probing import changed, dark_light, diffuse, lattice, load, small

METHODS = ("receivers", "scale", "mff")
HOW = {
    "receivers": {},
    "scale": {"iterations": 5, "clearance": 0.1},
    "mff": {"iterations": 50, "clearance": 0.1},
}


def settings(method, **other):
    return Settings(method=method, **(HOW[method] | other))


def in_a_room(inwards=True, **shapes):
    """A room of 4 m around [1, 1, 1] with things in it. Its faces look in, or all turned away."""
    room = {
        "type": "cube",
        "to_world": mi.ScalarTransform4f().translate([1, 1, 1]).scale(2),
        "flip_normals": inwards,
    }
    shapes = {n: dict(s, flip_normals=not inwards) for n, s in shapes.items()}
    return load(
        {
            "type": "scene",
            "light": dark_light() | {"position": [1.0, 2.5, 1.0]},
            "room": room | {"bsdf": diffuse(0.6, two_sided=True)},
            **{n: s | {"bsdf": diffuse(0.6, two_sided=True)} for n, s in shapes.items()},
        }
    )


def box(low, high):
    low, high = np.array(low), np.array(high)
    return {
        "type": "cube",
        "to_world": mi.ScalarTransform4f().translate(list((low + high) / 2)).scale(list((high - low) / 2)),
    }


def cameras_in_it():
    """From two corners of the room."""
    return look_at((-0.7, 2.6, 2.7), (0.7, 0.6, 0.5), fov=80), look_at((-0.7, 2.4, -0.6), (1, 1, 1), fov=80)


def moved(scene, s, grid=None, cameras=None):
    """Offsets (P, 3) of a metre's lattice of 3x3x3 from the origin."""
    grid, cameras = grid or lattice(), cameras or cameras_in_it()
    found = relocate(scene.tracer, grid, region.look(scene.tracer, cameras), s)
    if found.offset is None:
        return np.zeros((grid.size, 3))
    return np.array(found.offset).reshape(-1, 4)[:, :3]


PILLAR = (0.7, -1, 0.6), (1.2, 3, 1.4)
"""Around the probes 10, 13 and 16, at (1, y, 1); its nearest side is 0.2 to the right."""
WALL = (0.8, -1, -1), (2.9, 3, 3)
"""Around those at x = 1 and x = 2."""


def inside(place, low, high):
    return ((place > np.array(low)) & (place < np.array(high))).all(-1)


def behind_a_wall():
    """A grid whose first plane of nine probes is 0.2 deep in the wall, and whose second is out of reach of its face."""
    return lattice((2, 3, 3), (1, 0, 0))


def stand(offset, grid=None):
    """Where the probes of the lattice, or another grid, stand."""
    grid = grid or lattice()
    return np.array(grid.place(mi.UInt32(np.arange(grid.size)))).T + offset


@pytest.mark.parametrize("method", METHODS)
def test_probes_leave_a_thick_wall(method):
    """Those 0.2 behind its face come out, or with receivers as many as light all of it; those deeper in cannot."""
    grid = behind_a_wall()
    found = inside(stand(moved(in_a_room(wall=box(*WALL)), settings(method), grid), grid), *WALL)
    assert found[::2].sum() <= (3 if method == "receivers" else 0)
    assert found[1::2].all()


@pytest.mark.parametrize("method", METHODS)
def test_none_comes_to_its_neighbours_half(method):
    """Whatever stands around."""
    rng = np.random.default_rng(5)
    lows = rng.uniform(-0.5, 2, (40, 3))
    scene = in_a_room(**{f"b{i}": box(low, low + rng.uniform(0.05, 0.6, 3)) for i, low in enumerate(lows)})
    for limit in (0.2, 0.45):
        offset = moved(scene, settings(method, limit=limit))
        assert 0 < np.abs(offset).max() <= limit * 1.0001


def test_faces_that_look_the_wrong_way_do_not_matter_to_receivers():
    """All turned away: SCALE leaves probes in the wall, whose inside it takes for the open; ours moves them."""
    scene, grid = in_a_room(inwards=False, wall=box(*WALL)), behind_a_wall()
    assert inside(stand(moved(scene, settings("scale"), grid), grid), *WALL)[::2].all()
    assert inside(stand(moved(scene, settings("receivers"), grid), grid), *WALL)[::2].mean() < 0.4


def test_probes_that_others_stand_in_for_stay():
    """In front of the same wall stands another plane: interpolation from where the grid has probes is worth more."""
    offset = moved(in_a_room(wall=box(*WALL)), settings("receivers"))
    assert (offset == 0).all(-1).mean() > 0.6


def test_sheets_without_thickness_part_those_behind_from_the_light():
    """Probes a little outside the walls of a room of sheets, which no face tells: ours brings them in."""
    walls = load(
        {
            "type": "scene",
            "light": dark_light() | {"position": [1.0, 1.0, 1.0]},
            "room": {
                "type": "cube",
                "to_world": mi.ScalarTransform4f().translate([1, 1, 1]).scale(0.9),
                "bsdf": diffuse(0.6, two_sided=True),
            },
        }
    )
    camera = look_at((1.6, 1.5, 1.6), (0.6, 0.5, 0.6), fov=80)
    offset = moved(walls, settings("receivers"), cameras=(camera,))
    faces = [4, 10, 12, 14, 16, 22]  # opposite the middle of each wall
    assert inside(stand(offset)[faces], (0.1, 0.1, 0.1), (1.9, 1.9, 1.9)).all()


@pytest.mark.parametrize("method", METHODS)
def test_probes_in_the_open_stay(method):
    scene = in_a_room()
    assert not moved(scene, settings(method)).any()


def test_scale_goes_through_the_nearest_back_face():
    """At (1, 1, 1) the pillar's right side is the nearest, 0.2 away: twice that far, straight ahead as rays allow."""
    offset = moved(in_a_room(pillar=box(*PILLAR)), settings("scale", rays=1024, iterations=1))
    assert offset[13] == pytest.approx([0.4, 0, 0], abs=0.03)


def test_scale_leaves_near_fronts_towards_the_farthest():
    """A probe 5 cm above a table moves up, by fifths of a spacing, until it is clear."""
    scene = in_a_room(table=box((0.5, 0.5, 0.5), (1.5, 0.95, 1.5)))
    offset = moved(scene, settings("scale", rays=256))
    assert offset[13][1] > 0.05
    assert not moved(scene, settings("scale", rays=256, clearance=0.01))[13].any()


def test_mff_moves_along_an_axis():
    offset = moved(in_a_room(pillar=box(*PILLAR)), settings("mff"))
    assert ((offset != 0).sum(-1) <= 1).all()
    # Steps of a quarter of 0.45 to the right, the first axis tried: 0.225 is 2 cm outside, 0.3375 beyond the clearance.
    assert offset[13] == pytest.approx([0.3375, 0, 0], abs=1e-3)


def test_mff_moves_after_it_is_certain():
    """With much hysteresis the same few iterations move nothing yet."""
    scene = in_a_room(pillar=box(*PILLAR))
    assert moved(scene, settings("mff", iterations=4))[13].any()
    assert not moved(scene, settings("mff", iterations=4, certainty_hysteresis=0.95)).any()


@pytest.mark.parametrize("method", METHODS)
def test_the_same_scene_gives_the_same_places(method):
    scene = in_a_room(pillar=box(*PILLAR))
    assert (moved(scene, settings(method)) == moved(scene, settings(method))).all()


def test_more_iterations_move_settled_probes_no_further():
    scene = in_a_room(pillar=box(*PILLAR))
    assert np.allclose(
        moved(scene, settings("receivers", iterations=4)), moved(scene, settings("receivers", iterations=8))
    )


def test_where_cameras_see_nothing_probes_stay():
    scene = in_a_room(pillar=box(*PILLAR))
    away = look_at((0, 50, 0), (0, 90, 0.1), fov=20)
    assert not moved(scene, settings("receivers"), cameras=(away,)).any()
    assert receivers.find(scene.tracer, lattice(), region.look(scene.tracer, (away,))) is None


def test_a_clearance_keeps_probes_off_surfaces():
    """A probe 3 cm above a table leaves it only if that is too near."""
    scene = in_a_room(table=box((0.5, 0.5, 0.5), (1.5, 0.97, 1.5)))
    near, clear = (moved(scene, settings("receivers", clearance=c))[13] for c in (0.0, 0.12))
    assert clear[1] > near[1] + 0.05


def test_a_probe_leaves_a_slit_for_the_room_that_its_receivers_have(monkeypatch):
    """The probe between two boards is seen from the room's walls, but sees little of what they see."""
    boards = {
        "left": box((0.85, 0.7, 0.7), (0.9, 1.3, 1.3)),
        "right": box((1.1, 0.7, 0.7), (1.15, 1.3, 1.3)),
    }
    scene = in_a_room(**boards)

    def room(offset):
        at = mi.Point3f(stand(offset)[[13]].T)
        return np.array(openness.of_places(scene.tracer, at, placement.NEARBY).facing).min()

    there = moved(scene, settings("receivers", clearance=0.0))
    monkeypatch.setattr(placement, "UNLIKE", 0.0)
    here = moved(scene, settings("receivers", clearance=0.0))
    assert room(there) > room(here) + 0.05


@pytest.mark.parametrize("counts", [(2, 2, 2), (2, 5, 2)])
def test_thin_grids_are_relocated_too(counts):
    offset = moved(in_a_room(pillar=box(*PILLAR)), settings("receivers"), lattice(counts))
    assert np.isfinite(offset).all()


def test_a_field_has_its_probes_where_they_were_moved():
    scene = replace(in_a_room(wall=box(*WALL)), cameras=cameras_in_it())
    box_, counts = ((1.0, 0.0, 0.0), (2.0, 2.0, 2.0)), (2, 3, 3)
    there, here = (
        IrradianceField.fit(
            scene, small(grid_box=box_, grid_counts=counts, grid_margin=0.0, relocation_method=method)
        ).volumes[0].grid
        for method in ("receivers", "off")
    )  # fmt: skip
    numbers = mi.UInt32(np.arange(18))
    assert here.offset is None
    assert np.allclose(np.array(here.position(numbers)), np.array(there.place(numbers)))
    assert inside(np.array(here.position(numbers)).T, *WALL).sum() == 18
    assert inside(np.array(there.position(numbers)).T, *WALL).sum() <= 12


@pytest.mark.parametrize(
    ("name", "value"), [("limit", 0.5), ("limit", 0.0), ("clearance", -0.1), ("iterations", 0), ("rays", 3)]
)
def test_bad_settings_are_refused(name, value):
    with pytest.raises(SettingsError, match=f"relocation.{name}"):
        Settings(**{name: value})


# ---- looking around ----------------------------------------------------------------------------------


def test_surroundings_of_the_middle_of_a_room():
    around = look_around(in_a_room().tracer, np.array([[1.0, 1.0, 1.0]]), 500)
    assert around.behind[0] == 0
    direction, distance = around.nearest(back=False)
    assert distance[0] == pytest.approx(2, rel=0.01)
    assert around.farthest_front()[1][0] == pytest.approx(2 * 3**0.5, rel=0.05)
    assert np.isinf(around.nearest(back=True)[1][0])
    assert np.abs(direction[0]).max() > 0.99


def test_surroundings_inside_a_pillar():
    around = look_around(in_a_room(pillar=box(*PILLAR)).tracer, np.array([[1.0, 1.0, 1.0]]), 500)
    assert around.behind[0] == pytest.approx(1, abs=0.03)  # its ends are the room's floor and ceiling
    direction, distance = around.nearest(back=True)
    assert distance[0] == pytest.approx(0.2, rel=0.02)
    assert direction[0] == pytest.approx([1, 0, 0], abs=0.15)


def test_published_presets_place_as_their_papers():
    methods = {
        n: RenderSettings.preset(n).relocation.method
        for n in ("default", "scale", "mff", "blog", "ctu", "classic")
    }
    assert methods == {
        "default": "receivers", "scale": "scale", "mff": "mff", "blog": "off", "ctu": "off", "classic": "off",
    }  # fmt: skip
    assert relocation.Settings().limit < 0.5


def test_relocating_a_field_places_as_fitting_does_and_forgets_only_what_was_moved():
    scene, cameras = in_a_room(pillar=box((-0.6, 0, -0.6), (0.6, 3, 0.6))), cameras_in_it()
    scene = replace(scene, cameras=cameras)
    s = small(
        states_method="off", blend_warm_up=4, grid_counts=(6, 4, 6), relocation_method="off",
        gather_energy_preservation=0.0,
    )  # fmt: skip
    field = IrradianceField.fit(scene, s)
    for tick in range(6):
        field = frame.updated(scene, field, tick, s)
    before = irradiance_map(field, s)
    s = changed(s, relocation_method="scale", relocation_clearance=0.3, relocation_iterations=5)
    field, fitted = field.relocate(scene, s), IrradianceField.fit(scene, s)
    grid = field.volumes[0].grid
    np.testing.assert_allclose(grid.offsets(), fitted.volumes[0].grid.offsets(), atol=1e-6)
    np.testing.assert_array_equal(np.array(field.volumes[0].sight), np.array(fitted.volumes[0].sight))
    moved = (np.abs(grid.offsets()) > s.relocation.rejects * np.ravel(grid.spacing)).any(-1)
    assert 0 < moved.sum() < grid.size
    # Light of another colour shows what is left of before.
    vol = field.volumes[0]
    stained = replace(field, volumes=[replace(vol, irradiance=vol.irradiance * 0 + 1e4)])
    after = irradiance_map(frame.updated(scene, stained, 6, s), s).max((1, 2, 3))
    assert (after[moved] < 100).all()
    assert (after[~moved] > 100).all()
    assert before.max() < 100


def test_relocating_keeps_awake_what_is_awake():
    """Only those that wake up by it are new."""
    scene = replace(in_a_room(), cameras=cameras_in_it())
    s = small(grid_counts=(9, 9, 9), blend_warm_up=4)
    field = IrradianceField.fit(scene, s)
    for tick in range(3):
        field = frame.updated(scene, field, tick, s)
    vol, again = field.volumes[0], field.relocate(scene, s).volumes[0]
    assert vol.states is not None
    np.testing.assert_array_equal(np.array(vol.states.code), np.array(again.states.code))
    np.testing.assert_array_equal(np.array(vol.age), np.array(again.age))
    asked = field.relocate(scene, changed(s, states_method="off")).volumes[0]
    assert asked.states is None
    assert asked.awake.count == asked.grid.size
