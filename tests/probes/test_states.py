"""Probe states: which probes are updated, who gives light, and that what stands still settles."""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SettingsError
from ddgi.frame import Frame, render_frame, updated
from ddgi.probes import blend, query, states, volume
from ddgi.probes.awake import AWAKE, NEWLY_AWAKE, NEWLY_VIGILANT, OFF, SLEEPING, VIGILANT
from ddgi.probes.field import IrradianceField, irradiance_map, probe_states
from ddgi.probes.region import Seen
from ddgi.scene.camera import look_at
from probing import (
    camera_in,
    changed,
    dark_light,
    diffuse,
    hand_made,
    lattice,
    load,
    points,
    rgb,
    room,
    small,
)

NOBODY = Seen(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.float32), np.zeros(0, np.float32))


def slab(two_sided=False, height=0.0, half=4.0):
    """A floor, seen from above."""
    to_world = mi.ScalarTransform4f().translate([0, height, 0]).rotate([1, 0, 0], -90).scale(half)
    return {"type": "rectangle", "bsdf": diffuse(0.5, two_sided=two_sided), "to_world": to_world}


def classified(scene, method, origin=(-1.0, -1.3, -1.0), counts=(3, 5, 3), **more):
    """States of probes a metre apart, by their planes of equal height, lowest first."""
    s = small(states_method=method, grid_counts=counts, **more)
    vol = volume.allocate(lattice(counts, origin), s.volume, 8, 4096)
    vol = states.classify(vol, scene.tracer, NOBODY, s.states, 0)
    if vol.states is None:
        return None, vol, s
    return np.array(vol.states.code).reshape(counts[::-1]).transpose(1, 0, 2).reshape(counts[1], -1), vol, s


@pytest.mark.parametrize("two_sided", [False, True])
def test_in_a_cell_of_the_floor_probes_are_updated(two_sided):
    """Planes at -1.3, -0.3, 0.7, 1.7, 2.7: the floor at 0 is within a cell of two of them."""
    scene = load({"type": "scene", "floor": slab(two_sided), "lamp": dark_light()})
    by_plane, _, _ = classified(scene, "cells")
    below = NEWLY_VIGILANT if two_sided else OFF
    for plane, code in zip(by_plane, (SLEEPING, below, NEWLY_VIGILANT, SLEEPING, SLEEPING), strict=True):
        assert (plane == code).all()


def test_states_of_scale():
    """Front faces nearer than a spacing; more than a quarter of backs is inside something."""
    scene = load({"type": "scene", "floor": slab(), "lamp": dark_light()})
    by_plane, _, _ = classified(scene, "scale")
    for plane, code in zip(by_plane, (OFF, OFF, NEWLY_VIGILANT, SLEEPING, SLEEPING), strict=True):
        assert (plane == code).all()


def test_states_of_ctu():
    """Anything within the diagonal, 1.73: 1.7 above the floor just so; of what is near below it, most are backs."""
    scene = load({"type": "scene", "floor": slab(), "lamp": dark_light()})
    by_plane, _, _ = classified(scene, "ctu", states_rays=4096)
    for plane, code in zip(by_plane, (OFF, OFF, AWAKE, AWAKE, SLEEPING), strict=True):
        assert (plane == code).all()


def test_what_lies_outside_the_grid_keeps_its_outermost_probes_awake():
    """The floor lies 2 m below the lowest plane, and reads it."""
    scene = load({"type": "scene", "floor": slab(half=20), "lamp": dark_light()})
    by_plane, _, _ = classified(scene, "cells", origin=(-1.0, 2.0, -1.0))
    assert (by_plane[0] == NEWLY_VIGILANT).all()
    assert (by_plane[1:] == SLEEPING).all()


