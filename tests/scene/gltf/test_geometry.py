"""Where triangles stand, and which way they face."""

import numpy as np
import pytest

from ddgi.errors import SceneError
from ddgi.scene.gltf.primitives import FAN, STRIP
from ddgi.scene.gltf.primitives import triangles as assembled
from gltf_writing import CORNERS, SQUARE, Writer, shapes_of, triangles

HALF_TURN = [0, 1, 0, 0]
"""Around +y."""


def facing(shape):
    """(F, 3) unit normals by winding."""
    a, b, c = triangles(shape).transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def test_indices_of_every_width_and_none(tmp_path):
    for kind in ("u1", "u2", "u4", None):
        writer = Writer()
        if kind is None:
            mesh = writer.mesh(np.array(SQUARE)[CORNERS], None)
        else:
            mesh = writer.mesh(indices=None, primitive={"indices": writer.accessor(CORNERS, kind)})
        writer.node(mesh=mesh, name="square")
        np.testing.assert_array_equal(
            triangles(shapes_of(writer.gltf(tmp_path))["square"]).reshape(-1, 3), np.array(SQUARE)[CORNERS]
        )


def test_strips_and_fans_turn_alike():
    """The strip 0 1 2 3 4 and the fan around 0, as section 3.7.2.1 lists them."""
    corners = np.arange(5, dtype=np.uint32)
    assert assembled(corners, STRIP).tolist() == [[0, 1, 2], [1, 3, 2], [2, 3, 4]]
    assert assembled(corners, FAN).tolist() == [[1, 2, 0], [2, 3, 0], [3, 4, 0]]
    for mode in (4, STRIP, FAN):
        assert assembled(corners[:2], mode).shape == (0, 3)


def test_a_strip_faces_one_way(tmp_path):
    writer = Writer()
    writer.node(mesh=writer.mesh(indices=[0, 1, 3, 2], primitive={"mode": STRIP}), name="square")
    np.testing.assert_allclose(facing(shapes_of(writer.gltf(tmp_path))["square"]), [[0, 0, 1]] * 2)


def test_points_and_lines_are_counted(tmp_path):
    writer = Writer()
    writer.square()
    writer.node(mesh=writer.mesh(indices=None, primitive={"mode": 0}))
    writer.node(mesh=writer.mesh(indices=None, primitive={"mode": 3}))
    found = shapes_of(writer.gltf(tmp_path))
    assert set(found) == {"square", ""}
    assert found[""] == ("2 primitive(s) of points or lines left out",)


def test_triangles_without_area_are_counted(tmp_path):
    writer = Writer()
    writer.node(mesh=writer.mesh(indices=[*CORNERS, 1, 1, 2]), name="square")
    found = shapes_of(writer.gltf(tmp_path))
    assert len(found["square"]["faces"]) == 2
    assert found[""] == ("1 triangle(s) without area left out",)


@pytest.mark.parametrize(
    ("primitives", "message"),
    [
        ([([0, 0, 1, 1, 1, 1], 4)], "none of the 2 triangles has an area: export"),
        ([([0, 1, 1], 4), ([0, 1], 1)], "its only triangle has no area: export"),
        ([([0, 1], 1), ([0, 1, 2], 3), ([0], 0)], "only 2 line primitives and 1 point primitive: export"),
    ],
)
def test_files_without_a_surface_say_what_they_hold(tmp_path, primitives, message):
    writer = Writer()
    for indices, mode in primitives:
        writer.node(mesh=writer.mesh(indices=indices, primitive={"mode": mode}))
    with pytest.raises(SceneError, match=message):
        shapes_of(writer.gltf(tmp_path))


def test_hierarchy_and_parts(tmp_path):
    """Scale by 2, half a turn around +y, move by (10, 0, 0); then the parent moves by (0, 5, 0)."""
    writer = Writer()
    writer.square(root=False, translation=[10, 0, 0], rotation=HALF_TURN, scale=[2, 2, 2])
    writer.node(children=[0], matrix=[*np.eye(4).ravel().tolist()[:12], 0, 5, 0, 1])
    shape = shapes_of(writer.gltf(tmp_path))["square"]
    expected = np.array([[10, 5, 0], [8, 5, 0], [8, 7, 0], [10, 7, 0]])
    np.testing.assert_allclose(shape["positions"], expected, atol=1e-6)
    np.testing.assert_allclose(facing(shape), [[0, 0, -1]] * 2, atol=1e-6)


@pytest.mark.parametrize("scale", [[-1, 1, 1], [1, 1, -1], [-2, -3, -4]])
def test_mirrored_things_keep_their_front(tmp_path, scale):
    """Winding and normals of a mirrored mesh still agree, and face where the mirrored front does."""
    writer = Writer()
    normal = writer.accessor([[0, 0, 1]] * 4)
    writer.node(mesh=writer.mesh(NORMAL=normal), name="square", scale=scale)
    shape = shapes_of(writer.gltf(tmp_path))["square"]
    outward = [0, 0, np.sign(scale[2])]
    np.testing.assert_allclose(facing(shape), [outward] * 2, atol=1e-6)
    np.testing.assert_allclose(shape["normals"], [outward] * 4, atol=1e-6)


