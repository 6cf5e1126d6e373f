"""The box that is found where nobody names one: around the light, not around the geometry."""

import mitsuba as mi
import numpy as np
import pytest

import ddgi
from ddgi.probes import region
from ddgi.probes.region import _evened, _further, _grown, _trimmed
from ddgi.scene.camera import look_at
from probing import diffuse, load, rgb, small

ROOM = np.array([[-2.0, 0.0, -3.0], [2.0, 2.5, 3.0]])


def found(scene, *cameras):
    return np.array(
        region.find(scene.tracer, region.look(scene.tracer, cameras or scene.cameras), scene.bounds)
    )


def room(low, high, name):
    """Five walls and a ceiling that face in, with a window in the wall at +z: [-0.5, 0.5] x [1, 2]."""
    t = mi.ScalarTransform4f
    (x0, y0, z0), (x1, y1, z1) = low, high
    middle, half = (np.array(low) + high) / 2, (np.array(high) - low) / 2
    sides = {
        "floor": t().translate([middle[0], y0, middle[2]]).rotate([1, 0, 0], -90).scale([half[0], half[2], 1]),
        "top": t().translate([middle[0], y1, middle[2]]).rotate([1, 0, 0], 90).scale([half[0], half[2], 1]),
        "left": t().translate([x0, middle[1], middle[2]]).rotate([0, 1, 0], 90).scale([half[2], half[1], 1]),
        "right": t().translate([x1, middle[1], middle[2]]).rotate([0, 1, 0], -90).scale([half[2], half[1], 1]),
        "back": t().translate([middle[0], middle[1], z0]).scale([half[0], half[1], 1]),
    }  # fmt: skip
    pieces = [(x0, -0.5, y0, y1), (0.5, x1, y0, y1), (-0.5, 0.5, y0, 1.0), (-0.5, 0.5, 2.0, y1)]
    for number, (a, b, c, d) in enumerate(pieces):
        place = t().translate([(a + b) / 2, (c + d) / 2, z1]).rotate([0, 1, 0], 180)
        sides[f"window-{number}"] = place.scale([(b - a) / 2, (d - c) / 2, 1])
    return {
        f"{name}-{n}": {"type": "rectangle", "to_world": m, "bsdf": diffuse(0.6)} for n, m in sides.items()
    }


def dome(radius):
    return {
        "type": "sphere", "radius": radius, "flip_normals": True,
        "emitter": {"type": "area", "radiance": rgb(1.0)}, "bsdf": diffuse(0.0),
    }  # fmt: skip


@pytest.mark.parametrize("radius", [30.0, 200.0])
def test_a_room_in_a_dome_of_sky(radius):
    scene = load({"type": "scene", **room(*ROOM, "room"), "sky": dome(radius)})
    inside = look_at((0, 1.5, -2), (0.2, 1.2, 2), size=(64, 36))
    assert np.allclose(found(scene, inside), ROOM, atol=1e-3)  # to the walls, and not into the dome


def test_a_stray_thing_far_away_does_not_count():
    far = {"type": "cube", "to_world": mi.ScalarTransform4f().translate([0, 1.5, 80]), "bsdf": diffuse(0.5)}
    scene = load(
        {
            "type": "scene",
            **room(*ROOM, "room"),
            "stray": far,
            "sun": {"type": "point", "position": [0, 2, 0]},
        }
    )
    inside = look_at((0, 1.5, -2), (0.2, 1.2, 2), size=(64, 36))
    assert np.allclose(found(scene, inside), ROOM, atol=0.15)


def test_a_box_seen_from_outside_is_taken_whole():
    scene = ddgi.load_scene("cornell-point")
    assert np.allclose(found(scene), scene.bounds, atol=0.03)


def test_rooms_beyond_a_door_belong_to_it():
    """veach-ajar in kind: the light is next door."""
    scene = ddgi.load_scene("two-rooms")
    low, high = found(scene)
    assert np.allclose([low, high], scene.box, atol=0.3)


def test_every_camera_counts():
    near, far = np.array([[0, 0, 0], [3, 2, 3]]), np.array([[20, 0, 0], [23, 2, 3]])
    lamp = {"type": "point", "position": [1, 1, 1]}
    scene = load({"type": "scene", **room(*near, "a"), **room(*far, "b"), "lamp": lamp})
    one, other = look_at((1.5, 1, 0.5), (1.4, 1, 2)), look_at((21.5, 1, 0.5), (21.4, 1, 2))
    assert found(scene, one)[1, 0] < 4
    both = found(scene, one, other)
    assert both[0, 0] < 0.2
    assert both[1, 0] > 22.8


def test_the_size_of_the_picture_does_not_matter():
    scene = load({"type": "scene", **room(*ROOM, "room"), "light": {"type": "constant"}})
    small, large = (
        found(scene, look_at((0, 1.5, -2.5), (0, 1.2, 0), size=size)) for size in ((32, 18), (1920, 1080))
    )
    np.testing.assert_allclose(small, large, atol=1e-3)


def test_cameras_that_see_nothing_leave_everything():
    scene = ddgi.load_scene("cornell-point")
    away = look_at((0, 0, 50), (0, 0, 60))
    assert np.allclose(found(scene, away), scene.bounds)


