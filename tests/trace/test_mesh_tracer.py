"""What rays find: sides, masks and visibility."""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError
from ddgi.sampling import PIXEL_ALPHA, PROBE_ALPHA, clock
from ddgi.trace.surface import offset_origin, slack
from probing import dark_light, diffuse, load, points, rgb, surface_at

N = 1 << 16


def at_height(z, bsdf, half=1.0, **more):
    """A square that looks up."""
    t = mi.ScalarTransform4f().translate([0, 0, z]).scale([half, half, 1])
    return {"type": "rectangle", "to_world": t, "bsdf": bsdf, **more}


def mask(opacity, bsdf=None):
    return {"type": "mask", "opacity": opacity, "nested": bsdf or diffuse(0.5, two_sided=True)}


def scene(**shapes):
    return load({"type": "scene", "dark": dark_light(), **shapes})


def straight(tracer, z, down=True, n=1, tick=0, stream=PIXEL_ALPHA):
    """n equal rays along the z axis."""
    origin = mi.Point3f(dr.full(mi.Float, 0.1, n), 0.2, z)
    return tracer.intersect(
        origin, mi.Vector3f(0, 0, -1 if down else 1) + dr.zeros(mi.Vector3f, n), mi.Bool(True),
        time=clock(0, tick), stream=stream,
    )  # fmt: skip


def clear(tracer, low, high, n=1, down=False):
    origin = mi.Point3f(dr.full(mi.Float, 0.1, n), 0.2, high if down else low)
    return np.array(
        tracer.visible(
            origin, mi.Vector3f(0, 0, -1 if down else 1), mi.Float(high - low), dr.full(mi.Bool, True, n)
        )
    )


def test_front_of_a_single_sided_surface():
    hit = straight(scene(floor=at_height(0.5, diffuse(0.6))).tracer, 3.0)
    assert bool(hit.valid[0]) and not bool(hit.back[0]) and bool(hit.lit[0])
    assert float(hit.distance[0]) == pytest.approx(2.5, rel=1e-5)
    assert np.allclose(np.array(hit.position).ravel(), [0.1, 0.2, 0.5], atol=1e-5)
    assert np.allclose(np.array(hit.normal).ravel(), [0, 0, 1])
    assert np.allclose(np.array(hit.to_viewer).ravel(), [0, 0, 1])
    assert np.allclose(np.array(hit.albedo), 0.6, atol=1e-3)


def test_a_single_sided_surface_is_black_and_opaque_from_behind():
    tracer = scene(floor=at_height(0.5, diffuse(0.6))).tracer
    hit = straight(tracer, -2.0, down=False)
    assert bool(hit.valid[0]) and bool(hit.back[0]) and not bool(hit.lit[0])
    assert np.allclose(np.array(hit.albedo), 0)
    assert float(hit.distance[0]) == pytest.approx(2.5, rel=1e-5)
    assert np.allclose(np.array(hit.normal).ravel(), [0, 0, -1])  # on the ray's side
    assert clear(tracer, -2.0, 3.0) == 0
    assert clear(tracer, -2.0, 3.0, down=True) == 0


def test_both_sides_of_a_double_sided_surface_are_fronts():
    tracer = scene(floor=at_height(0.5, diffuse(0.6, two_sided=True))).tracer
    for z, down in ((3.0, True), (-2.0, False)):
        hit = straight(tracer, z, down)
        assert bool(hit.lit[0])
        assert np.allclose(np.array(hit.albedo), 0.6, atol=1e-3)
        assert np.allclose(np.array(hit.normal).ravel(), [0, 0, 1 if down else -1])


def test_emission_leaves_the_front_alone():
    glow = {"type": "area", "radiance": rgb(4.0)}
    tracer = scene(lamp=at_height(0.5, diffuse(0.6), emitter=glow)).tracer
    assert np.allclose(np.array(straight(tracer, 3.0).emission), 4)
    assert np.allclose(np.array(straight(tracer, -2.0, down=False).emission), 0)