def test_normals_turn_with_uneven_scale(tmp_path):
    """Of the plane x + y = 1 stretched twofold along x the normal is (1/2, 1, 0)."""
    writer = Writer()
    positions = [[1, 0, 0], [0, 1, 0], [0, 1, 1]]
    normal = writer.accessor([[1, 1, 0]] * 3)  # not unit: made so
    writer.node(mesh=writer.mesh(positions, [0, 1, 2], NORMAL=normal), name="slope", scale=[2, 1, 1])
    shape = shapes_of(writer.gltf(tmp_path))["slope"]
    np.testing.assert_allclose(shape["normals"], [[1 / 5**0.5, 2 / 5**0.5, 0]] * 3, atol=1e-6)


def test_without_normals_faces_are_flat(tmp_path):
    writer = Writer()
    writer.square()
    assert "normals" not in shapes_of(writer.gltf(tmp_path))["square"]


def test_only_the_default_scene_is_shown(tmp_path):
    writer = Writer()
    writer.square(name="shown")
    writer.square(name="other", root=False)
    writer.json["scenes"].append({"nodes": [1]})
    assert set(shapes_of(writer.gltf(tmp_path))) == {"shown", ""}
    writer.json["scene"] = 1
    assert set(shapes_of(writer.gltf(tmp_path))) == {"other", ""}


def test_hidden_nodes(tmp_path):
    writer = Writer()
    writer.square(name="shown")
    writer.square(name="below", root=False)
    writer.node(children=[1], extensions={"KHR_node_visibility": {"visible": False}})
    assert set(shapes_of(writer.gltf(tmp_path))) == {"shown", ""}


def test_names_are_kept_and_made_unique(tmp_path):
    writer = Writer()
    for _ in range(2):
        writer.square(name="a chair.001")
    assert set(shapes_of(writer.gltf(tmp_path))) == {"a chair.001", "a chair.001-2", ""}


def test_a_morph_target_by_its_weight(tmp_path):
    writer = Writer()
    mesh = writer.mesh(primitive={"targets": [{"POSITION": 0}, {"POSITION": 1}]})
    writer.json["accessors"] = []
    writer.json["bufferViews"], writer.data = [], bytearray()
    for values in ([[0, 0, 1]] * 4, [[0, 2, 0]] * 4, SQUARE):
        writer.accessor(values)
    writer.json["meshes"][mesh] = {
        "weights": [0.5, 0],
        "primitives": [
            {
                "attributes": {"POSITION": 2},
                "indices": writer.accessor(CORNERS, "u2"),
                "targets": [{"POSITION": 0}, {"POSITION": 1}],
            }
        ],
    }
    writer.node(mesh=mesh, name="of the mesh")
    writer.node(mesh=mesh, name="of the node", weights=[0, 1])
    found = shapes_of(writer.gltf(tmp_path))
    np.testing.assert_allclose(found["of the mesh"]["positions"], np.add(SQUARE, [0, 0, 0.5]))
    np.testing.assert_allclose(found["of the node"]["positions"], np.add(SQUARE, [0, 2, 0]))


def skinned(**node):
    """The square: its lower corners on a joint at x = 5, its upper ones half on that and half on one at x = 7."""
    writer = Writer()
    joints = writer.accessor([[0, 1, 0, 0]] * 4, "u1")
    weights = writer.accessor([[1, 0, 0, 0]] * 2 + [[0.5, 0.5, 0, 0]] * 2)
    mesh = writer.mesh(JOINTS_0=joints, WEIGHTS_0=weights)
    writer.node(translation=[5, 0, 0])
    writer.node(translation=[7, 0, 0])
    shift = np.eye(4)
    shift[3, :3] = [0, 0, 3]  # column by column: moves by 3 along z
    bind = writer.accessor([np.eye(4).ravel(), shift.ravel()])
    writer.add("skins", {"joints": [0, 1], "inverseBindMatrices": bind})
    writer.node(mesh=mesh, skin=0, name="skinned", **node)
    return writer


def test_a_skin_at_rest_stands_where_its_joints_do(tmp_path):
    """The transform of the skinned node itself does not count."""
    shape = shapes_of(skinned(translation=[100, 0, 0]).gltf(tmp_path))["skinned"]
    np.testing.assert_allclose(
        shape["positions"], [[5, 0, 0], [6, 0, 0], [7, 1, 1.5], [6, 1, 1.5]], atol=1e-6
    )


def test_what_bends_is_kept(tmp_path):
    from ddgi import load_scene

    rig = load_scene(skinned().gltf(tmp_path), sky=[1, 1, 1]).rig
    assert [node.name for node in rig.nodes] == ["node-0", "node-1", "skinned"]
    assert (rig.nodes[2].skin, rig.nodes[2].shapes, rig.nodes[2].parent) == (0, ("skinned",), None)
    assert rig.skins[0].joints == (0, 1)
    assert rig.skins[0].inverse_bind[1, 2, 3] == 3
    kept = rig.bendable["skinned"]
    np.testing.assert_array_equal(kept.positions, SQUARE)
    np.testing.assert_array_equal(kept.weights[:, :2], [[1, 0], [1, 0], [0.5, 0.5], [0.5, 0.5]])


