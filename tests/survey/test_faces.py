"""What paths from cameras meet: sides and thickness of things whose sides and thickness are known."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.scene.camera import look_at
from ddgi.survey.faces import PATHS, met
from probing import diffuse, load, rgb

EYE, TARGET = (0, 0, 5), (0, 0, 0)
LAMP = {"type": "point", "position": [0, 0, 4], "intensity": rgb(1.0)}


def first_met(thing, **more):
    """What the pixels of a camera at z = 5 show of a thing at the origin that fills its picture."""
    scene = load({"type": "scene", "thing": thing, "lamp": LAMP, **more})
    camera = look_at(EYE, TARGET, fov=20.0, size=(64, 64))
    scene.cameras = (camera,)
    return met(scene)[0]


def slab(thickness, bsdf=None, **more):
    """A plate across z, its middle at the origin."""
    to_world = mi.ScalarTransform4f().scale([3, 3, thickness / 2])
    return {"type": "cube", "to_world": to_world, "bsdf": bsdf or diffuse(0.5), **more}


def sheet(z=0.0, *, away=False, bsdf=None):
    """A rectangle across z that faces the camera, or away from it."""
    to_world = mi.ScalarTransform4f().translate([0, 0, z]).rotate([0, 1, 0], 180 if away else 0).scale(3)
    return {"type": "rectangle", "to_world": to_world, "bsdf": bsdf or diffuse(0.5)}


@pytest.mark.parametrize("thickness", [0.01, 0.3, 2.0])
@pytest.mark.parametrize("two_sided", [False, True])
def test_a_solid_is_as_thick_as_it_is(thickness, two_sided):
    found = first_met(slab(thickness, diffuse(0.5, two_sided=two_sided)))
    assert found.hit.all()
    met_in_front = np.abs(found.position[:, 2] - thickness / 2) < 1e-5
    assert (
        met_in_front & (np.abs(found.thickness / thickness - 1) < 1e-3)
    ).mean() > 0.999  # some slip through edges
    assert np.allclose(found.normal, [0, 0, 1], atol=1e-5)
    assert found.behind.mean() < 0.001


def test_a_sheet_has_no_thickness():
    found = first_met(sheet())
    assert found.hit.all()
    assert (found.thickness == 0).all()


def test_two_skins_that_face_out_are_a_wall():
    found = first_met(sheet(0.1), other=sheet(-0.1, away=True))
    assert np.allclose(found.thickness, 0.2, atol=1e-3)


def test_two_sheets_that_face_the_same_way_are_sheets():
    """Behind the first lies a room whose far wall is the second."""
    assert (first_met(sheet(0.1), other=sheet(-0.1)).thickness == 0).all()


@pytest.mark.parametrize("two_sided", [False, True])
def test_a_face_from_behind_is_black_unless_it_has_two_sides(two_sided):
    found = first_met(sheet(away=True, bsdf=diffuse(0.5, two_sided=two_sided)))
    assert found.behind.all()
    assert (found.black == (not two_sided)).all()
    assert (found.matt == two_sided).all()
    assert (found.thickness == 0).all()


def test_what_shines_is_not_matt():
    found = first_met(sheet() | {"emitter": {"type": "area", "radiance": rgb(1.0)}})
    assert found.hit.all()
    assert not found.matt.any()


def test_paths_go_on_to_what_is_behind_the_camera():
    scene = load({"type": "scene", "thing": sheet(), "wall": sheet(20.0, away=True), "lamp": LAMP})
    scene.cameras = (look_at(EYE, TARGET, fov=20.0, size=(64, 64)),)
    first, second, *_ = met(scene)
    assert np.allclose(first.position[:, 2], 0, atol=1e-5)
    assert second.hit.any()
    assert np.allclose(second.position[second.hit][:, 2], 20, atol=1e-4)


def test_each_camera_has_its_own():
    scene = load({"type": "scene", "thing": sheet(), "lamp": LAMP})
    looking, away = look_at(EYE, TARGET, fov=20.0, size=(64, 64)), look_at(EYE, (0, 0, 9), size=(32, 8))
    scene.cameras = (looking, away)
    pixels = met(scene)[0]
    assert len(pixels) == 2 * PATHS
    assert pixels.of_camera(0).hit.all()
    assert not pixels.of_camera(1).hit.any()


def test_what_is_seen_covers_the_picture():
    """A sheet over the left third of a picture is hit by a third of the paths."""
    third = {"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([-4, 0, 0]).scale([3, 9, 1])}
    scene = load({"type": "scene", "thing": third | {"bsdf": diffuse(0.5)}, "lamp": LAMP})
    # At distance 5 the picture is 6 wide: from -3 to 3, and the sheet ends at -1.
    scene.cameras = (look_at(EYE, TARGET, fov=2 * np.degrees(np.arctan(0.6)), size=(300, 100)),)
    assert met(scene)[0].hit.mean() == pytest.approx(1 / 3, abs=0.01)
