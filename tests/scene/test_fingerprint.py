"""The fingerprint of a scene: the same for the same light, another for any other."""

import os
import subprocess
import sys
import time

import mitsuba as mi
import numpy as np
import pytest

import ddgi
from ddgi.scene.fingerprint import fingerprint

LIGHT = {"type": "point", "position": [0, 0, 2], "intensity": {"type": "rgb", "value": [1, 1, 1]}}


def description(**changes):
    ball = {"type": "sphere", "radius": 0.5, "bsdf": {"type": "diffuse"}}
    return {"type": "scene", "ball": ball, "light": LIGHT} | changes


def of(*arguments, **keywords):
    return fingerprint(ddgi.load_scene(*arguments, **keywords))


@pytest.mark.parametrize("name", ["cornell", "cornell-point", "house", "two-rooms"])
def test_the_same_scene_twice(name):
    assert of(name) == of(name)


def test_the_same_in_another_process():
    code = "import ddgi; from ddgi.scene.fingerprint import fingerprint; print(fingerprint(ddgi.load_scene('house')))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert found.strip() == of("house")


def test_camera_and_size_are_no_part_of_it():
    view = ddgi.look_at((0, 0, 3), (0, 0, 0))
    assert of("cornell") == of("cornell", size=(8, 8)) == of("cornell", camera=view)


@pytest.mark.parametrize(
    "other",
    [
        {"light": LIGHT | {"intensity": {"type": "rgb", "value": [1, 1, 1.001]}}},
        {"light": LIGHT | {"position": [0, 0, 2.001]}},
        {"ball": {"type": "sphere", "radius": 0.501, "bsdf": {"type": "diffuse"}}},
        {"ball": {"type": "sphere", "radius": 0.5, "bsdf": {"type": "roughconductor"}}},
        {"second": {"type": "sphere", "radius": 0.1}},
    ],
)
def test_any_other_light_changes_it(other):
    assert of(description()) != of(description(**other))


def test_materials_that_change_places_change_it():
    red, blue = (
        {"type": "diffuse", "reflectance": {"type": "rgb", "value": c}} for c in ([1, 0, 0], [0, 0, 1])
    )

    def scene(first, second):
        ball = {"type": "sphere", "radius": 0.5}
        refs = [{"type": "ref", "id": name} for name in (first, second)]
        return description(red=red, blue=blue, a=ball | {"bsdf": refs[0]}, b=ball | {"bsdf": refs[1]})

    assert of(scene("red", "blue")) != of(scene("blue", "red"))


def test_added_light_changes_it():
    assert (
        len(
            {
                of("cornell"),
                of("cornell", sun=(0, 45, 1)),
                of("cornell", sun=(0, 45, 2)),
                of("cornell", sky=(1, 1, 1)),
            }
        )
        == 4
    )


def test_a_moved_vertex_changes_it():
    ddgi.use_backend("auto")

    def scene(x):
        from ddgi.scene.mesh_keys import mesh

        corners = np.array([[0, 0, 0], [1, 0, 0], [x, 1, 0]], float)
        return description(card=mesh("card", corners, np.array([[0, 1, 2]]), bsdf={"type": "diffuse"}))

    assert of(scene(0.0)) == of(scene(0.0))
    assert of(scene(0.0)) != of(scene(1e-4))


def test_a_picture_that_changes_on_disk_changes_it(tmp_path):
    ddgi.use_backend("auto")
    picture = tmp_path / "a.png"

    def scene():
        texture = {"type": "bitmap", "filename": str(picture)}
        bsdf = {"type": "diffuse", "reflectance": texture}
        return of(description(ball={"type": "sphere", "bsdf": bsdf}))

    mi.Bitmap(np.full((4, 4, 3), 100, np.uint8)).write(str(picture))
    before = scene()
    assert scene() == before
    mi.Bitmap(np.full((4, 4, 3), 101, np.uint8)).write(str(picture))
    os.utime(picture, ns=(1, time.time_ns()))
    assert scene() != before
