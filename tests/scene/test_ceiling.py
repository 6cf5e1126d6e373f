"""A ceiling added to a scene without one: where it goes, and that the path tracer has it too."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError
from ddgi.scene.fingerprint import fingerprint
from probing import diffuse, load

WALLS = 2.5
"""Their height [m]."""
INNER, OUTER = 2.0, 2.1
"""Half sizes of the room along x and z [m]."""


def open_room(turn=None, size=1.0, **more):
    """Four walls 0.1 thick on a floor, a table, and a mast far away that is higher than all."""
    turn = mi.ScalarTransform4f() if turn is None else turn

    def box(low, high):
        low, high = np.array(low) * size, np.array(high) * size
        place = mi.ScalarTransform4f().translate((low + high) / 2).scale((high - low) / 2)
        return {"type": "cube", "to_world": turn @ place, "bsdf": diffuse(0.5)}

    return {
        "type": "scene",
        "floor": box((-OUTER, -0.1, -OUTER), (OUTER, 0, OUTER)),
        "left": box((-OUTER, 0, -OUTER), (-INNER, WALLS, OUTER)),
        "right": box((INNER, 0, -OUTER), (OUTER, WALLS, OUTER)),
        "back": box((-OUTER, 0, -OUTER), (OUTER, WALLS, -INNER)),
        "front": box((-OUTER, 0, INNER), (OUTER, WALLS, OUTER)),
        "table": box((-0.5, 0, -0.5), (0.5, 0.8, 0.5)),
        "mast": box((9, 0, 9), (9.02, 4, 9.02)),
        **more,
    }


def up_from(scene, point, up=(0, 1, 0)):
    """How far a ray comes."""
    ray = mi.Ray3f(mi.Point3f(*map(float, point)), mi.Vector3f(*map(float, up)))
    found = scene.mi_scene.ray_intersect(ray)
    return float(found.t[0])


@pytest.mark.parametrize("size", [0.01, 1.0, 1000.0])
def test_auto_is_the_top_of_the_walls(size):
    scene = load(open_room(size=size), ceiling="auto")
    found = up_from(scene, (1.5 * size, size, 1.5 * size)) + size
    assert WALLS * size * (1 - 1e-3) <= found <= WALLS * size * (1 + 1e-6)  # no crack above the walls
    assert any("ceiling" in note for note in scene.notes)


def test_a_height_is_taken_as_given():
    assert up_from(load(open_room(), ceiling=1.75), (1.5, 1.0, 1.5)) == pytest.approx(0.75, abs=1e-4)


@pytest.mark.parametrize("up, axis, angle", [((0, 0, 1), [1, 0, 0], 90), ((-1, 0, 0), [0, 0, 1], 90)])
def test_any_direction_may_be_up(up, axis, angle):
    turn = mi.ScalarTransform4f().rotate(axis, angle)
    scene = load(open_room(turn=turn), ceiling="auto", up=up)
    assert up_from(scene, turn @ mi.ScalarPoint3f(1.5, 1.0, -1.5), up) == pytest.approx(WALLS - 1, abs=2e-3)


def test_it_covers_the_walls_and_no_more():
    """A mast far away stretches the bounding box; the ceiling stays over the room, so the sun still enters."""
    scene = load(open_room(), ceiling=2.4)
    for beyond in ((7, 1, 7), (-1.1 * OUTER, 1, 0), (1.1 * OUTER, 1, 0)):
        assert np.isinf(up_from(scene, beyond))
    for x, z in ((-OUTER, -OUTER), (OUTER, OUTER), (-OUTER, OUTER)):
        assert np.isfinite(up_from(scene, (0.97 * x, 1.0, 0.97 * z)))


def test_it_has_a_thickness():
    scene = load(open_room(), ceiling=WALLS)
    down = up_from(scene, (1.5, 3.5, 1.5), (0, -1, 0))
    assert 3.5 - down > WALLS + 0.1


def test_it_is_white_on_both_sides():
    scene = load(open_room(), ceiling="auto")
    row = scene.shapes["added-ceiling"]
    from ddgi.trace.materials import lookup

    material = lookup(scene.materials, mi.UInt32(row), mi.Point2f(0.5), mi.Bool(True))
    assert np.allclose(np.ravel(material.base), 0.8, atol=1e-4)
    assert bool(material.double_sided[0])


def test_a_path_tracer_has_it_too():
    plain, covered = load(open_room()), load(open_room(), ceiling="auto")
    assert fingerprint(plain) != fingerprint(covered)
    assert fingerprint(covered) == fingerprint(load(open_room(), ceiling="auto"))
    assert fingerprint(covered) != fingerprint(load(open_room(), ceiling=2.0))
    source = mi.parser.instantiate(mi.parser.ParserConfig(mi.variant()), covered.source)
    ray = mi.Ray3f(mi.Point3f(1.5, 1, 1.5), mi.Vector3f(0, 1, 0))
    assert float(source.ray_intersect(ray).t[0]) == pytest.approx(WALLS - 1, abs=2e-3)


@pytest.mark.parametrize("height", [-0.2, -5.0, float("nan"), float("inf"), "high", True])
def test_heights_that_make_no_sense(height):
    with pytest.raises(SceneError, match=r"^ceiling must be[^\n]*$"):
        load(open_room(), ceiling=height)


def test_auto_needs_walls():
    plain = {"type": "scene", "ground": {"type": "rectangle", "bsdf": diffuse(0.5)}}
    with pytest.raises(SceneError, match="no walls"):
        load(plain, ceiling="auto", up="z")
