"""Animations: what channels say, and where that puts the meshes of a file."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from ddgi.errors import SceneError
from ddgi.scene.load import load_scene
from ddgi.scene.play import find_clip, value_at
from ddgi.scene.rig import Channel, Clip
from gltf_writing import Writer

FILES = Path(__file__).parents[3] / "shared" / "scenes" / "gltf-features"
HALF = np.sqrt(0.5)


def channel(values, path="translation", interpolation="LINEAR", times=(1.0, 3.0)):
    return Channel(0, path, interpolation, np.array(times, np.float32), np.array(values, np.float32))


@pytest.mark.parametrize(
    ("time", "linear", "step"),
    [(0, 0, 0), (1, 0, 0), (1.5, 1, 0), (2, 2, 0), (3, 4, 4), (9, 4, 4)],
)
def test_lines_and_steps(time, linear, step):
    """Clamped at both ends, as appendix C of the specification asks."""
    for interpolation, wanted in (("LINEAR", linear), ("STEP", step)):
        found = value_at(channel([[0, 0, 1], [4, 0, 1]], interpolation=interpolation), time)
        np.testing.assert_allclose(found, [wanted, 0, 1], atol=1e-6)


def test_splines_are_the_cubic_that_keys_and_tangents_give():
    """x(t) = t^3 - 2 t and its derivative at the keys: Hermite's cubic is that very one."""

    def x(t):
        return t**3 - 2 * t

    def slope(t):
        return 3 * t**2 - 2

    keys = [[[slope(t)], [x(t)], [slope(t)]] for t in (1.0, 3.0)]
    spline = channel(keys, path="weights", interpolation="CUBICSPLINE")
    for time in (1.0, 1.3, 2.0, 2.9, 3.0):
        assert value_at(spline, time) == pytest.approx(x(time), abs=1e-5)


def test_rotations_turn_evenly_and_the_short_way():
    quarter = np.array([0, 0, HALF, HALF])
    for second in (quarter, -quarter):  # the same rotation
        turning = channel([[0, 0, 0, 1], second], path="rotation")
        for share in (0.25, 0.5, 0.75):
            angle = share * np.pi / 4
            found = value_at(turning, 1 + 2 * share)
            np.testing.assert_allclose(
                found * np.sign(found[3]), [0, 0, np.sin(angle), np.cos(angle)], atol=1e-6
            )


def test_rotations_of_splines_are_of_length_one():
    keys = [[[0, 0, 0, 0], [0, 0, 0, 1], [0, 0, 1, 0]], [[0, 0, 1, 0], [0, 0, HALF, HALF], [0, 0, 0, 0]]]
    spline = channel(keys, path="rotation", interpolation="CUBICSPLINE")
    for time in (1.0, 1.7, 3.0):
        assert np.linalg.norm(value_at(spline, time)) == pytest.approx(1, abs=1e-6)


def test_one_key_holds_always():
    for interpolation, values in (
        ("LINEAR", [[1, 2, 3]]),
        ("STEP", [[1, 2, 3]]),
        ("CUBICSPLINE", [[[0] * 3, [1, 2, 3], [0] * 3]]),
    ):
        for time in (0.0, 1.0, 5.0):
            found = value_at(channel(values, interpolation=interpolation, times=(1.0,)), time)
            np.testing.assert_allclose(found, [1, 2, 3])


def test_clips_by_name_and_number():
    clips = [Clip("walk", ()), Clip("run", ())]
    assert [find_clip(clips, w).name for w in (None, "run", 1, "0")] == ["walk", "run", "run", "walk"]
    for wanted, message in (("fly", "no animation 'fly': there are walk, run"), (2, "no animation 2")):
        with pytest.raises(SceneError, match=message):
            find_clip(clips, wanted)
    with pytest.raises(SceneError, match="there are none"):
        find_clip([], None)


def animated(writer, node, path, values, times=(0.0, 1.0), interpolation="LINEAR"):
    sampler = {
        "input": writer.accessor(times, min=[min(times)], max=[max(times)]),
        "output": writer.accessor(np.array(values, np.float32)), "interpolation": interpolation,
    }  # fmt: skip
    writer.add("animations", {
        "name": f"clip-{len(writer.json.get('animations', []))}", "samplers": [sampler],
        "channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
    })  # fmt: skip


def corners(scene, name="square"):
    """(low, high) of the box around a shape that moves, in the coordinates of the file."""
    return np.array(scene.motion.stage.boxes(scene.pose)[name]) + scene.origin


def test_children_go_with_their_parents(tmp_path):
    writer = Writer()
    child = writer.square(root=False, translation=[0, 1, 0])
    parent = writer.node(children=[child], translation=[1, 0, 0])
    animated(writer, parent, "translation", [[1, 0, 0], [5, 0, 0]])
    scene = load_scene(writer.gltf(tmp_path), sky=[1, 1, 1])
    for time, x in ((0, 1), (0.5, 3), (1, 5)):
        np.testing.assert_allclose(corners(scene.at(time)), [[x, 1, 0], [x + 1, 2, 0]], atol=1e-6)


