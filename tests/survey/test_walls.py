"""Shares of thin walls and of faces turned away, on faces made by hand over a grid that is known."""

import numpy as np
import pytest

from ddgi.survey.faces import Faces
from ddgi.survey.volume import Volume
from ddgi.survey.walls import LEAKY, probes_behind, walls

SPACING = 1.0


def grid(spacing=SPACING, first=-1.75, counts=5):
    """Planes of probes at first + k spacing along each axis: -1.75, -0.75, 0.25, 1.25, 2.25."""
    last = first + spacing * (counts - 1)
    return Volume(
        "settings",
        (counts,) * 3,
        (spacing,) * 3,
        ((first,) * 3, (last,) * 3),
        counts**3,
        0,
        counts**3,
        1,
        counts**3,
    )


def faces(thickness, position=(0.0, 0.0, 0.0), normal=(1.0, 0.0, 0.0), **flags):
    """Faces of some thickness; at one place unless there are more."""
    thickness = np.atleast_1d(np.asarray(thickness, float))
    n = len(thickness)
    no, yes = np.zeros(n, bool), np.ones(n, bool)
    return Faces(
        hit=flags.get("hit", yes),
        position=np.broadcast_to(np.asarray(position, float), (n, 3)),
        normal=np.broadcast_to(np.asarray(normal, float), (n, 3)),
        distance=np.ones(n),
        behind=flags.get("behind", no),
        black=flags.get("black", no),
        matt=yes,
        thickness=thickness,
    )


def test_probes_stand_behind_what_is_thinner_than_the_way_to_them():
    """The face at x = 0 looks towards +x; the probes behind it stand at -0.75."""
    assert probes_behind(faces([0.0, 0.3, 0.7, 0.8, 2.0]), grid()).tolist() == [
        True,
        True,
        True,
        False,
        False,
    ]


def test_beyond_the_last_plane_no_probe_is_behind():
    """Walls just outside the volume, as fitted grids have them: all probes of the cell are in front."""
    assert not probes_behind(faces(0.0, position=(-1.85, 0, 0)), grid()).any()
    assert probes_behind(faces(0.0, position=(-1.65, 0, 0)), grid()).all()
    assert probes_behind(faces(0.0, position=(-1.85, 0, 0), normal=(-1, 0, 0)), grid()).all()


def test_a_plane_in_the_face_itself_is_not_behind():
    assert not probes_behind(faces(0.0, position=(-1.75, 0, 0)), grid()).any()


def test_shares():
    found = walls(faces([0.0, 0.0, 0.2, 0.4, 0.49, 0.51, 0.7, 0.8, 2.0, 9.0]), grid())
    assert found.sheets == pytest.approx(0.2)
    assert found.thin == pytest.approx(0.5)  # under half a spacing
    assert found.leaky == pytest.approx(0.5)  # the probes behind are 0.75 away


def test_thin_walls_without_probes_behind_do_not_leak():
    found = walls(faces([0.0] * 10, position=(-1.85, 0, 0)), grid())
    assert (found.sheets, found.thin, found.leaky) == (1, 1, 0)


def test_slanted_walls_are_measured_against_the_diagonal():
    """Along (1, 1, 1) planes of a cubic grid's corners lie sqrt(3) spacings apart."""
    normal = np.ones(3) / np.sqrt(3)
    assert walls(faces(0.49 * np.sqrt(3), normal=normal), grid()).thin == 1
    assert walls(faces(0.51 * np.sqrt(3), normal=normal), grid()).thin == 0


def test_a_spacing_below_the_one_needed_is_enough():
    thickness = np.linspace(0.1, 1.0, 100)
    coarse = walls(faces(thickness), grid())
    assert coarse.leaky > LEAKY
    for change, enough in ((0.95, True), (1.2, False)):
        spacing = change * coarse.spacing_needed
        # The planes lie to the face as before: a quarter of a spacing in front of it.
        found = walls(faces(thickness), grid(spacing, -1.75 * spacing))
        assert (found.leaky < LEAKY) == enough


def test_no_spacing_helps_sheets():
    assert walls(faces([0.0] * 3 + [5.0] * 7), grid()).spacing_needed is None


def test_nothing_is_needed_where_walls_are_thick():
    assert walls(faces([5.0] * 10), grid()).spacing_needed is None


def test_faces_that_are_black_or_outside_are_not_judged_for_thickness():
    black = np.array([True, True, False])
    found = walls(faces([0.0, 0.0, 5.0], black=black, behind=black), grid())
    assert (found.black, found.behind) == (pytest.approx(2 / 3), pytest.approx(2 / 3))
    assert found.sheets == 0
    far = faces([0.0], position=(10.0, 0, 0))
    assert walls(far, grid()).sheets == 0
    assert walls(far, grid()).seen == 1


def test_rays_that_met_nothing_do_not_count():
    hit = np.array([True, False])
    assert walls(faces([5.0, 0.0], hit=hit), grid()).sheets == 0
    assert walls(faces([0.0], hit=np.array([False])), grid()) is None


def test_outside_begins_a_cell_beyond_the_box():
    volume = grid()  # from -1.75 to 2.25
    assert not volume.outside(np.array([-2.7, 0, 3.2]))
    assert volume.outside(np.array([[-2.8, 0, 0], [0, 3.3, 0], [0, 0, -2.8]])).all()
    assert not volume.outside(np.array([-4.0, 0, 0]), reach=1.5)