def test_walls_just_outside_the_grid_keep_one_plane_awake():
    """In any unit: for the second plane such a wall is on the far side of its cells, where it counts for nothing."""
    counts = []
    for scale in (1.0, 1000.0, 0.001):
        lamp = {"type": "point", "position": [0, 0, 0], "intensity": rgb(scale * scale)}
        box = tuple((side * 0.984 * scale,) * 3 for side in (-1, 1))
        s = small(grid_counts=(7, 7, 7), grid_margin=0.0, grid_box=box, relocation_method="off")
        vol = IrradianceField.fit(load(room(diffuse(0.6), scale, lamp=lamp)), s).volumes[0]
        counts.append(vol.states.counts())
    assert counts == [{"sleeping": 125, "newly vigilant": 218}] * 3


def test_points_that_cameras_see_keep_probes_awake():
    """A wire too thin for few rays to meet."""
    wire = {"type": "cylinder", "p0": [-3, 0, 0.2], "p1": [3, 0, 0.2], "radius": 0.002, "bsdf": diffuse(0.5)}
    scene = load({"type": "scene", "wire": wire, "lamp": dark_light()})
    _, vol, s = classified(scene, "off", states_rays=8)
    at = np.array([[0.1, 0.002, 0.2]], np.float32)
    seen = Seen(at, np.array([[0, 1, 0]], np.float32), np.ones(1, np.float32))
    unseen = states.classify(vol, scene.tracer, NOBODY, replace(s.states, method="cells"), 0)
    codes = np.array(
        states.classify(vol, scene.tracer, seen, replace(s.states, method="cells"), 0).states.code
    )
    assert unseen.states is None, "none sees it, so all stay awake"
    assert (
        codes == NEWLY_VIGILANT
    ).sum() == 4  # those above it in its cell; the others see the wire from below


def test_what_nobody_is_near_stays_awake():
    """No geometry in the volume: better all than none."""
    scene = load({"type": "scene", "floor": slab(height=-900), "lamp": dark_light()})
    for method in ("cells", "scale", "ctu"):
        _, vol, _ = classified(scene, "off")
        s = small(states_method=method)
        vol = states.classify(
            replace(vol, grid=lattice((3, 5, 3), (5000, 0, 5000))), scene.tracer, NOBODY, s.states, 0
        )
        assert vol.states is None
        assert vol.awake.count == 45


# ---- updates ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def hall():
    """A room in which most probes are far from everything."""
    lamp = {"type": "point", "position": [0.4, 0.6, 0.2], "intensity": rgb(2.0)}
    return replace(load(room(diffuse(0.6), lamp=lamp)), cameras=(camera_in((48, 36)),))


LARGE = {"grid_counts": (9, 9, 9), "relocation_method": "off"}


def run(scene, s, ticks, field=None, start=0):
    field = IrradianceField.fit(scene, s) if field is None else field
    for tick in range(start, start + ticks):
        field = updated(scene, field, tick, s)
        dr.eval(field)
    return field


def test_sleepers_are_not_updated(hall):
    s = small(**LARGE, states_every=0)
    field = run(hall, s, 3)
    vol = field.volumes[0]
    code, age = np.array(vol.states.code), np.array(vol.age)
    maps = irradiance_map(field, s).reshape(len(code), -1)
    assert set(code) == {SLEEPING, VIGILANT}
    up = np.zeros(len(code), bool)
    up[np.array(vol.awake.numbers)] = True
    assert up[code == VIGILANT].all()
    assert vol.awake.count % states.ROUND == 0
    assert vol.awake.count < 0.75 * len(code)
    assert (age[up & (code == VIGILANT)] == 3).all()
    assert (maps[~up] == 0).all()
    assert (age[~up] == 0).all()
    assert (maps[code == VIGILANT].max(-1) > 0).all()


def test_light_on_surfaces_is_the_same(hall):
    """Sleepers were of no use: the picture stays what it was, within its noise."""
    pictures = []
    for method in ("off", "cells"):
        s = small(**LARGE, states_method=method)
        field, frame = IrradianceField.fit(hall, s), Frame.empty(hall.camera, s)
        for tick in range(64):
            field, frame = render_frame(hall, field, hall.camera, tick, s, frame)
        pictures.append(frame.numpy())
    everyone, some = pictures
    assert some.mean() == pytest.approx(everyone.mean(), rel=5e-3)
    assert np.abs(some - everyone).mean() < 0.02 * everyone.mean()