def test_misses_hold_safe_values():
    hit = straight(scene(floor=at_height(0.5, diffuse(0.6))).tracer, 3.0, down=False)
    assert not bool(hit.valid[0]) and not bool(hit.lit[0]) and not bool(hit.back[0])
    assert np.isinf(float(hit.distance[0]))
    for value in (hit.position, hit.normal, hit.albedo, hit.emission, hit.alpha):
        assert np.isfinite(np.array(value)).all()


def test_inactive_lanes_miss():
    tracer = scene(floor=at_height(0.5, diffuse(0.6))).tracer
    for t in (tracer, scene(floor=at_height(0.5, mask(0.5))).tracer):
        hit = t.intersect(
            mi.Point3f(0, 0, 3),
            mi.Vector3f(0, 0, -1),
            mi.Bool([True, False]),
            time=clock(0, 0),
            stream=PIXEL_ALPHA,
        )
        assert not bool(hit.valid[1])
        got = t.visible(mi.Point3f(0, 0, 3), mi.Vector3f(0, 0, 1), mi.Float(9), mi.Bool([True, False]))
        assert np.array(got).tolist() == [1.0, 0.0]


@pytest.mark.parametrize("stream", [PROBE_ALPHA, PIXEL_ALPHA])
def test_a_mask_lets_its_share_of_rays_through(stream):
    """Opacity 0.3: 70 % of rays pass, within 4.5 standard errors of N coin tosses."""
    tracer = scene(card=at_height(0.5, mask(0.3)), floor=at_height(0.0, diffuse(0.6))).tracer
    hit = straight(tracer, 3.0, n=N, stream=stream)
    assert np.array(hit.valid).all()
    distance = np.array(hit.distance, np.float64)
    through = distance > 2.75
    assert np.allclose(distance[through], 3.0, rtol=1e-4)
    assert np.allclose(distance[~through], 2.5, rtol=1e-4)
    assert through.mean() == pytest.approx(0.7, abs=4.5 * np.sqrt(0.21 / N))


@pytest.mark.slow
def test_a_ray_decides_anew_each_tick():
    tracer = scene(card=at_height(0.5, mask(0.3)), floor=at_height(0.0, diffuse(0.6))).tracer
    passed = np.stack([np.array(straight(tracer, 3.0, n=64, tick=t).distance) > 2.75 for t in range(100)])
    # 64 means of 100 coins of 0.7: no ray always passes or never does.
    assert passed.mean(0).min() > 0.4
    assert passed.mean(0).max() < 0.95


def test_layers_are_decided_independently():
    cards = {f"card{i}": at_height(0.2 * (i + 1), mask(0.5)) for i in range(3)}
    hit = straight(scene(**cards, floor=at_height(0.0, diffuse(0.6))).tracer, 3.0, n=N)
    floor = np.array(hit.distance) > 2.9
    assert floor.mean() == pytest.approx(1 / 8, abs=4.5 * np.sqrt(7 / 64 / N))


def test_shadow_rays_carry_exactly_the_share():
    """No noise: transmittance multiplies along the segment."""
    tracer = scene(
        a=at_height(0.5, mask(0.3)), b=at_height(1.0, mask(0.8)), far=at_height(5.0, diffuse(0.5))
    ).tracer
    assert clear(tracer, 0.0, 0.4) == 1
    assert clear(tracer, 0.0, 0.7) == pytest.approx(0.7, abs=1e-6)
    assert clear(tracer, 0.0, 2.0) == pytest.approx(0.7 * 0.2, abs=1e-6)
    assert clear(tracer, 0.0, 2.0, down=True) == pytest.approx(0.7 * 0.2, abs=1e-6)
    assert clear(tracer, 0.0, 6.0) == 0
    assert clear(tracer, 0.0, 2.0, n=5).shape == (5,)
    assert clear(tracer, 5.5, np.inf) == 1


