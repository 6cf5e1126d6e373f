"""Where probes stand."""

import math

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SettingsError
from ddgi.probes import grid, volume
from ddgi.probes.walls import Walls
from ddgi.settings import RenderSettings
from probing import changed, lattice

BOXES = [
    ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)),
    ((0.0, 5.0, -3.0), (40.0, 9.0, 17.0)),
    ((1e-3, 2e-3, -1e-3), (5e-3, 3e-3, 4e-3)),
]


def corners(g):
    """(2, 3) positions of the first and the last probe."""
    return np.array(g.position(mi.UInt32([0, g.size - 1])), np.float64).T


def numbers(g):
    return np.array(g.origin, np.float64).ravel(), np.array(g.spacing, np.float64).ravel()


def everywhere(g):
    """(P, 3)."""
    return np.array(g.position(dr.arange(mi.UInt32, g.size)), np.float64).T


@pytest.mark.parametrize("box", BOXES)
@pytest.mark.parametrize("budget", [8, 27, 64, 2048, 30_000])
def test_budget_is_kept_and_used(box, budget):
    g = grid.fit(box, grid.Settings(budget=budget))
    assert g.size <= budget
    assert min(g.counts) >= 2
    if budget >= 2048:
        # Counts are whole numbers: the next finer grid adds a plane to each axis.
        assert math.prod(n + 1 for n in g.counts) > budget


@pytest.mark.parametrize("box", BOXES)
@pytest.mark.parametrize("margin", [-0.1, 0.0, 0.45, 1.0])
def test_margin_is_exact_for_budget_and_counts(box, margin):
    for s in (grid.Settings(margin=margin), grid.Settings(margin=margin, counts=(9, 7, 8))):
        g = grid.fit(box, s)
        _, spacing = numbers(g)
        size = np.array(box[1]) - np.array(box[0])
        first, last = corners(g)
        assert np.allclose(
            (np.array(box[0]) - first) / spacing, margin, atol=1e-4 * size.max() / spacing.min()
        )
        assert np.allclose(
            (last - np.array(box[1])) / spacing, margin, atol=1e-4 * size.max() / spacing.min()
        )


@pytest.mark.parametrize("box", BOXES)
def test_spacing_is_taken_as_given(box):
    step = 0.11 * max(high - low for low, high in zip(*box, strict=True))
    g = grid.fit(box, grid.Settings(spacing=step, margin=0.45))
    _, spacing = numbers(g)
    assert np.allclose(spacing, step, rtol=1e-6)
    first, last = corners(g)
    # Whole counts make the margin larger than asked, by less than half a spacing on either side.
    for reach in ((np.array(box[0]) - first) / step, (last - np.array(box[1])) / step):
        assert (reach >= 0.45 - 1e-4).all()
        assert (reach <= 0.45 + 0.5 + 1e-4).all()


def test_counts_and_spacing_together():
    g = grid.fit(BOXES[0], grid.Settings(counts=(3, 4, 5), spacing=0.25, margin=0.0))
    origin, spacing = numbers(g)
    assert g.counts == (3, 4, 5)
    assert np.allclose(spacing, 0.25)
    assert np.allclose(origin, [-0.25, -0.375, -0.5])  # centred


def test_counts_win_over_the_budget():
    assert grid.fit(BOXES[0], grid.Settings(counts=(5, 6, 7), budget=8)).counts == (5, 6, 7)


def test_settings_box_wins_over_the_scene():
    g = grid.fit(BOXES[0], grid.Settings(box=((10, 10, 10), (12, 12, 12)), counts=(4, 4, 4), margin=0))
    assert np.allclose(corners(g), [[10, 10, 10], [12, 12, 12]])


@pytest.mark.parametrize("box", [*BOXES, ((0.0, 0.0, 0.0), (3.0, 0.0, 2.0))])
@pytest.mark.parametrize(
    "s", [grid.Settings(), grid.Settings(counts=(4, 5, 6)), grid.Settings(budget=100, margin=1.0)], ids=str
)
def test_every_probe_inside_the_widened_box(box, s):
    g = grid.fit(box, s)
    _, spacing = numbers(g)
    low, high = np.array(box[0]), np.array(box[1])
    at = everywhere(g)
    slack = 1e-5 * np.abs([low, high]).max() + 1e-4 * spacing
    # Counts are whole: from a budget, an axis thinner than the step reaches up to half a spacing further.
    margin = 0.5 if s.margin is None else s.margin  # none: wherever the walls allow
    reach = (margin if s.counts is not None else margin + 0.5) * spacing
    if s.counts is not None:
        reach = np.where(high > low, reach, 3 * spacing)  # a flat side: a token thickness
    assert (at >= low - reach - slack).all()
    assert (at <= high + reach + slack).all()


def test_flat_boxes_get_two_planes():
    g = grid.fit(((0, 0, 0), (4, 0, 4)), grid.Settings(budget=200))
    assert g.counts[1] == 2 or g.counts[1] == 3
    assert (numbers(g)[1] > 0).all()


@pytest.mark.parametrize("margin", [None, -0.1, 0.0, 0.45, 0.6, 1.0])
@pytest.mark.parametrize("size", [(4, 0, 4), (1, 1, 0), (0, 3, 0), (0.001, 1, 2), (1e-3, 2e-3, 0)], ids=str)
def test_cells_of_flat_boxes_are_as_high_as_long(size, margin):
    size = np.array(size, float)
    low = np.array([5.0, -2.0, 0.5]) * size.max()
    g = grid.fit((tuple(low), tuple(low + size)), grid.Settings(margin=margin))
    origin, spacing = numbers(g)
    flat = size < 1e-2 * size.max()
    assert g.size <= 2048
    assert np.allclose(spacing, spacing.min(), rtol=0.1)
    # As many planes on either side of what is flat, the nearest half a spacing from its middle.
    middle = (low + size / 2 - origin) / spacing
    assert np.allclose(middle[flat], (np.array(g.counts)[flat] - 1) / 2, atol=1e-3)
    assert all(n % 2 == 0 for n in np.array(g.counts)[flat])
    reach = (np.array(g.counts)[flat] - 1) / 2
    assert (reach >= (margin or 0) - 1e-6).all()