@pytest.mark.parametrize("fmt", ["float32", "float16", "rgbe8", "r11g11b10"])
def test_maps_of_every_format_are_written_in_place(hall, fmt):
    s = small(**LARGE, volume_irradiance_format=fmt, blend_warm_up=1)
    some = run(hall, s, 2)
    everyone = run(hall, changed(s, states_method="off"), 2)
    vigilant = np.array(some.volumes[0].states.code) == VIGILANT
    a, b = (irradiance_map(f, s)[vigilant].mean((1, 2, 3)) for f in (some, everyone))
    assert np.corrcoef(a, b)[0, 1] > 0.9
    assert a.mean() == pytest.approx(b.mean(), rel=0.1)


# ---- who gives light -------------------------------------------------------------------------------


def lit_by(codes, method="cells"):
    """A point amid eight probes of radiances 1 to 8 beside eight of 9 to 16, in states."""
    s = small(states_method=method, query_sight="maps", query_wrap="off", query_crush=0.0)
    vol = hand_made(lattice((4, 2, 2)), s, np.repeat(np.arange(1.0, 17)[:, None], 3, 1))
    vol = states._with(vol, np.array(codes), np.zeros(16, int), s.states, 0)
    at = query.Receiver(
        points([[0.5, 0.5, 0.5]]),
        points([[0, 1, 0]]),
        points([[0, 1, 0]]),
        mi.Bool(True),
        points([[0.5, 0.5, 0.5]]),
    )
    shares = query.shares(vol, at, s.volume, s.query)
    light = query.irradiance(vol, at, s.volume, s.query)
    return {int(n[0]): float(w[0]) for n, w in shares if w[0] > 0}, float(light.x[0]) / np.pi


def test_sleepers_give_no_light():
    codes = [VIGILANT] * 16
    everyone, light = lit_by(codes)
    assert set(everyone) == {0, 1, 4, 5, 8, 9, 12, 13}
    assert light == pytest.approx(7.5)  # of 1, 2, 5, 6, 9, 10, 13 and 14
    for asleep in (SLEEPING, OFF):
        shares, light = lit_by([asleep if n in (12, 13) else VIGILANT for n in range(16)])
        assert set(shares) == {0, 1, 4, 5, 8, 9}
        assert light == pytest.approx(5.5)


def test_sleepers_of_ctu_do_and_its_dead_do_not():
    assert lit_by([SLEEPING if n in (12, 13) else AWAKE for n in range(16)], "ctu")[1] == pytest.approx(7.5)
    assert lit_by([OFF if n in (12, 13) else AWAKE for n in range(16)], "ctu")[1] == pytest.approx(5.5)


def test_where_all_eight_are_dead_the_nearest_others_give_light():
    """Not black: columns 0 and 1 are dead, those of column 2 stand in."""
    shares, light = lit_by([VIGILANT if n % 4 > 1 else OFF for n in range(16)])
    assert set(shares) == {2, 6, 10, 14}
    assert light == pytest.approx(9.0)  # of 3, 7, 11 and 15


# ---- over time -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def clutter():
    """Things of all sizes, which looks of few rays meet now and then."""
    rng = np.random.default_rng(3)
    balls = {
        f"ball {n}": {
            "type": "sphere", "center": rng.uniform(-0.8, 0.8, 3).tolist(), "radius": float(r), "bsdf": diffuse(0.6),
        }
        for n, r in enumerate(np.geomspace(0.005, 0.2, 12))
    }  # fmt: skip
    lamp = {"type": "point", "position": [0.9, 0.9, 0.9], "intensity": rgb(2.0)}
    return load(room(diffuse(0.6), lamp=lamp, **balls))


