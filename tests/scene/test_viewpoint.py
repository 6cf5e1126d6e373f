"""Cameras chosen for scenes that have none: where they stand, what they show, and that they come out the same."""

from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

import ddgi
from ddgi.errors import SettingsError
from ddgi.scene.camera import turned, with_size
from ddgi.scene.viewpoint import pivot
from ddgi.scene.viewpoint.around import ELEVATIONS, FOV, MARGIN, orbit
from probing import diffuse, load, rgb, small

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "scenes"


def place(low, high):
    """The transform of Mitsuba's cube to a box."""
    low, high = np.array(low, float), np.array(high, float)
    middle, half = (low + high) / 2, (high - low) / 2
    return mi.ScalarTransform4f().translate(middle.tolist()).scale(half.tolist())


def box(low, high, *, inwards=False, albedo=0.5, two_sided=False):
    return {
        "type": "cube", "to_world": place(low, high), "flip_normals": inwards,
        "bsdf": diffuse(albedo, two_sided=two_sided),
    }  # fmt: skip


def lamp(*at):
    return {"type": "point", "position": list(at), "intensity": rgb(10.0)}


def numbers(vector) -> np.ndarray:
    return np.array(vector, np.float64).ravel()


def in_picture(camera, points: np.ndarray) -> np.ndarray:
    """(N, 2) where points are in the picture: -1 to 1 from edge to edge. By the formula in `Camera`."""
    offset = points - numbers(camera.position)
    right, up = numbers(camera.right), numbers(camera.up)
    depth = offset @ numbers(camera.forward)
    assert (depth > 0).all(), "something is behind the camera"
    return np.stack([offset @ right / (right @ right), offset @ up / (up @ up)], 1) / depth[:, None]


def chosen(*shapes, scale=1.0, offset=(0.0, 0.0, 0.0), ceiling=None, **more):
    """The scene of some shapes, which get a camera."""
    carry = mi.ScalarTransform4f().translate(list(offset)).scale(scale)
    moved = {f"s{n}": {**s, "to_world": carry @ s["to_world"]} for n, s in enumerate(shapes)}
    return load({"type": "scene", **moved, **more}, ceiling=ceiling)


# ---- rooms -------------------------------------------------------------------------------------

TABLES = [((0.5, 0.0, 1.0), (1.5, 0.8, 2.5)), ((4.0, 0.0, 0.2), (5.0, 0.8, 1.2)), ((2.5, 0.0, 3.0), (3.0, 1.9, 3.6))]  # fmt: skip


def furnished(**options):
    shapes = [box((0, 0, 0), (6, 2.5, 4), inwards=True, albedo=0.8)]
    shapes += [box(low, high, albedo=0.2 + 0.2 * n) for n, (low, high) in enumerate(TABLES)]
    return chosen(*shapes, **options)


def test_in_a_room_it_stands_in_free_space_at_the_height_of_eyes_and_looks_ahead():
    scene = furnished(lamp=lamp(3, 2.3, 2))
    position, forward = numbers(scene.camera.position), numbers(scene.camera.forward)
    clear = 0.1 * 2.5
    assert (position > clear).all()
    assert (position < np.array([6, 2.5, 4]) - clear).all()
    assert 0.4 < position[1] / 2.5 < 0.75
    for low, high in TABLES:
        nearest = np.clip(position, low, high)
        assert np.linalg.norm(position - nearest) > clear
    assert abs(forward[1]) < 0.2
    assert any("no camera" in note and "in a room" in note for note in scene.notes)


def test_a_room_without_a_ceiling_is_one():
    wall = {"two_sided": True}
    shapes = [
        box((-0.1, 0, 0), (0, 2.5, 5), **wall), box((6, 0, 0), (6.1, 2.5, 5), **wall),
        box((0, 0, -0.1), (6, 2.5, 0), **wall), box((0, 0, 5), (6, 2.5, 5.1), **wall),
        box((0, -0.1, 0), (6, 0, 5), albedo=0.3, **wall), box((1, 0, 1), (2, 0.8, 2), albedo=0.8),
    ]  # fmt: skip
    for ceiling in (None, "auto"):  # with which the sky's light stays outside
        scene = chosen(*shapes, ceiling=ceiling)
        x, y, z = numbers(scene.camera.position)
        assert 0 < x < 6
        assert 0.8 < y < 2.0
        assert 0 < z < 5
        assert any("no light comes" in note for note in scene.notes) == (ceiling is not None)


def test_it_stands_in_the_room_that_has_light():
    for lit in (0, 1):
        rooms = [box((10 * n, 0, 0), (10 * n + 4, 2.5, 4), inwards=True) for n in range(2)]
        things = [box((10 * n + 1, 0, 1), (10 * n + 2, 1, 2), albedo=0.8) for n in range(2)]
        scene = chosen(*rooms, *things, lamp=lamp(10 * lit + 2, 2.2, 3))
        assert 10 * lit < numbers(scene.camera.position)[0] < 10 * lit + 4