def test_moves_along_with_the_scene():
    lamp = {"type": "point", "position": [0, 1, 0]}
    shift = np.array([120.0, -40.0, 7.0])
    boxes = []
    eye, target = np.array([0, 1.5, -2]), np.array([0.2, 1.2, 2])
    for by in (np.zeros(3), shift):
        scene = load({"type": "scene", **room(*(ROOM + by), "room"), "lamp": lamp})
        boxes.append(found(scene, look_at(by + eye, by + target)) - by)
    assert np.allclose(*boxes, atol=0.02)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_ends_lie_at_even_places_whatever_the_unit(scale):
    """So that a path more or less moves none; never inwards, nor by more than a 256th."""
    ends, start, longest = np.array([1.234, 7.1]), -40.0, 80.0
    found = np.array(
        [_evened(tuple(scale * (ends + d)), scale * start, scale * longest) for d in (0, 1e-3, -1e-3)]
    )
    np.testing.assert_allclose(found[1:], found[:1].repeat(2, 0), rtol=1e-9)
    outward = (found[0] / scale - ends) * [-1, 1]
    assert (outward >= 0).all()
    assert (outward <= (ends[1] - ends[0]) / 256).all()


def test_grows_to_all_of_what_is_even():
    place = np.linspace(-1, 3, 1001)
    assert _grown(place, np.ones(1001)) == pytest.approx((-1, 3), abs=0.01)


@pytest.mark.parametrize("sign", [1, -1])
def test_does_not_leap_to_what_is_far(sign):
    place = sign * np.append(np.linspace(0, 1, 2000), np.linspace(50, 60, 20))
    low, high = _grown(place, np.ones(2020))
    assert (low, high) == (pytest.approx((0, 1), abs=0.02) if sign > 0 else pytest.approx((-1, 0), abs=0.02))


def test_what_weighs_nothing_does_not_count():
    place = np.append(np.linspace(0, 1, 100), 7.0)
    assert _grown(place, np.append(np.ones(100), 0.0)) == pytest.approx((0, 1), abs=0.02)


def test_a_hall_is_taken_whole_though_the_camera_looks_away_from_most_of_it():
    """Light behind the camera, where hardly any path goes, would else be lost at its first bounce."""
    hall = np.array([[0.0, 0.0, 0.0], [12.0, 2.5, 3.0]])
    scene = load({"type": "scene", **room(*hall, "hall"), "lamp": {"type": "point", "position": [1, 2, 1]}})
    assert np.allclose(found(scene, look_at((6, 1.25, 1.5), (11, 1.1, 2.0))), hall, atol=0.05)


@pytest.mark.parametrize(
    "most, rest, moved",
    [
        (0.0, 0.0, 0.0),  # a wall
        (3.0, 3.0, 3.0),  # a room cut through
        (0.0, 4.0, 0.5),  # a wall with a door to another room
        (3.0, 4.0, 3.5),  # both
        (0.0, 0.2, 0.2),  # a niche
        (0.0, np.inf, 0.0),  # a window
        (0.0, 90.0, 0.0),  # a window in a dome of sky
        (np.inf, np.inf, 0.0),  # no wall at all
        (90.0, 90.0, 0.0),  # nothing but the dome
    ],
)
def test_how_far_sides_move_out(most, rest, moved):
    ahead = np.append(np.full(970, most), np.full(30, rest))
    assert _further(ahead, furthest=10.0, behind=0.5) == pytest.approx(moved)


def wall_and_beyond(share, gap):
    """A space from 0 to 10 with a wall at its low end, and a share of the light beyond it, down to `-gap`."""
    inside, wall, beyond = np.linspace(0.5, 10, 1000), np.zeros(100), np.linspace(-gap, -1e-3, 100)
    place = np.concatenate([inside, wall, beyond])
    normal = np.concatenate([np.zeros(1000), np.ones(100), np.zeros(100)])
    weight = np.concatenate([np.full(1000, 1e-3), np.full(100, 1e-3), np.full(100, share * 1e-2)])
    return place, normal, weight


@pytest.mark.parametrize("gap", [0.01, 0.3, 0.9])
def test_ends_a_little_beyond_a_wall_go_back_to_it(gap):
    place, normal, weight = wall_and_beyond(0.02, gap)
    assert _trimmed(-gap, 10.0, place, normal, weight) == (0.0, 10.0)
    # and likewise at the other end
    assert _trimmed(-10.0, gap, -place, -normal, weight) == (-10.0, 0.0)


@pytest.mark.parametrize(
    "share, gap, facing",
    [(0.2, 0.9, 1), (0.02, 3.0, 1), (0.02, 0.9, -1)],
    ids=["more light beyond than on the wall", "far beyond", "a wall that faces out"],
)
def test_other_ends_stay(share, gap, facing):
    place, normal, weight = wall_and_beyond(share, gap)
    assert _trimmed(-gap, 10.0, place, facing * normal, weight) == (-gap, 10.0)


def test_an_explicit_box_wins():
    scene = load({"type": "scene", **room(*ROOM, "room"), "sky": dome(100)})
    box = ((-1.0, 0.5, -1.0), (1.0, 1.5, 1.0))
    field = ddgi.IrradianceField.fit(scene, small(grid_box=box, grid_counts=(3, 3, 3), grid_margin=0.0))
    grid = field.volumes[0].grid
    assert np.allclose(np.ravel(grid.origin), box[0])