@pytest.mark.parametrize("method", ["cells", "scale", "ctu"])
def test_states_settle(clutter, method):
    """No probe changes its state for 200 frames; before, each did a few times at most."""
    s = small(grid_counts=(10, 10, 10), states_method=method, states_rays=16, states_every=2, states_alive=20)
    vol = IrradianceField.fit(clutter, s).volumes[0]
    changes, before = [], np.array(vol.states.code)
    for tick in range(300):
        vol = states.attend(vol, clutter.tracer, tick, s)
        vol = replace(vol, states=vol.states.updated())
        code = np.array(vol.states.code)
        changes.append((code != before) & ~(before + 2 == code))
        before = code
    changes = np.array(changes)
    assert changes.any(), "this scene was to have some"
    assert changes.sum(0).max() <= 2
    assert not changes[-200:].any()


def test_one_that_wakes_begins_anew(clutter):
    """It keeps nothing old at its first update, and then a running mean."""
    s = small(
        grid_counts=(10, 10, 10), states_rays=8, states_every=5, blend_warm_up=4, relocation_method="off"
    )
    field = run(clutter, s, 4)
    was = np.array(field.volumes[0].states.code)
    field = run(clutter, s, 1, field, 4)  # the fifth: sleepers look first
    vol = field.volumes[0]
    woken = (was == SLEEPING) & (np.array(vol.states.code) == VIGILANT)
    assert woken.any()
    age = np.array(vol.age)[woken]
    assert (age == 4).all()
    assert np.array(blend.hysteresis(mi.UInt32(age - 1), s.blend)) == pytest.approx(0)
    assert (np.array(blend.hysteresis(mi.UInt32(age), s.blend)) > 0).all()
    light = irradiance_map(field, s)[woken].mean((1, 2, 3))
    assert (light > 0).all()


def test_things_that_move_wake_the_probes_around_them(hall):
    s = small(**LARGE, states_every=0)
    field = run(hall, s, 2)
    middle = 364  # of 9 x 9 x 9
    state = lambda f: int(np.array(f.volumes[0].states.code)[middle])  # noqa: E731
    assert state(field) == SLEEPING
    near = [((-0.05, -0.05, -0.05), (0.05, 0.05, 0.05))]
    field = field.wake(hall, near, s)
    assert state(field) == NEWLY_AWAKE
    changed_now = (np.array(field.volumes[0].states.code) == NEWLY_AWAKE).sum()
    assert changed_now == 27  # within a cell of the box
    field = run(hall, s, 1, field, 2)
    assert state(field) == AWAKE
    assert irradiance_map(field, s)[middle].max() > 0
    assert state(field.wake(hall, near, s)) == AWAKE
    assert state(field.wake(hall, [], s)) == SLEEPING


def test_waking_ctus_probes_puts_none_to_sleep(hall):
    """They fall asleep by themselves."""
    s = small(**LARGE, states_method="ctu", states_every=0)
    field = run(hall, s, 1)
    before = np.array(field.volumes[0].states.code)
    for boxes in ([((-0.05,) * 3, (0.05,) * 3)], []):
        field = field.wake(hall, boxes, s)
        assert not ((np.array(field.volumes[0].states.code) == SLEEPING) & (before != SLEEPING)).any()
    assert (
        probe_states(field).count("newly awake")
        == ((before == SLEEPING) & (np.array(field.volumes[0].states.code) > SLEEPING)).sum()
    )


def test_with_none_awake_updates_go_on(hall):
    s = small(**LARGE, states_every=0)
    vol = IrradianceField.fit(hall, s).volumes[0]
    vol = states._with(vol, np.full(729, SLEEPING), np.zeros(729, int), s.states, 0)
    assert vol.awake.count == states.ROUND


def test_lists_have_few_lengths_while_things_come_and_go(hall):
    """Kernels are compiled for the length, so it stays while there is room, and shrinks where much is left over."""
    s = small(**LARGE, states_every=0)
    vol = IrradianceField.fit(hall, s).volumes[0]
    lengths = []
    for awake in (*range(100, 400, 20), *range(400, 60, -20)):
        code = np.where(np.arange(729) < awake, AWAKE, SLEEPING)
        vol = states._with(vol, code, np.zeros(729, int), s.states, 0)
        assert vol.awake.count >= awake
        assert set(np.flatnonzero(code == AWAKE)) <= set(np.array(vol.awake.numbers))
        lengths.append(vol.awake.count)
    assert lengths[-1] < 250
    assert np.count_nonzero(np.diff(lengths)) < 20


