"""Recordings are replayed for the constants they were made with, and for no others."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ddgi.replay import Replayed


@dataclass(frozen=True)
class Constants:
    low: int = 8
    high: int = 8
    flag: bool = True


def scaled(x, numbers, s):
    return x * (s.low + 10 * s.high + 100 * numbers[1]) + (1 if s.flag else 0)


def test_every_change_of_a_constant_counts():
    """Equal small numbers are one Python object; `dr.freeze` alone overlooks such changes."""
    run = Replayed(scaled)
    x = dr.opaque(mi.Float, 1, 3)
    for s, numbers in (
        (Constants(), (8, 8)),
        (Constants(high=0), (8, 8)),
        (Constants(low=0, high=0), (8, 8)),
        (Constants(flag=False), (8, 8)),
        (Constants(), (8, 0)),
        (Constants(), (8, 8)),
    ):
        expected = s.low + 10 * s.high + 100 * numbers[1] + s.flag
        assert dr.all(run(s, x, numbers) == expected)


def test_equal_constants_in_new_objects_are_replayed():
    run = Replayed(scaled)
    for tick in range(4):
        run(Constants(), dr.opaque(mi.Float, tick, 3), (1, 2))
    assert run.recordings == 1


def test_a_scene_that_goes_away_does_not_stop_another():
    """Mitsuba's registry of objects changes, and recordings that depend on it are made anew."""

    def hits(scene, x, _):
        return scene.ray_test(mi.Ray3f(mi.Point3f(0, 0, 1) + x, mi.Vector3f(0, 0, -1)))

    run = Replayed(hits)
    kept, other = (mi.load_dict({"type": "scene", "s": {"type": "rectangle"}}) for _ in range(2))
    x = dr.opaque(mi.Vector3f, [0, 0, 0])
    assert dr.all(run(Constants(), kept, x))
    del other
    assert dr.all(run(Constants(), kept, x))


@dataclass
class Tracing:
    weight: mi.Float
    serial: int


def test_recordings_of_one_scene_are_not_replayed_for_another():
    """Mitsuba's objects behind equal arrays may be others, and gone: the recording would read freed memory."""
    recorded = []

    def weighed(tracing, x, s):
        recorded.append(tracing.serial)
        return tracing.weight * x

    run = Replayed(weighed)
    for serial in (1, 1, 2, 2, 1):
        x = dr.opaque(mi.Float, serial, 3)
        assert dr.all(run(Constants(), Tracing(dr.opaque(mi.Float, 2, 3), serial), x) == 2 * serial)
    assert recorded == [1, 2, 1]