def test_joints_that_do_not_exist_are_refused(tmp_path):
    writer = skinned()
    writer.json["skins"][0]["joints"] = [0]
    with pytest.raises(SceneError, match="hangs on joint 1, but there are 1"):
        shapes_of(writer.gltf(tmp_path))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda n: n.update(children=[0]), r"nodes\[0\] is a child of both"),
        (lambda n: n.update(matrix=[1] * 16), "no placement"),
        (lambda n: n.update(rotation=[0, 0, 0, 0]), "no quaternion"),
        (lambda n: n.update(scale=[1e300, 1e300, 1]), "too far away|not finite"),
        (lambda n: n.update(mesh=7), r"nodes\[1\].mesh names number 7 of the meshes, but there are 2"),
    ],
)
def test_nodes_that_make_no_sense(tmp_path, change, message):
    writer = Writer()
    writer.square(root=False)
    writer.square()
    writer.node(children=[0])
    change(writer.json["nodes"][1])
    with pytest.raises(SceneError, match=message):
        shapes_of(writer.gltf(tmp_path))


def test_circles_and_long_chains(tmp_path):
    writer = Writer()
    writer.square()
    writer.node(root=False, children=[2])
    writer.node(root=False, children=[1])
    with pytest.raises(SceneError, match=r"nodes\[1\] is its own ancestor"):
        shapes_of(writer.gltf(tmp_path))
    writer = Writer()
    writer.square(root=False, name="deep")
    for index in range(5000):
        writer.node(root=False, children=[index], translation=[0, 0, 1])
    writer.json["scenes"][0]["nodes"] = [5000]
    np.testing.assert_allclose(shapes_of(writer.gltf(tmp_path))["deep"]["positions"][0], [0, 0, 5000])


@pytest.mark.slow
@pytest.mark.timeout(60)  # one matrix at a time takes that long
def test_a_hundred_thousand_nodes_in_a_chain(tmp_path):
    count, turn = 100_000, 1e-5  # [rad], each against the one above
    half = turn / 2
    node = {"rotation": [0, 0, np.sin(half), np.cos(half)], "translation": [turn, 0, 0]}
    writer = Writer()
    square = writer.square(root=False, name="deep")
    for index in range(count):
        writer.node(root=False, children=[square if index == 0 else index], **node)
    writer.json["scenes"][0]["nodes"] = [count]
    # Steps of one length along a circle of radius 1 whose middle is at +y, from its lowest point on.
    place = shapes_of(writer.gltf(tmp_path))["deep"]["positions"][0]
    np.testing.assert_allclose(place, [np.sin(1), 1 - np.cos(1), 0], atol=1e-5)


def test_many_nodes_that_show_one_mesh_without_a_name(tmp_path):
    writer = Writer()
    mesh = writer.mesh()
    for index in range(1000):
        writer.node(mesh=mesh, translation=[index, 0, 0])
    found = shapes_of(writer.gltf(tmp_path))
    names = ["mesh-0", *(f"mesh-0-{number}" for number in range(2, 1001))]
    assert list(found) == [*names, ""]
    assert [found[name]["positions"][0, 0] for name in names] == list(range(1000))


def test_indices_beyond_the_vertices(tmp_path):
    writer = Writer()
    writer.node(mesh=writer.mesh(indices=[0, 1, 4]))
    with pytest.raises(SceneError, match=r"accessors\[1\] names vertex 4, but there are 4"):
        shapes_of(writer.gltf(tmp_path))


def test_instances_stay_instances(tmp_path):
    from ddgi import load_scene

    writer = Writer()
    node = writer.square(name="tree")
    attributes = {
        "TRANSLATION": writer.accessor([[0, 0, 0], [0, 0, 4]]),
        "SCALE": writer.accessor([[1, 1, 1], [2, 2, 2]]),
    }
    writer.json["nodes"][node]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    scene = load_scene(writer.gltf(tmp_path), sky=[1, 1, 1])
    assert scene.triangles == 4
    assert set(scene.shapes) == {"tree"}
    assert [s.class_name() for s in scene.mi_scene.shapes()].count("Instance") == 2
    np.testing.assert_allclose(scene.bounds, [[0, 0, 0], [2, 2, 4]], atol=1e-5)
    writer.json["nodes"][node]["scale"] = [-1, 1, 1]  # mirrored: meshes of their own
    mirrored = load_scene(writer.gltf(tmp_path), sky=[1, 1, 1])
    np.testing.assert_allclose(mirrored.bounds, [[-2, 0, 0], [0, 2, 4]], atol=1e-5)
    assert any("mirrored" in note for note in mirrored.notes)