def test_low_rooms_are_not_flat():
    """A hall of 100 x 100 x 2.5 for few probes: no plane leaves it, though its cells are long."""
    box, s = ((0.0, 0.0, 0.0), (100.0, 2.5, 100.0)), grid.Settings(budget=60)
    none = Walls(np.zeros(0), np.zeros(0), np.zeros(0))
    facing_in = Walls(np.array([0.0, 2.5]), np.array([1.0, -1.0]), np.array([0.5, 0.5]))
    facing_out = Walls(np.array([0.0, 2.5]), np.array([-1.0, 1.0]), np.array([0.5, 0.5]))
    first, last = corners(grid.fit(box, s, [none, facing_in, none]))[:, 1]
    assert 0 < first < last < 2.5
    first, last = corners(grid.fit(box, s, [none, facing_out, none]))[:, 1]  # a slab seen from outside
    assert first < -5
    assert last > 7.5


def test_counts_and_spacing_of_flat_boxes_are_taken_as_given():
    box = ((0.0, 0.0, 0.0), (4.0, 0.0, 4.0))
    assert np.allclose(numbers(grid.fit(box, grid.Settings(spacing=0.5)))[1], 0.5)
    g = grid.fit(box, grid.Settings(counts=(5, 3, 5), margin=0))
    assert g.counts == (5, 3, 5)
    assert numbers(g)[1][1] == pytest.approx(4e-3 / 2)  # a token thickness


def test_number_and_position_are_inverse():
    g = lattice((3, 5, 4), (1.0, -2.0, 3.0), (0.5, 0.25, 2.0))
    x, y, z = (c.ravel() for c in np.meshgrid(range(3), range(5), range(4), indexing="ij"))
    number = g.number(*(mi.UInt32(c) for c in (x, y, z)))
    assert np.array_equal(np.sort(np.array(number)), np.arange(g.size))
    at = np.array(g.position(number), np.float64).T
    assert np.allclose(at, np.stack([1 + 0.5 * x, -2 + 0.25 * y, 3 + 2.0 * z], 1))


def test_x_runs_fastest():
    assert int(lattice((3, 5, 4)).number(mi.UInt32(1), mi.UInt32(2), mi.UInt32(3))[0]) == 1 + 3 * (2 + 5 * 3)


def test_diagonal_and_smallest_spacing():
    g = lattice(spacing=(3.0, 4.0, 12.0))
    assert float(g.diagonal[0]) == pytest.approx(13.0)
    assert float(g.smallest_spacing[0]) == pytest.approx(3.0)


INF, NAN = math.inf, math.nan


@pytest.mark.parametrize(
    "box",
    [
        ((0, 0, 0), (0, 0, 0)),
        ((1, 0, 0), (0, 1, 1)),
        ((0, 0, 0), (INF, 1, 1)),
        ((0, NAN, 0), (1, 1, 1)),
        ((-INF, 0, 0), (1, 1, 1)),
    ],
)
def test_impossible_boxes(box):
    with pytest.raises(SettingsError, match="box"):
        grid.fit(box, grid.Settings())
    with pytest.raises(SettingsError, match="box"):
        grid.fit(BOXES[0], grid.Settings(box=box))


@pytest.mark.parametrize("counts", [(1, 4, 4), (4, 0, 4), (4, 4, -3)])
def test_impossible_counts(counts):
    with pytest.raises(SettingsError, match="counts"):
        grid.fit(BOXES[0], grid.Settings(counts=counts))


def test_memory_error_states_need_and_budget():
    s = RenderSettings.preset("default")
    g = grid.fit(BOXES[0], grid.Settings(counts=(100, 100, 100)))
    # Two maps of (8 + 2)^2 16-byte and (16 + 2)^2 8-byte texels, held twice while they are blended.
    maps = 1_000_000 * 2 * (100 * 16 + 324 * 8) / 1e6
    with pytest.raises(SettingsError) as error:
        volume.allocate(g, s.volume, s.rays.per_probe, 4096.0)
    text = str(error.value)
    assert "4,096 MB" in text
    need = float(text.split("about ")[1].split(" MB")[0].replace(",", ""))
    assert need >= maps
    assert "\n" not in text


def test_memory_limit_holds_before_anything_is_allocated():
    s = changed(RenderSettings.preset("default"), grid_spacing=1e-7)
    with pytest.raises(SettingsError, match="MB"):
        volume.allocate(grid.fit(BOXES[0], s.grid), s.volume, s.rays.per_probe, s.grid.memory_limit)


def test_small_volumes_fit():
    s = RenderSettings.preset("default")
    vol = volume.allocate(lattice((2, 2, 2)), s.volume, 128, 4096.0)
    assert dr.width(vol.irradiance) == 8 * 14 * 14 * 4
    assert dr.width(vol.distance) == 8 * 18 * 18 * 2
    assert dr.width(vol.radiance) == 8 * 10 * 10 * 4
    assert float(vol.reach(s.volume)[0]) == pytest.approx(1.5 * math.sqrt(3))
    assert volume.bytes_per_probe(s.volume) == (14 * 14 + 10 * 10) * 16 + 18 * 18 * 8