def test_far_scenes_move_in_the_files_own_coordinates(tmp_path):
    writer = Writer()
    moving = writer.square(translation=[9000, 0, 0])
    animated(writer, moving, "translation", [[9000, 0, 0], [9000, 2, 0]])
    scene = load_scene(writer.gltf(tmp_path), sky=[1, 1, 1])
    assert np.any(scene.origin)
    np.testing.assert_allclose(corners(scene.at(1)), [[9000, 2, 0], [9001, 3, 0]], atol=1e-3)
    turned = np.eye(4)
    turned[:2, :2] = [[0, -1], [1, 0]]  # a quarter around the file's z
    np.testing.assert_allclose(
        corners(scene.moved("square", turned)), [[-1, 9000, 0], [0, 9001, 0]], atol=1e-2
    )


def test_what_rests_as_a_point_can_grow(tmp_path):
    writer = Writer()
    growing = writer.square(scale=[0, 0, 0], translation=[1, 0, 0])
    writer.node(name="floor", mesh=0)
    animated(writer, growing, "scale", [[0, 0, 0], [2, 2, 2]])
    scene = load_scene(writer.gltf(tmp_path), sky=[1, 1, 1])
    np.testing.assert_allclose(corners(scene.at(1)), [[1, 0, 0], [3, 2, 0]], atol=1e-6)


def test_lights_and_cameras_are_carried(tmp_path):
    writer = Writer()
    writer.square()
    writer.use("KHR_lights_punctual")
    writer.light({"type": "point", "intensity": 5.0}, name="bulb", translation=[0, 1, 0])
    animated(writer, 1, "translation", [[0, 1, 0], [0, 1, 4]])
    camera = writer.add("cameras", {"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}})
    eye = writer.node(name="eye", camera=camera, translation=[0, 0, 3])
    animated(writer, eye, "rotation", [[0, 0, 0, 1], [0, HALF, 0, HALF]])
    scene = load_scene(writer.gltf(tmp_path), size=(64, 32))
    assert np.array(scene.at(0.5, "clip-0").lights.delta.position)[:3].tolist() == [0, 1, 2]
    turned = scene.at(1, 1).camera
    np.testing.assert_allclose(np.ravel(turned.forward), [-1, 0, 0], atol=1e-6)
    assert turned.size == (64, 32)
    np.testing.assert_allclose(
        np.linalg.norm(np.ravel(turned.right)), np.linalg.norm(np.ravel(scene.camera.right)), rtol=1e-5
    )


def test_morph_targets_add_up(tmp_path):
    writer = Writer()
    up = writer.accessor(np.tile([[0, 0, 1.0]], (4, 1)))
    mesh = writer.mesh(primitive={"targets": [{"POSITION": up}]})
    node = writer.node(name="square", mesh=mesh)
    animated(writer, node, "weights", [[0.0], [2.0]])
    scene = load_scene(writer.gltf(tmp_path), sky=[1, 1, 1])
    for time, z in ((0, 0), (0.25, 0.5), (1, 2)):
        np.testing.assert_allclose(corners(scene.at(time)), [[0, 0, z], [1, 1, z]], atol=1e-6)


@pytest.mark.parametrize("times", [(0.0, 0.0), (1.0, 0.5)])
def test_channels_whose_times_do_not_rise_are_left_out(tmp_path, times):
    writer = Writer()
    animated(writer, writer.square(), "translation", [[0, 0, 0], [1, 0, 0]], times)
    scene = load_scene(writer.gltf(tmp_path), sky=[1, 1, 1])
    assert any("times do not rise" in note for note in scene.notes)
    assert scene.at(0.5).pose.matrices == {}


@pytest.mark.parametrize(
    ("name", "clip"),
    [("BoxAnimated", 0), ("RiggedSimple", 0), ("AnimatedTriangle", 0), ("SimpleMorph", 0), ("InterpolationTest", 3), ("InterpolationTest", 8)],
)  # fmt: skip
def test_a_moment_is_the_file_that_rests_so(tmp_path, name, clip):
    """A copy of the file whose nodes rest as the animation has them, loaded by itself."""
    if not (FILES / name).is_dir():
        pytest.skip("the sample files are not here")
    path = next(p for p in sorted((FILES / name).rglob("*.gl*")) if p.suffix == ".gltf")
    copy = Path(shutil.copytree(path.parent, tmp_path / "copy"))
    scene = load_scene(path, sky=[1, 1, 1])
    chosen = scene.rig.clips[clip]
    time = 0.37 * chosen.duration
    document = json.loads((copy / path.name).read_text())
    for c in chosen.channels:
        document["nodes"][c.node][c.path] = value_at(c, time).tolist()
    (copy / path.name).write_text(json.dumps(document))
    there, still = scene.at(time, clip), load_scene(copy / path.name, sky=[1, 1, 1])
    assert scene.motion.stage is not None
    ours, theirs = (s.motion.stage.boxes(s.pose) for s in (there, still))
    assert ours.keys() == theirs.keys()
    size = np.ptp(np.array(list(theirs.values())).reshape(-1, 3), 0).max()
    for shape, box in theirs.items():
        np.testing.assert_allclose(ours[shape], box, atol=1e-5 * size)
    moved = max(
        np.abs(np.array(ours[s]) - box).max() for s, box in scene.motion.stage.boxes(scene.pose).items()
    )
    assert moved > 0.01 * size, "it moves at all"
