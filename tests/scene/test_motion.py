"""Scenes whose things move: the same as scenes built with the things there."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi import frame
from ddgi.config import load_settings
from ddgi.errors import SceneError
from ddgi.frame import render_frame, updated
from ddgi.judge.path_tracer import PathTracer
from ddgi.probes.field import IrradianceField, probe_states
from ddgi.sampling import PIXEL_ALPHA, clock
from ddgi.scene.load import load_scene
from ddgi.settings import RenderSettings
from probing import diffuse, room, small

RAYS = 4096
MOVABLE = ("box", "ball", "lamp", "leaf", "card", "panel")


def description(moved=None):
    """A floor with a box, a ball, a lamp and a leaf of flat faces over it; `moved`: matrices by name."""
    moved, T = moved or {}, mi.ScalarTransform4f

    def at(name, rest):
        return T(moved.get(name, np.eye(4))) @ rest

    spot = T().look_at([1, 4, 0], [0, 0, 0], [0, 0, 1])
    return {
        "type": "scene",
        "floor": {"type": "rectangle", "to_world": T().rotate([1, 0, 0], -90).scale(4), "bsdf": diffuse(0.5)},
        "box": {"type": "cube", "to_world": at("box", T().translate([1, 1, 0]).scale(0.5)), "bsdf": diffuse(0.8)},
        "ball": {"type": "sphere", "to_world": at("ball", T().translate([-1, 1, 0]).scale(0.5)), "bsdf": diffuse(0.3)},
        "leaf": {
            "type": "cube", "face_normals": True, "bsdf": diffuse(0.6),
            "to_world": at("leaf", T().translate([0, 2, 1]).scale([0.5, 0.01, 0.3])),
        },
        "card": {
            "type": "rectangle", "bsdf": diffuse(0.7, two_sided=True),
            "to_world": at("card", T().translate([-0.5, 1.5, 1.5]).scale([0.4, 0.3, 1])),
        },
        "panel": {
            "type": "disk", "to_world": at("panel", T().translate([-2, 2.5, 0]).rotate([0, 1, 0], 90).scale(0.3)),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 3.0}},
        },
        "lamp": {
            "type": "cube", "to_world": at("lamp", T().translate([0, 3, 0]).scale([0.3, 0.05, 0.3])),
            "bsdf": diffuse(0.0), "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 5.0}},
        },
        "bulb": {
            "type": "point", "intensity": 2.0,
            "position": (moved.get("bulb", np.eye(4)) @ [1.0, 2.0, 1.0, 1.0])[:3].tolist(),
        },
        "beam": {"type": "spot", "intensity": 9.0, "to_world": at("beam", spot)},
        "sun": {"type": "directional", "irradiance": 1.0, "to_world": at("sun", T().look_at([0, 9, 0], [1, 0, 2], [0, 0, 1]))},
        "view": {
            "type": "perspective", "id": "view", "fov": 60, "to_world": at("view", T().look_at([0, 2, 6], [0, 1, 0], [0, 1, 0])),
            "film": {"type": "hdrfilm", "width": 32, "height": 24},
        },
    }  # fmt: skip


def turned(axis, degrees, shift, scale=1.0):
    """A placement that scales, turns around an axis, then shifts (Rodrigues' formula)."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle, matrix = np.radians(degrees), np.eye(4)
    matrix[:3, :3] = scale * (np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across)
    matrix[:3, 3] = shift
    return matrix


MOVES = {
    "box": turned([0, 1, 1], 35, [0.4, 0.7, -0.3], 1.3),
    "ball": turned([0, 1, 0], 10, [0.2, 0.5, 0.6]),
    "leaf": turned([1, 0, 0], 50, [0.1, 0.3, 0.2]),
    "lamp": turned([0, 0, 1], 20, [0.5, 0.1, 0.2]),
    "card": turned([1, 1, 0], 40, [0.2, 0.1, -0.1]),
    "panel": turned([0, 1, 0], -20, [0.3, 0.2, 0.1]),
    "bulb": turned([0, 1, 0], 90, [0, 0.5, 0]),
    "beam": turned([1, 0, 0], 15, [0.3, 0, 0]),
    "sun": turned([1, 0, 0], 25, [0, 0, 0]),
    "view": turned([0, 1, 0], 30, [0, 0.2, 0]),
}


def moving(**options):
    return load_scene(description(), movable=MOVABLE, **options)


def all_moved(scene):
    for name, matrix in MOVES.items():
        scene = scene.moved(name, matrix)
    return scene


def seen(scene):
    """What random rays from around find: valid, distance, normals, albedo, emission."""
    rng = np.random.default_rng(3)
    way = rng.normal(size=(3, RAYS))
    way /= np.linalg.norm(way, axis=0)
    target = rng.uniform(-1.5, 1.5, (3, RAYS))
    target[1] += 1.5
    hit = scene.tracer.intersect(
        mi.Point3f((target - 8 * way).astype(np.float32)), mi.Vector3f(way.astype(np.float32)), mi.Bool(True),
        time=clock(0, 0), stream=PIXEL_ALPHA,
    )  # fmt: skip
    valid = np.array(hit.valid)
    return valid, [
        np.where(valid, np.array(x), 0)
        for x in (hit.distance, hit.normal, hit.geometric_normal, hit.albedo, hit.emission, hit.front)
    ]


def assert_alike(a, b, share=0.002):
    """Equal but for a few rays that just graze an edge."""
    assert (a[0] != b[0]).mean() < share
    for x, y in zip(a[1], b[1], strict=True):
        off = (np.abs(x.astype(float) - y) > 2e-4).reshape(-1, RAYS).any(0)
        assert off.mean() < share


def test_at_rest_it_is_the_scene_that_stands_still():
    assert_alike(seen(moving()), seen(load_scene(description())))


def test_moved_things_are_where_a_scene_built_there_has_them():
    built = load_scene(description(MOVES))
    scene = all_moved(moving())
    assert_alike(seen(scene), seen(built))
    for ours, theirs in (
        (scene.lights.delta.position, built.lights.delta.position),
        (scene.lights.delta.direction, built.lights.delta.direction),
        (scene.camera.position, built.camera.position),
        (scene.camera.forward, built.camera.forward),
        (scene.camera.right, built.camera.right),
    ):
        np.testing.assert_allclose(np.array(ours), np.array(theirs), atol=1e-5)


def test_a_mirrored_thing_keeps_its_front():
    mirrored = np.diag([-1.0, 1.0, 1.0, 1.0])
    scene, built = moving().moved("box", mirrored), load_scene(description({"box": mirrored}))
    ours, theirs = seen(scene), seen(built)
    assert_alike(ours, theirs)


def test_every_copy_shows_its_own_pose():
    rest = moving()
    there, back = all_moved(rest), seen(rest)
    first = seen(there)
    for scene, wanted in ((rest, back), (there, first), (rest, back)):
        found = seen(scene)
        for x, y in zip(found[1], wanted[1], strict=True):
            np.testing.assert_array_equal(x, y)


def test_shadows_move_along():
    rest = moving()
    below = mi.Point3f(1, 0.01, 0), mi.Vector3f(0, 1, 0), mi.Float(2.5)
    lifted = rest.moved("box", turned([0, 1, 0], 0, [0, 0, 3]))
    assert [float(s.tracer.visible(*below, mi.Bool(True))[0]) for s in (rest, lifted, rest)] == [0, 1, 0]


@pytest.mark.parametrize("name", [None, "box", "ball", "card", "panel", "lamp", "bulb", "beam", "sun"])
def test_the_path_tracer_sees_the_same(name):
    """Direct light of the reference, in the scene moved and in one built there."""
    moves = {n: m for n, m in MOVES.items() if name in (n, None) and n != "view"}
    scene = moving()
    for n, matrix in moves.items():
        scene = scene.moved(n, matrix)
    ours, theirs = (
        PathTracer(s).render_direct(scene.camera, 64, 0).picture
        for s in (scene, load_scene(description(moves)))
    )
    assert np.abs(ours - theirs).mean() < 0.01 * theirs.mean()


@pytest.mark.slow
def test_the_path_tracer_sees_built_in_things_move():
    """Their meshes come as objects: the same moved, and handed over moved."""
    move = turned([0, 1, 0], 30, [0.1, 0.3, 0])
    scene = load_scene("cornell", movable=["small-box", "light"], size=(32, 32)).moved("small-box", move)
    scene = scene.moved("light", turned([0, 1, 0], 0, [0.1, -0.2, 0.1]))
    ours = PathTracer(scene).render_direct(scene.camera, 64, 0).picture
    still = PathTracer(load_scene("cornell", size=(32, 32))).render_direct(scene.camera, 64, 0).picture
    s = RenderSettings.preset("default")
    field, shown = IrradianceField.fit(scene, s), None
    for tick in range(24):
        field, shown = render_frame(scene, field, scene.camera, tick, s, shown)
    direct = np.array(shown.picture.immediate).T.reshape(32, 32, 3)
    lit = ours.mean()
    assert np.abs(direct - ours).mean() < 0.1 * lit
    assert np.abs(direct - still).mean() > 0.3 * lit


@pytest.mark.slow
def test_the_lamp_that_moves_lights_what_is_below_it():
    """Sampled light of a moving area lamp, field and all, against a scene built with the lamp there."""
    s = RenderSettings.preset("default")
    move = {"lamp": turned([0, 1, 0], 0, [1.5, -1.0, 0])}
    pictures = []
    for scene in (moving().moved("lamp", move["lamp"]), load_scene(description(move))):
        field, shown = IrradianceField.fit(scene, s), None
        for tick in range(24):
            field, shown = render_frame(scene, field, scene.camera, tick, s, shown)
        pictures.append(shown.numpy())
    ours, theirs = pictures
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.02)
    assert np.abs(ours - theirs).mean() < 0.06 * theirs.mean()


