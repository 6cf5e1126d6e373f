"""Axes on surfaces, in which random directions are drawn."""

import mitsuba as mi
import numpy as np

from ddgi.trace.surface import frame
from probing import points, sphere_points


def axes(normals):
    """(3, N, 3): across, along, normal."""
    found = frame(mi.Normal3f(points(normals)))
    return np.stack([np.array(v, np.float64).T for v in (found.s, found.t, found.n)])


def test_axes_are_right_handed_and_at_right_angles():
    poles = [[0, 0, 1], [0, 0, -1], [1, 0, 0], [0, -1, 0], [0.6, -0.8, -1e-5], [0.6, 0.8, -0.01]]
    normals = np.concatenate([sphere_points(5000), poles])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    s, t, n = axes(normals)
    for a, b in ((s, t), (t, n), (n, s)):
        assert np.abs((a * b).sum(1)).max() < 1e-5
    assert np.abs(np.cross(s, t) - n).max() < 1e-5


def test_rounding_does_not_turn_the_axes_of_walls():
    """Mitsuba's turn over where z passes 0, so that a scene moved by a little would get other directions."""
    wall = np.array([[1.0, 0, 0], [0, -1, 0], [0.6, 0.8, 0]])
    for tiny in (1e-7, -1e-7, -0.0):
        assert np.allclose(axes(wall + np.array([0, 0, tiny])), axes(wall), atol=1e-6)
