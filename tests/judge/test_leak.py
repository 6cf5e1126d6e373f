"""Leak and dark, on answers known on paper."""

from dataclasses import replace
from types import SimpleNamespace

import mitsuba as mi
import numpy as np
import pytest

from ddgi.judge.leak import dark, leak, leaked
from ddgi.probes import query
from ddgi.scene.camera import look_at
from probing import diffuse, load, rgb, small, updated

RNG = np.random.default_rng(8)


def reference(light, noise=0.0, shape=(40, 50)):
    """Halves whose indirect light is a constant radiance, with noise."""
    halves = light + noise * RNG.normal(size=(2, *shape, 3))
    return SimpleNamespace(halves=halves, indirect=halves.mean(0))


WHITE = np.ones((40, 50, 3))


def test_nothing_is_dark_where_the_light_is_right():
    assert dark(np.full((40, 50, 3), 0.5), reference(0.5), WHITE).mean == pytest.approx(0, abs=1e-6)
    assert dark(np.full((40, 50, 3), 0.6), reference(0.5), WHITE).max == 0, "too much is not dark"


def test_half_of_the_light_missing_in_a_tenth_of_the_picture():
    picture = np.full((40, 50, 3), 0.5)
    picture[:4] = 0.25
    found = dark(picture, reference(0.5), WHITE)
    assert (found.mean, found.max) == (pytest.approx(0.05), pytest.approx(0.5))


def test_albedo_cancels():
    albedo = RNG.uniform(0.2, 0.9, (40, 50, 3))
    truth = SimpleNamespace(halves=np.stack([0.5 * albedo] * 2), indirect=0.5 * albedo)
    assert dark(0.25 * albedo, truth, albedo).mean == pytest.approx(0.5)
    assert leak(np.full((40, 50), 0.5 * np.pi), truth, albedo).mean == pytest.approx(1)


def test_noise_of_the_reference_is_not_taken_for_missing_light():
    truth = reference(0.5, noise=0.1)
    assert dark(np.full((40, 50, 3), 0.5), truth, WHITE).mean < 1e-3
    assert dark(np.full((40, 50, 3), 0.1), truth, WHITE).mean > 0.2


def test_black_surfaces_and_black_references_have_answers():
    assert dark(np.zeros((40, 50, 3)), reference(0.0), WHITE).mean == 0
    assert leak(np.ones((40, 50)), reference(0.0), WHITE).max == 0
    black = np.zeros((40, 50, 3))
    assert leak(np.ones((40, 50)), reference(0.5), black).mean == 0


# ---- of a field --------------------------------------------------------------------------------------


def parted():
    """A dark room and a bright sky, a sheet between."""
    scene = load({
        "type": "scene",
        "sky": {"type": "constant", "radiance": rgb(1.0)},
        "room": {"type": "cube", "bsdf": diffuse(0.5, two_sided=True)},
    })  # fmt: skip
    return replace(scene, cameras=(look_at((0.5, 0.3, 0.7), (-1, -0.5, -1), fov=80, size=(24, 18)),))


def test_light_through_a_sheet_is_a_leak():
    """All light in the room comes from probes outside; rays and cells keep it out, without them it leaks."""
    scene = parted()
    box = {"grid_box": ((-2.0, -2.0, -2.0), (2.0, 2.0, 2.0)), "grid_counts": (4, 4, 4), "grid_margin": 0.2}
    blind = small(
        **box, query_visibility=False, query_wrap="off", query_sight="maps", relocation_method="off"
    )
    field = updated(scene, blind, 6)
    assert leaked(scene, field, blind).mean() > 0.3
    sharp = small(**box)
    assert leaked(scene, updated(scene, sharp, 6), sharp).mean() < 1e-3


def test_shares_of_probes_alone_add_up_to_the_irradiance():
    scene, s = parted(), small()
    vol = updated(scene, s, 2).volumes[0]
    points = mi.Point3f(RNG.uniform(-0.9, 0.9, (3, 200)))
    normal = mi.Vector3f(RNG.normal(size=(3, 200)))
    normal = mi.Vector3f(np.array(normal) / np.linalg.norm(np.array(normal), axis=0))
    at = query.Receiver(points, normal, normal, mi.Bool(True), points)
    probes = query.shares(vol, at, s.volume, s.query, scene.tracer)
    lights = query.alone(vol, at, probes, s.volume, s.query)
    total = sum(np.array(share * light) for (_, share), light in zip(probes, lights, strict=True))
    whole = np.array(query.irradiance(vol, at, s.volume, s.query, scene.tracer))
    assert len(probes) == 8
    shares = sum(np.array(share) for _, share in probes)
    seen = shares > 0  # a point in a corner may be seen by no probe at all
    assert seen.mean() > 0.95
    assert np.allclose(shares[seen], 1, atol=1e-4)
    assert np.allclose(total, whole, rtol=1e-4, atol=1e-5)