@pytest.mark.parametrize("up", ["y", "z", "-x"])
def test_up_is_heeded(up):
    scene = load(
        {"type": "scene", "room": box((-2, -2, -2), (2, 2, 2), inwards=True), "lamp": lamp(0.5, 0.5, 0.5)},
        up=up,
    )
    assert abs(numbers(scene.camera.forward) @ scene.up) < 0.2
    assert numbers(scene.camera.up) @ scene.up > 0


# ---- objects -----------------------------------------------------------------------------------


def test_a_solid_is_seen_from_outside_though_it_has_two_sides():
    ball = {"type": "sphere", "to_world": mi.ScalarTransform4f(), "bsdf": diffuse(0.5, two_sided=True)}
    for shape in (ball, box((-1, -1, -1), (1, 1, 1), two_sided=True)):
        scene = chosen(shape)
        assert np.linalg.norm(numbers(scene.camera.position)) > 2
        assert any("around it" in note for note in scene.notes)


@pytest.mark.parametrize("seed", range(6))
def test_objects_fit_into_the_picture_from_all_around(seed):
    rng = np.random.default_rng(seed)
    scale = 10.0 ** rng.uniform(-1, 4)
    offset = scale * rng.uniform(-20, 20, 3)
    size = np.exp(rng.uniform(-1.5, 1.5, 3))
    corners = np.stack(np.meshgrid(*np.stack([-size, size], 1), indexing="ij"), -1).reshape(-1, 3)
    scene = chosen(box(-size, size), scale=scale, offset=offset)
    points = corners * scale + offset
    seen = [in_picture(turned(scene.camera, offset, scene.up, a), points) for a in range(0, 360, 10)]
    widest = np.abs(seen).max()
    assert np.abs(seen[0]).max() < 1
    assert 0.85 < widest < 1  # a margin, and a small one


def test_a_ball_is_framed_by_its_silhouette():
    for radius in (0.02, 700.0):
        ball = {"type": "sphere", "to_world": mi.ScalarTransform4f().scale(radius), "bsdf": diffuse(0.5)}
        camera = chosen(ball).camera
        distance = np.linalg.norm(numbers(camera.position))
        half = np.tan(np.arcsin(radius / distance))  # of the cone around the ball
        height = np.linalg.norm(numbers(camera.up))
        assert 0.85 < half / height < 1


def test_the_orbit_is_the_nearest_one():
    points = np.random.default_rng(3).normal(size=(200, 3)) * [1, 2, 0.5]
    for degrees in ELEVATIONS:
        circle = orbit(points, np.array([0.0, 1, 0]), np.radians(degrees), 16 / 9)
        angles = np.radians(np.arange(0, 360, 0.5))
        middle = 0.5 * (points.min(0) + points.max(0))
        h = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
        view = np.array([-h[0], -h[1], 0])
        upward = np.array([-h[1], h[0], 0])
        radius, y = np.hypot(*(points - middle)[:, [0, 2]].T), (points - middle)[:, 1]
        swept = np.stack(
            [
                radius[:, None] * np.cos(angles),
                np.repeat(y[:, None], len(angles), 1),
                radius[:, None] * np.sin(angles),
            ],
            -1,
        )
        eye = circle.target - middle + circle.distance * np.array([*h, 0])
        depth = (swept - eye) @ view
        half = np.tan(np.radians(FOV / 2))
        reach = max(
            np.abs((swept - eye)[..., 2] / depth / half).max(),
            np.abs((swept - eye) @ upward / depth / half * 16 / 9).max(),
        )
        assert reach == pytest.approx(1 - MARGIN, abs=1e-3)


def test_grounds_and_domes_do_not_count():
    ground = box((-500, -0.1, -500), (500, 0, 500))
    dome = {
        "type": "sphere", "to_world": mi.ScalarTransform4f().scale(900), "flip_normals": True, "bsdf": diffuse(0.5),
    }  # fmt: skip
    things = [box((0, 0, 0), (1, 1, 1)), box((1.5, 0, 0), (2, 2, 1), albedo=0.2)]
    position = numbers(chosen(*things, ground).camera.position)
    assert np.linalg.norm(position - [1, 1, 0.5]) < 10
    assert position[1] > 0
    assert np.linalg.norm(numbers(chosen(*things, dome, lamp=lamp(0, 9, 9)).camera.position)) < 900


def test_what_has_one_side_is_seen_from_there():
    sheet = {
        "type": "rectangle", "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], 90), "bsdf": diffuse(0.5),
    }  # fmt: skip
    camera = chosen(sheet, lamp=lamp(0, -3, 0)).camera  # it faces down
    assert numbers(camera.position)[1] < 0