def test_a_closed_mask_is_a_wall_and_an_open_one_is_not_there():
    """An open card lets light pass that Mitsuba's `path` would stop."""
    tracer = scene(
        open=at_height(0.5, mask(0.0)), floor=at_height(0.0, diffuse(0.6)), half=at_height(9.0, mask(0.5))
    ).tracer
    hit = straight(tracer, 3.0, n=256)
    assert np.allclose(np.array(hit.distance), 3.0, rtol=1e-4)
    assert clear(tracer, 0.1, 2.0) == 1
    tracer = scene(shut=at_height(0.5, mask(1.0)), half=at_height(9.0, mask(0.5))).tracer
    assert np.allclose(np.array(straight(tracer, 3.0, n=256).distance), 2.5, rtol=1e-4)
    assert clear(tracer, 0.1, 2.0) == 0


def test_masks_from_behind_are_still_masks():
    """A single-sided card is black from behind, but no more opaque than from the front."""
    tracer = scene(card=at_height(0.5, mask(0.3, diffuse(0.5)))).tracer
    hit = straight(tracer, -2.0, down=False, n=N)
    assert np.array(hit.valid).mean() == pytest.approx(0.3, abs=4.5 * np.sqrt(0.21 / N))
    assert clear(tracer, 0.0, 2.0) == pytest.approx(0.7, abs=1e-6)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_offset_origins_leave_their_surface(scale):
    rng = np.random.default_rng(0)
    p = rng.uniform(-scale, scale, (1000, 3))
    n = rng.normal(size=(1000, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    d = rng.normal(size=(1000, 3))
    surface = replace(surface_at(p, n), slack=slack(points(p), mi.Float(scale)))
    moved = np.array(offset_origin(surface, mi.Vector3f(points(d))), np.float64).T
    along = ((moved - p) * n).sum(1)
    assert (np.sign(along) == np.sign((n * d).sum(1))).all()
    assert (np.abs(along) < 1e-3 * scale).all()


def leaning(turn, bsdf=None, two_sided=True):
    """A wall that looks up, whose normal map leans by 45 degrees to +u."""
    lean = np.full((2, 2, 3), (0.5 + 0.5 * np.sqrt(0.5), 0.5, 0.5 + 0.5 * np.sqrt(0.5)), np.float32)
    texture = {"type": "bitmap", "bitmap": mi.Bitmap(lean), "raw": True}
    bumpy = {"type": "normalmap", "normalmap": texture, "nested": bsdf or diffuse(0.5)}
    t = mi.ScalarTransform4f().rotate([0, 0, 1], turn).scale([2, 2, 1])
    bsdf = {"type": "twosided", "nested": bumpy} if two_sided else bumpy
    return {"type": "rectangle", "to_world": t, "bsdf": bsdf}


@pytest.mark.parametrize("turn", [0, 90])
@pytest.mark.parametrize("down", [True, False])
def test_normal_maps_lean_along_the_coordinates(turn, down):
    """Towards +u on both sides, and towards the viewer."""
    tracer = scene(wall=leaning(turn)).tracer
    origin, way = mi.Point3f(0.1, 0.2, 3 if down else -3), mi.Vector3f(0, 0, -1 if down else 1)
    seen = [
        tracer.intersect(origin, way, mi.Bool(True), time=clock(0, 0), stream=PIXEL_ALPHA, bumps=bumps)
        for bumps in (True, False)
    ]
    side, root = 1 if down else -1, np.sqrt(0.5)
    along = (root, 0) if turn == 0 else (0, root)
    np.testing.assert_allclose(np.ravel(seen[0].normal), [*along, side * root], atol=2e-3)
    np.testing.assert_allclose(np.ravel(seen[0].geometric_normal), [0, 0, side], atol=1e-6)
    np.testing.assert_allclose(np.ravel(seen[1].normal), [0, 0, side], atol=1e-6)


def test_what_has_no_normal_map_stays_smooth_beside_one():
    tracer = scene(wall=leaning(0), floor=at_height(1.0, diffuse(0.5), half=0.5)).tracer
    hit = tracer.intersect(
        mi.Point3f(0.1, 0.2, 3), mi.Vector3f(0, 0, -1), mi.Bool(True),
        time=clock(0, 0), stream=PIXEL_ALPHA, bumps=True,
    )  # fmt: skip
    np.testing.assert_allclose(np.ravel(hit.normal), [0, 0, 1], atol=1e-6)


def channel(*values):
    """A picture of one row, without a filter."""
    texels = np.array(values, np.float32).reshape(1, -1, 1)
    return {"type": "bitmap", "bitmap": mi.Bitmap(texels), "raw": True, "filter_type": "nearest"}


@pytest.mark.parametrize(
    "parameters, metallic, alpha",
    [
        ({"metallic": channel(0, 1), "roughness": channel(0.2, 0.8)}, (0, 1), (0.04, 0.64)),
        ({"metallic": channel(0, 1), "roughness": 0.5}, (0, 1), (0.25, 0.25)),
        ({"metallic": 0.3, "roughness": channel(0.2, 0.8)}, (0.3, 0.3), (0.04, 0.64)),
        ({"metallic": channel(0, 1), "roughness": channel(0.2, 0.4, 0.6, 0.8)}, (0, 1), (0.16, 0.36)),
    ],
)
def test_pictures_of_metallic_and_roughness(parameters, metallic, alpha):
    """Each half of the wall has its own; of four texels those on either side of the middle are met."""
    white = {"type": "principled", "base_color": rgb(0.5, 0.5, 0.5), **parameters}
    tracer = scene(wall=at_height(0, white)).tracer
    hit = tracer.intersect(
        mi.Point3f([-0.2, 0.2], 0.1, 3), mi.Vector3f(0, 0, -1), mi.Bool(True), time=clock(0, 0), stream=PIXEL_ALPHA
    )  # fmt: skip
    np.testing.assert_allclose(np.array(hit.metallic) + np.zeros(2), metallic, atol=1e-3)
    np.testing.assert_allclose(np.array(hit.alpha) + np.zeros(2), alpha, atol=1e-3)


def test_pictures_that_lie_differently_are_not_mixed_up():
    turned = {**channel(0.0, 1.0), "to_uv": mi.ScalarTransform4f().rotate([0, 0, 1], 90)}
    found = scene(
        wall=at_height(0, {"type": "principled", "metallic": turned, "roughness": channel(0.2, 0.8)})
    )
    assert any("mean of metallic" in note for note in found.notes)
    hit = straight(found.tracer, 3.0)
    np.testing.assert_allclose(np.ravel(hit.metallic), 0.5, atol=1e-3)


def test_normal_maps_may_hold_negative_values():
    """Steep slopes, as pictures in floating point keep them; what is not a number is refused."""
    texels = np.full((2, 2, 3), (1.5, -0.5, 1.0), np.float32)

    def wall(values):
        texture = {"type": "bitmap", "bitmap": mi.Bitmap(values), "raw": True}
        return at_height(0, {"type": "normalmap", "normalmap": texture, "nested": diffuse(0.5)})

    hit = scene(wall=wall(texels)).tracer.intersect(
        mi.Point3f(0.1, 0.2, 3), mi.Vector3f(0, 0, -1), mi.Bool(True),
        time=clock(0, 0), stream=PIXEL_ALPHA, bumps=True,
    )  # fmt: skip
    np.testing.assert_allclose(np.ravel(hit.normal), [2 / 3, -2 / 3, 1 / 3], atol=1e-3)
    with pytest.raises(SceneError, match="not finite"):
        scene(wall=wall(np.full((2, 2, 3), np.nan, np.float32)))
