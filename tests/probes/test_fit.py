"""The whole way from a scene without any numbers to a grid: rooms whose grid is known on paper."""

import mitsuba as mi
import numpy as np
import pytest

import ddgi
from ddgi.scene.camera import look_at
from probing import changed, dark_light, diffuse, load

BUDGETS = (8, 100, 2048)


def box(low, high):
    """Six walls without thickness that face in."""
    low, high = np.array(low, float), np.array(high, float)
    place = mi.ScalarTransform4f().translate((low + high) / 2).scale((high - low) / 2)
    return {"type": "cube", "to_world": place, "flip_normals": True, "bsdf": diffuse(0.6)}


def plate(low, high):
    """A solid block, both sides white."""
    return box(low, high) | {"flip_normals": False, "bsdf": diffuse(0.6, two_sided=True)}


def fitted(description, eye, target, budget=2048, size=1.0):
    """Counts, first and last planes and spacing [m] of the volume over what a camera sees."""
    camera = look_at(np.array(eye) * size, np.array(target) * size, size=(64, 36))
    scene = load({"type": "scene", "light": dark_light(), **description})
    scene.cameras = (camera,)
    field = ddgi.IrradianceField.fit(
        scene, changed(ddgi.RenderSettings.preset("default"), grid_budget=budget)
    )
    grid = field.volumes[0].grid
    first, spacing = np.ravel(grid.origin), np.ravel(grid.spacing)
    return np.array(grid.counts), first, first + spacing * (np.array(grid.counts) - 1), spacing


@pytest.mark.parametrize("size", [(4, 2.5, 6), (2, 2, 2), (12, 2.5, 3)])
def test_cells_of_a_room_are_cubes_that_spend_the_budget(size):
    size = np.array(size, float)
    counts, first, last, spacing = fitted({"room": box((0, 0, 0), size)}, 0.5 * size, 0.9 * size)
    assert 0.85 * 2048 <= counts.prod() <= 2048
    cube = (size.prod() / 2048) ** (1 / 3)  # of as many cells as there are probes; planes are one more
    assert np.allclose(spacing / cube, 1.1, atol=0.25)
    # Planes just inside every wall: nothing is wasted outside, and none stands in a wall.
    assert (first / spacing > 0.03).all()
    assert (first / spacing < 0.2).all()
    assert ((size - last) / spacing > 0.03).all()
    assert ((size - last) / spacing < 0.2).all()


@pytest.mark.parametrize("budget", BUDGETS)
def test_the_budget_is_kept(budget):
    counts, *_ = fitted({"room": box((0, 0, 0), (4, 2.5, 6))}, (2, 1, 3), (3, 1, 5), budget)
    assert counts.prod() <= budget
    assert counts.min() >= 2


def room_and_corridor(size=1.0):
    """A room of 4 x 4 with a corridor of 1 x 4 off its +x wall, joined by a door; 2.5 high."""
    wall, lintel = 0.1, 2.0
    return {
        "shell": box((0, 0, 0), np.array([5.1, 2.5, 4]) * size),
        "left-of-door": plate(np.array([4, 0, 0]) * size, np.array([4 + wall, 2.5, 1.5]) * size),
        "right-of-door": plate(np.array([4, 0, 2.5]) * size, np.array([4 + wall, 2.5, 4]) * size),
        "lintel": plate(np.array([4, lintel, 1.5]) * size, np.array([4 + wall, 2.5, 2.5]) * size),
    }


def test_a_corridor_beyond_a_door_has_planes_of_its_own():
    counts, first, last, spacing = fitted(room_and_corridor(), (1, 1.5, 2), (3, 1.3, 2))
    planes = first[0] + spacing[0] * np.arange(counts[0])
    assert ((planes > 4.1) & (planes < 5.1)).sum() >= 2
    assert last[0] > 4.8
    for face in (0, 4, 4.1, 5.1):  # none in a wall
        assert np.abs(planes - face).min() > 0.02 * spacing[0]
    assert not ((planes > 4) & (planes < 4.1)).any()


@pytest.mark.parametrize("size", [1e-3, 1000.0])
def test_a_scene_of_another_size_has_the_same_grid(size):
    one = fitted(room_and_corridor(), (1, 1.5, 2), (3, 1.3, 2))
    other = fitted(room_and_corridor(size), (1, 1.5, 2), (3, 1.3, 2), size=size)
    assert np.array_equal(one[0], other[0])
    for a, b in zip(one[1:], other[1:], strict=True):
        assert np.allclose(a, b / size, atol=0.01 * one[3].min())