@pytest.mark.slow
def test_nothing_is_recorded_anew_while_things_move():
    s = RenderSettings.preset("default")
    scene = moving()
    field = IrradianceField.fit(scene, s)
    found = []
    for tick in range(8):
        shift = turned([0, 1, 0], 10 * tick, [0, 0.1 * tick, 0])
        now = scene.moved("box", shift).moved("ball", shift).moved("lamp", shift).moved("bulb", shift)
        field, _ = render_frame(now, field, now.camera, tick, s)
        found.append((frame.advance().recordings, frame.expose().recordings))
    assert len(set(found[3:])) == 1


def test_a_mesh_in_another_form():
    scene = moving()
    rest = np.array(mi.traverse(mi.load_dict(description()["box"]))["vertex_positions"]).reshape(-1, 3)
    taller = rest * [1, 2, 1]
    assert_alike(
        seen(scene.bent("box", taller)), seen(load_scene(description({"box": np.diag([1.0, 2.0, 1.0, 1.0])})))
    )


def test_probes_are_placed_without_what_moves():
    s = load_settings("default", None, ["grid.box=[[-2,0.1,-2],[2,3,2]]"])
    elsewhere = moving().moved("box", MOVES["box"]).moved("leaf", MOVES["leaf"])
    here, there = (IrradianceField.fit(scene, s).volumes[0].grid for scene in (moving(), elsewhere))
    np.testing.assert_array_equal(here.offsets(), there.offsets())


