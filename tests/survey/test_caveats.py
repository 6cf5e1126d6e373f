"""Every warning: a scene that gives it, and one like it that does not."""

import re
from dataclasses import replace

import mitsuba as mi
import numpy as np
import pytest

import ddgi
from ddgi.scene.camera import look_at
from ddgi.survey.report import survey
from probing import changed, diffuse, load, rgb, room

LAMP = {"type": "point", "id": "lamp", "position": [0.5, 0.5, 0.5], "intensity": rgb(1.0)}
WHITE = diffuse(0.6)
INSIDE = {"eye": (-0.8, 0.1, 0.9), "target": (0.2, 0, -1.0)}


def transform():
    return mi.ScalarTransform4f()


def settings(**values):
    """512 probes over the room, 0.28 apart, the outermost just inside its walls."""
    over_the_room = {"grid_budget": 512, "grid_box": ((-1.0,) * 3, (1.0,) * 3), "grid_margin": -0.1}
    return changed(ddgi.RenderSettings.preset("default"), **(over_the_room | values))


def looked_over(description, eye=INSIDE["eye"], target=INSIDE["target"], options=None, **values):
    scene = load({"type": "scene", **description}, **(options or {}))
    return survey(replace(scene, cameras=(look_at(eye, target, size=(64, 48)),)), settings(**values))


def kinds(*arguments, **keywords):
    return [caveat.kind for caveat in looked_over(*arguments, **keywords).warnings]


def text(kind, *arguments, **keywords):
    (found,) = (c.text for c in looked_over(*arguments, **keywords).warnings if c.kind == kind)
    assert found.isprintable()  # one line
    return found


def box_room(half=1.0):
    return room(WHITE, half)


def test_a_sound_scene_has_none():
    assert kinds(box_room() | {"lamp": LAMP}) == []


def partition(thickness):
    """A wall across the middle of the room, with a gap beside it."""
    return {
        "type": "cube",
        "to_world": transform().translate([0.2, 0, 0]).scale([0.8, 1, thickness / 2]),
        "bsdf": WHITE,
    }


@pytest.mark.slow
def test_a_wall_that_is_thin_against_the_spacing():
    thin, thick = (box_room() | {"lamp": LAMP, "wall": partition(t)} for t in (0.1, 0.4))
    assert kinds(thick) == []
    advice = re.search(r"set grid.budget=(\d+), for a spacing of 0.18$", text("thin-walls", thin))
    assert kinds(thin, grid_budget=int(advice[1])) == []


def test_a_sheet_is_told_to_grow():
    sheet = {"type": "rectangle", "to_world": transform().translate([0.2, 0, 0]).scale([0.8, 1, 1])}
    sheet["bsdf"] = diffuse(0.6, two_sided=True)
    assert "give them thickness" in text("thin-walls", box_room() | {"lamp": LAMP, "wall": sheet})


def test_a_closed_room_of_sheets_is_no_trouble():
    """Its walls have no thickness, but no probes stand behind them."""
    found = looked_over(box_room() | {"lamp": LAMP})
    assert found.walls.sheets > 0.99
    assert found.warnings == ()


def test_no_light():
    assert kinds(box_room()) == ["no-light"]
    assert kinds(box_room(), options={"sky": (1.0, 1.0, 1.0)}) == []


def black(light):
    """The same light at no output; a fresh copy, as loading uses a dictionary up."""
    return {
        key: rgb(0.0) if key in ("intensity", "radiance", "irradiance") else v for key, v in light.items()
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    "light",
    [
        LAMP,
        {"type": "spot", "intensity": rgb(1.0)},
        {"type": "directional", "direction": [0, -1, 0], "irradiance": rgb(1.0)},
        {"type": "constant", "radiance": rgb(1.0)},
    ],
    ids=lambda light: light["type"],
)
def test_lights_that_give_none(light):
    assert "all-dark" not in kinds(box_room() | {"light": light})
    assert kinds(box_room() | {"light": black(light)}) == ["all-dark"]
    # One that shines is enough.
    assert kinds(box_room() | {"light": black(light), "other": LAMP | {"id": "other"}}) == []


def panel(radiance):
    place = transform().translate([0, 0.95, 0]).rotate([1, 0, 0], 90).scale(0.3)
    emitter = {"type": "area", "radiance": rgb(radiance)}
    return {"type": "rectangle", "id": "panel", "to_world": place, "bsdf": WHITE, "emitter": emitter}


@pytest.mark.slow
def test_area_lights_that_give_none():
    assert kinds(box_room() | {"panel": panel(1.0)}) == []
    assert kinds(box_room() | {"panel": panel(0.0)}) == ["all-dark"]


@pytest.mark.parametrize("light", [lambda: LAMP, lambda: panel(1.0), lambda: {"type": "constant"}])
def test_lights_that_are_switched_off(light):
    scene = load(
        {"type": "scene", **box_room(), "light": light()}, camera=look_at(INSIDE["eye"], INSIDE["target"])
    )
    assert [c.kind for c in survey(scene.dimmed(None, 0.0), settings()).warnings] == ["all-dark"]


def test_a_small_sun_in_a_black_picture_shines():
    texels = np.zeros((256, 512, 3), np.float32)
    texels[40, 100] = 1000
    sky = {"type": "envmap", "bitmap": mi.Bitmap(texels)}
    (lamp,) = looked_over(box_room() | {"sky": sky}).lights
    assert lamp.shines