@pytest.mark.parametrize(
    "box",
    [((0, 0), (1, 1)), ((0, 0, 0), (1, float("nan"), 1)), ((1, 0, 0), (0, 1, 1)), (0, 0, 0), None, "box"],
)
def test_what_is_no_box_wakes_nobody(hall, box):
    s = small()
    with pytest.raises(SettingsError, match="no box"):
        IrradianceField.fit(hall, s).wake(hall, [box], s)


def test_sleepers_of_ctu_are_updated_now_and_then(hall):
    s = small(**LARGE, states_method="ctu", states_every=5, blend_growth=8, blend_warm_up=0)
    field, counts = IrradianceField.fit(hall, s), []
    asleep = np.array(field.volumes[0].states.code) == SLEEPING
    assert asleep.any()
    for tick in range(11):
        field = updated(hall, field, tick, s)
        dr.eval(field)
        counts.append(field.volumes[0].awake.count)
    assert [n == 729 for n in counts] == [False] * 4 + [True] + [False] * 4 + [True] + [False]
    assert (irradiance_map(field, s)[asleep].max((1, 2, 3)) > 0).all()


def test_hysteresis_grows_as_the_logarithm_of_updates():
    s = replace(small().blend, warm_up=0, growth=15, hysteresis=0.9)
    ages = dr.arange(mi.UInt32, 20)
    alpha = np.array(blend.hysteresis(ages, s))
    assert alpha[:16] == pytest.approx(0.9 * np.log(np.arange(1, 17)) / np.log(16), abs=1e-6)
    assert alpha[16:] == pytest.approx(0.9)


# ---- bad input -------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["cells", "scale", "ctu"])
@pytest.mark.parametrize("inside", [False, True])
def test_a_room_with_all_faces_reversed_is_neither_black_nor_not_a_number(method, inside):
    """Faces that look outwards are black from within, as a path tracer has it; a lamp within is seen still."""
    ball = {"type": "cube", "bsdf": diffuse(0.6), "to_world": mi.ScalarTransform4f().scale(1.0)}
    shell = (
        ball
        if inside
        else {"type": "cube", "bsdf": diffuse(0.6, two_sided=True), "to_world": ball["to_world"]}
    )
    lamp = {
        "type": "rectangle", "bsdf": diffuse(0.0), "emitter": {"type": "area", "radiance": rgb(3.0)},
        "to_world": mi.ScalarTransform4f().translate([0, 0.9, 0]).rotate([1, 0, 0], 90).scale(0.3),
    }  # fmt: skip
    scene = load({"type": "scene", "shell": shell, "lamp": lamp})
    camera = look_at((0, 0, 0.8), (0, 0.5, -0.2), fov=90, size=(24, 18))
    s = small(states_method=method)
    field, frame = IrradianceField.fit(scene, s), Frame.empty(camera, s)
    for tick in range(8):
        field, frame = render_frame(scene, field, camera, tick, s, frame)
    picture = frame.numpy()
    assert np.isfinite(picture).all()
    assert picture.max() > 0
    if not inside and method == "cells":
        assert (picture.mean(-1) > 0).mean() > 0.99  # two-sided: the whole room is lit


def test_a_flat_grid_is_lit():
    """Two planes of probes, the fewest there can be."""
    scene = load(room(diffuse(0.6), lamp={"type": "point", "position": [0, 0.5, 0], "intensity": rgb(1.0)}))
    s = small(grid_counts=(4, 2, 4))
    field = run(scene, s, 4)
    assert irradiance_map(field, s).mean() > 0.01
    assert np.array(field.volumes[0].grid.counts).min() == 2