def test_probes_wake_where_things_come_by():
    """A box that flies through the air of a hall: sleepers around it wake, and sleep again when it is past."""
    s = small(grid_box=((-3.0, 0.1, -3.0), (3.0, 5.9, 3.0)), grid_counts=(7, 7, 7), states_every=0)
    hall = {
        "room": room(diffuse(0.5), 3.0)["room"]
        | {"to_world": mi.ScalarTransform4f().translate([0, 3, 0]).scale(3)}
    }
    scene = load_scene(description() | hall, movable=["box"])
    field = IrradianceField.fit(scene, s)
    asleep = np.array(probe_states(field)) == "sleeping"
    place = np.array(field.volumes[0].grid.place(dr.arange(mi.UInt32, 343))).T
    rest = np.array([1.0, 1.0, 0.0])  # of the box
    far = np.flatnonzero(asleep & (np.linalg.norm(place - rest, axis=1) > 2))[0]
    woken = []
    for shift in (np.zeros(3), place[far] - rest, np.zeros(3)):
        field = updated(scene.moved("box", turned([0, 1, 0], 0, shift)), field, len(woken), s)
        woken.append(probe_states(field)[far] != "sleeping")
    assert woken == [False, True, False]


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e12])
def test_what_goes_astray_stays_and_is_named(bad):
    scene = moving().moved("box", MOVES["box"])
    lost = scene.moved("box", turned([0, 1, 0], 0, [bad, 0, 0]) if bad == 1e12 else np.diag([bad, 1, 1, 1]))
    assert [n for n in lost.notes if n.startswith("box: gone astray")]
    assert_alike(seen(lost), seen(scene))
    again = lost.moved("box", np.eye(4))
    assert_alike(seen(again), seen(moving()))


def test_vertices_that_are_no_numbers_leave_a_mesh_as_it_was():
    scene = moving()
    rest = np.array(mi.traverse(mi.load_dict(description()["box"]))["vertex_positions"]).reshape(-1, 3)
    bent = scene.bent("box", rest * [1, 2, 1])
    lost = bent.bent("box", np.full_like(rest, np.nan))
    assert [n for n in lost.notes if n.startswith("box: gone astray")]
    assert_alike(seen(lost), seen(bent))


def test_a_thing_shrunk_to_nothing_is_not_there():
    gone = moving().moved("box", np.diag([0.0, 0, 0, 1])).moved("ball", np.diag([1e-6, 1e-6, 1e-6, 1]))
    valid, (_, normal, *_) = seen(gone)
    assert np.isfinite(normal).all()
    assert valid.mean() < seen(moving())[0].mean()


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (
            lambda s: s.moved("floor", np.eye(4)),
            r"floor was not loaded as something that moves: .*movable=\['floor'\]",
        ),
        (lambda s: s.moved("chair", np.eye(4)), "nothing called 'chair' can be moved: there are box, "),
        (lambda s: s.moved("box", np.zeros((3, 3))), "4 x 4"),
        (lambda s: s.moved("box", np.zeros((4, 4))), "last row"),
        (lambda s: s.bent("ball", np.zeros((3, 3))), "ball is no mesh"),
        (lambda s: s.bent("box", np.zeros((3, 3))), r"box has 24 vertices, not an array \(3, 3\)"),
        (lambda s: s.at(1.0), "nothing in it is animated"),
    ],
)
def test_what_cannot_be_moved(act, message):
    with pytest.raises(SceneError, match=message):
        act(moving())


@pytest.mark.parametrize(
    ("movable", "message"),
    [(["chair"], "no shape called 'chair': there are floor, box"), ("box", "must be a list")],
)
def test_movable_names_that_there_are_not(movable, message):
    with pytest.raises(SceneError, match=message):
        load_scene(description(), movable=movable)


def test_patterns_name_several():
    scene = load_scene(description(), movable=["b*"])
    assert set(scene.motion.stage.names) == {"box", "ball"}
    assert dr.width(scene.tracer.movers.row) == 12