@pytest.mark.slow
def test_a_light_outside_the_volume_is_named():
    far = LAMP | {"id": "moon", "position": [0.0, 30.0, 0.0]}
    assert "1 of 2 lights outside the volume (moon)" in text(
        "light-outside", box_room() | {"lamp": LAMP, "far": far}
    )
    assert kinds(box_room() | {"lamp": LAMP, "far": black(far)}) == []  # it matters to nobody


def test_sun_sky_and_dome_are_not_outside():
    dome = {"type": "sphere", "radius": 50.0, "flip_normals": True, "bsdf": diffuse(0.0)}
    dome["emitter"] = {"type": "area", "radiance": rgb(1.0)}
    sun = {"type": "directional", "direction": [0, -1, 0], "irradiance": rgb(1.0)}
    found = looked_over(box_room() | {"dome": dome, "sun": sun, "sky": {"type": "constant"}})
    assert [(lamp.kind, lamp.outside) for lamp in found.lights] == [
        ("directional", False),
        ("area", False),
        ("environment", False),
    ]
    assert found.warnings == ()


def test_a_view_outside_the_volume():
    small = ((-0.9, -0.9, 0.4), (-0.5, 0.9, 0.9))
    lit = box_room() | {"lamp": LAMP | {"position": [-0.7, 0.5, 0.8]}}
    assert "view-outside" in kinds(lit, grid_box=small)
    assert kinds(lit) == []


def ball(bsdf):
    return {"type": "sphere", "radius": 0.1, "center": [0.0, 0.0, 0.0], "bsdf": bsdf}


@pytest.mark.slow
@pytest.mark.parametrize("two_sided", [False, True])
def test_a_camera_in_an_object(two_sided):
    scene = box_room() | {"lamp": LAMP, "ball": ball(diffuse(0.5, two_sided=two_sided))}
    at = {"target": (0.0, 0.0, -0.9)}
    assert "inside-wall" in kinds(scene, eye=(0.0, 0.0, 0.0), **at)
    assert kinds(scene, eye=(0.0, 0.0, 0.9), **at) == []


def test_a_camera_in_a_black_room():
    """Turned away, its walls are black; the room is too large for a wall to stand in."""
    cube = {"type": "cube", "bsdf": WHITE, "to_world": transform().scale(1)}
    assert kinds({"room": cube, "lamp": LAMP}) == ["black-picture"]
    assert kinds({"room": cube | {"bsdf": diffuse(0.6, two_sided=True)}, "lamp": LAMP}) == []


def test_a_camera_that_sees_nothing():
    away = {"eye": (0, 0, 5), "target": (0, 0, 9)}
    found = looked_over(box_room() | {"lamp": LAMP}, **away, grid_box=None)
    assert [c.kind for c in found.warnings] == ["sees-nothing"]
    assert found.walls is None
    assert found.volume.source == "bounds"
    assert found.cameras[0].distance is None


@pytest.mark.parametrize(("walls_turned", "warned"), [(("left", "back", "floor"), True), (("left",), False)])
def test_faces_turned_away(walls_turned, warned):
    """A room of sheets, some of them turned away: from inside those are black."""
    angles = {"back": ([0, 1, 0], 0), "front": ([0, 1, 0], 180), "left": ([0, 1, 0], 90),
              "right": ([0, 1, 0], -90), "floor": ([1, 0, 0], -90), "top": ([1, 0, 0], 90)}  # fmt: skip
    walls = {}
    for name, (axis, angle) in angles.items():
        place = transform().rotate(axis, angle).translate([0, 0, -1])
        turn = transform().rotate([0, 1, 0], 180 if name in walls_turned else 0)
        walls[name] = {"type": "rectangle", "to_world": place @ turn, "bsdf": WHITE}
    found = looked_over(walls | {"lamp": LAMP}, eye=(0.9, 0.0, 0.9), target=(-1, 0.8, -1))
    assert [c.kind for c in found.warnings] == (["faces-turned-away"] if warned else [])
    assert (found.walls.black >= 0.5) == warned
    assert found.cameras[0].black < 0.95


def test_pictures_that_are_missing(tmp_path):
    """An OBJ of a floor under the sky."""
    (tmp_path / "a.mtl").write_text("newmtl tiles\nKd 1 1 1\nmap_Kd tiles.png\n")
    scene = tmp_path / "a.obj"
    scene.write_text("mtllib a.mtl\nv 0 0 0\nv 0 0 9\nv 9 0 9\nusemtl tiles\nf 1 2 3\n")

    def found():
        camera = look_at((4, 5, 5), (3, 0, 6))
        return [
            c
            for c in survey(load(scene, camera=camera, sky=(1, 1, 1)), settings()).warnings
            if c.kind == "textures-missing"
        ]

    (missing,) = found()
    assert "tiles.png" in missing.text
    mi.Bitmap(np.full((2, 2, 3), 200, np.uint8)).write(str(tmp_path / "tiles.png"))
    assert found() == []
    (tmp_path / "a.mtl").unlink()
    assert "a.mtl" in found()[0].text


def test_names_from_files_stay_on_their_line():
    far = [LAMP | {"id": f"moon\n{n}", "position": [0.0, 30.0, float(n)]} for n in range(7)]
    found = text(
        "light-outside", box_room() | {"lamp": LAMP} | {f"far{n}": light for n, light in enumerate(far)}
    )
    assert "and 2 more" in found