# ---- light -------------------------------------------------------------------------------------


def luminous(scene) -> float:
    """Share of the picture that is not black, of a scene seen through its camera."""
    field = ddgi.IrradianceField.fit(scene, small())
    camera = with_size(scene.camera, (32, 18))
    frame = None
    for tick in range(3):
        field, frame = ddgi.render_frame(scene, field, camera, tick, small(), frame)
    return float((frame.numpy().max(-1) > 1e-4).mean())


@pytest.mark.slow
def test_closed_cubes_are_not_black():
    cube = lambda **how: box((-1, -1, -1), (1, 1, 1), **how)  # noqa: E731
    assert luminous(chosen(cube())) > 0.1
    assert luminous(chosen(cube(inwards=True), lamp=lamp(0, 0.5, 0))) > 0.95
    # All faces turned the wrong way, but of two sides, with a lamp inside and none outside.
    assert luminous(chosen(cube(two_sided=True), lamp=lamp(0, 0.5, 0))) > 0.95


def test_where_nothing_is_lit_it_says_so():
    dark = chosen(box((-1, -1, -1), (1, 1, 1), inwards=True))  # the sky that it is given stays outside
    assert any("no light comes" in note for note in dark.notes)
    assert not any("no light comes" in note for note in chosen(box((-1, -1, -1), (1, 1, 1))).notes)


# ---- the same again ----------------------------------------------------------------------------


@pytest.mark.parametrize("inside", [True, False])
def test_a_larger_copy_is_seen_alike(inside):
    def made(scale):
        light = {
            "type": "point",
            "position": [3 * scale, 2.3 * scale, 2 * scale],
            "intensity": rgb(10.0 * scale**2),
        }
        if inside:
            return furnished(scale=scale, lamp=light).camera
        return chosen(*(box(*t, albedo=0.3) for t in TABLES), scale=scale).camera

    one, large = made(1.0), made(1000.0)
    np.testing.assert_allclose(numbers(large.position) / 1000, numbers(one.position), atol=2e-3)
    np.testing.assert_allclose(numbers(large.forward), numbers(one.forward), atol=2e-3)


@pytest.mark.parametrize("inside", [True, False])
def test_a_copy_far_away_is_seen_alike(inside):
    """And a turntable of it goes around the same place in it."""

    def made(x):
        if inside:
            return furnished(offset=(x, 0, 0), lamp=lamp(x + 3, 2.3, 2))
        return chosen(*(box(*t, albedo=0.3) for t in TABLES), offset=(x, 0, 0))

    one, far = made(0.0), made(16384.0)
    away = np.array([16384.0, 0, 0])
    np.testing.assert_allclose(numbers(far.camera.position) - away, numbers(one.camera.position), atol=2e-3)
    np.testing.assert_allclose(numbers(far.camera.forward), numbers(one.camera.forward), atol=2e-3)
    np.testing.assert_allclose(pivot(far) - away, pivot(one), atol=2e-3)


def test_the_same_scene_gets_the_same_camera():
    light = lamp(3, 2.3, 2)
    assert furnished(lamp=light).camera.same_view(furnished(lamp=light).camera)


def test_the_note_says_how_to_stand_there_again():
    description = {"type": "scene", "thing": box((3, 1, 2), (4, 5, 6))}
    scene = load(description)
    (note,) = [n for n in scene.notes if "--look" in n]
    look = [float(x) for x in note.split("--look ")[1].split(",")]
    again = load(description, look=look)
    assert len(again.cameras) == 1
    assert not any("--look" in n for n in again.notes)
    for name in ("position", "forward", "right", "up"):
        np.testing.assert_allclose(
            numbers(getattr(again.camera, name)), numbers(getattr(scene.camera, name)), rtol=1e-6, atol=1e-6
        )


def test_look_goes_before_the_cameras_of_a_scene_and_keeps_their_lens():
    scene = load("cornell-point", look=(0, 0, 2, 0, 0, 0))
    assert len(scene.cameras) == 2
    np.testing.assert_allclose(numbers(scene.camera.right), numbers(scene.cameras[1].right), atol=1e-6)
    with pytest.raises(SettingsError, match="six numbers"):
        load("cornell-point", look=(0, 0, 2))


@pytest.mark.scenes
def test_a_furnished_flat_is_seen_from_inside():
    path = SHARED / "dream-apartment" / "decoded.glb"
    if not path.exists():
        pytest.skip(f"shared scenes are not at {SHARED}")
    scene = load(path)
    assert 0.8 < numbers(scene.camera.position)[1] < 2  # its walls are 2.6 m high and open above
    assert any("in a room" in note for note in scene.notes)
