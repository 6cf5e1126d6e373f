"""Blending against a plain double loop, and sequences known on paper."""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SettingsError
from ddgi.probes import volume
from ddgi.probes.blend import blend, hysteresis
from ddgi.probes.directions import frame_directions
from ddgi.probes.field import IrradianceField, distance_map, irradiance_map
from ddgi.probes.gather import Gathered
from ddgi.probes.haste import Haste
from ddgi.probes.octahedral import texel_directions
from ddgi.sampling import clock
from probing import changed, floats, lattice, points, small, sphere_points

RAYS, SIZE = 40, 5


def settings(**values):
    base = {
        "volume_irradiance_size": SIZE,
        "volume_distance_size": SIZE,
        "rays_per_probe": RAYS,
        "blend_gamma": 1.0,
        "blend_fit_texels": False,
    }
    return small(**(base | values))


def empty(s, counts=(2, 2, 2)):
    return volume.allocate(lattice(counts), s.volume, RAYS, 1000.0)


def found(radiance, distance, directions):
    """What rays brought back. radiance: (R, P, 3); distance: (R, P); directions: (R, 3)."""
    return Gathered(
        mi.Vector3f(points(directions)),
        mi.Color3f(points(np.asarray(radiance).reshape(-1, 3))),
        floats(np.asarray(distance).ravel()),
        dr.opaque(mi.UInt32, 0),
    )


def even(value, probes=8, distance=0.5):
    """The same light from everywhere."""
    directions = np.array(frame_directions(RAYS, clock(0, 0)), np.float64).T
    return found(np.full((RAYS, probes, 3), value), np.full((RAYS, probes), distance), directions)


def step(vol, seen, s, tick=0):
    return blend(vol, seen, None, clock(0, tick), s.volume, s.blend, s.query)


def s_map(vol, s):
    """(P, n, n, 3) mean radiance."""
    return irradiance_map(IrradianceField([vol], mi.UInt32(0)), s) / np.pi


def d_map(vol, s):
    """(P, n, n, 2) in reach units."""
    reach = float(vol.reach(s.volume)[0])
    return distance_map(IrradianceField([vol], mi.UInt32(0)), s) / np.array([reach, reach**2])


def random_rays(seed=0, probes=8):
    rng = np.random.default_rng(seed)
    radiance = rng.uniform(0, 4, (RAYS, probes, 3))
    distance = rng.uniform(0.05, 1.6, (RAYS, probes))
    distance[rng.uniform(size=distance.shape) < 0.15] = np.inf
    return radiance, distance, sphere_points(RAYS, seed + 10)


def texels():
    return np.array(texel_directions(SIZE), np.float64).T


# float32 products of 40 terms, each within 1e-7.
CLOSE = 2e-5


def test_irradiance_is_the_cosine_weighted_mean():
    s = settings()
    radiance, distance, directions = random_rays()
    got = s_map(step(empty(s), found(radiance, distance, directions), s), s).reshape(8, -1, 3)
    for probe in range(8):
        for t, texel in enumerate(texels()):
            total, weights = np.zeros(3), 0.0
            for r, direction in enumerate(directions):
                w = max(0.0, texel @ direction)
                total, weights = total + w * radiance[r, probe], weights + w
            assert np.allclose(got[probe, t], total / weights, rtol=CLOSE)


@pytest.mark.parametrize("sharpness", [1.0, 8.0, 50.0])
@pytest.mark.parametrize("mode", ["clamp", "reject", "off"])
def test_distance_is_the_power_cosine_weighted_mean(mode, sharpness):
    s = settings(blend_long_distances=mode, blend_sharpness=sharpness)
    radiance, distance, directions = random_rays(1)
    got = d_map(step(empty(s), found(radiance, distance, directions), s), s).reshape(8, -1, 2)
    seen = 0
    for probe in range(8):
        for t, texel in enumerate(texels()):
            total, weights = np.zeros(2), 0.0
            for r, direction in enumerate(directions):
                w, x = max(0.0, texel @ direction) ** sharpness, distance[r, probe]
                if mode == "clamp":
                    x = min(x, 1.0)
                elif mode == "off":
                    x = x if np.isfinite(x) else 1.0
                elif x > 1:
                    continue
                total, weights = total + w * np.array([x, x * x]), weights + w
            if weights > 1e-5:  # far above where a texel counts as unseen
                seen += 1
                assert np.allclose(got[probe, t], total / weights, rtol=20 * CLOSE)
    assert seen > 100


def test_border_repeats_the_interior():
    """Reading the whole stored map: the border of each edge is the edge's mirror image."""
    s = settings()
    vol = step(empty(s), found(*random_rays(2)), s)
    wide = np.array(vol.irradiance).reshape(8, SIZE + 2, SIZE + 2, 4)[..., :3]
    assert np.array_equal(wide[:, 0, 1:-1], wide[:, 1, 1:-1][:, ::-1])
    assert np.array_equal(wide[:, -1, 1:-1], wide[:, -2, 1:-1][:, ::-1])
    assert np.array_equal(wide[:, 1:-1, 0], wide[:, 1:-1, 1][:, ::-1])
    assert np.array_equal(wide[:, 1:-1, -1], wide[:, 1:-1, -2][:, ::-1])
    assert np.array_equal(wide[:, 0, 0], wide[:, -2, -2])
    assert np.array_equal(wide[:, 0, -1], wide[:, -2, 1])


def sequence(count, **values):
    s = settings(**values)
    return [float(hysteresis(mi.UInt32(age), s.blend)[0]) for age in range(count)]


def test_hysteresis_warms_up():
    """Nothing old for 16 updates, then a running mean until 0.97 takes over."""
    expected = [0.0] * 16 + [min(n / (n + 3), 0.97) for n in range(1, 105)]
    assert np.allclose(sequence(120), expected, atol=1e-6)
    assert sequence(120)[-1] == pytest.approx(0.97)


def test_recency_of_one_is_a_plain_mean():
    expected = [0.0] * 4 + [(n - 1) / n for n in range(2, 12)]
    assert np.allclose(sequence(14, blend_warm_up=4, blend_recency=1.0), expected, atol=1e-6)


@pytest.mark.parametrize("recency", [2.0, 3.0])
def test_recency_makes_late_updates_count_more(recency):
    """Of 40 updates, the weight of the n-th goes as the (recency - 1)th power of n."""
    keep = np.array(sequence(40, blend_warm_up=1, blend_recency=recency, blend_hysteresis=0.9999))
    weight = (1 - keep) * np.append(np.cumprod(keep[:0:-1])[::-1], 1)
    n = np.arange(1, 41)
    assert weight.sum() == pytest.approx(1)
    assert np.allclose(weight[9:] / weight[-1], (n[9:] / 40) ** (recency - 1), atol=0.1)


@pytest.mark.parametrize(
    ("before", "after", "kept"),
    [
        (1.0, 1.2, 0.9), (1.0, 0.8, 0.9),  # a fifth: nothing changes
        (1.0, 1.5, 0.75), (1.0, 0.5, 0.75),  # a third, a half: 0.15 less, up as down
        (1.0, 6.0, 0.0), (1.0, 0.1, 0.0),  # five sixths, nine tenths: nothing is kept
        (1e-3, 2e-3, 0.75),  # of themselves, not of one
        (0.0, 1.0, 0.0), (0.0, 0.0, 0.9),
    ],
)  # fmt: skip
def test_texels_that_change_much_forget(before, after, kept):
    """SCALE 4.3, with its listing's mistakes mended."""
    s = settings(blend_warm_up=0, blend_hysteresis=0.9, blend_thresholds=True, blend_gamma=1.0)
    _, distance, directions = random_rays()
    even = lambda x: np.full((RAYS, 8, 3), x)  # noqa: E731
    vol = step(empty(s), found(even(before), distance, directions), s)
    got = s_map(step(vol, found(even(after), distance, directions), s), s)
    assert np.allclose(got, kept * before + (1 - kept) * after, rtol=1e-4)


def test_one_channel_that_changes_is_enough():
    s = settings(blend_warm_up=0, blend_hysteresis=0.9, blend_thresholds=True, blend_gamma=1.0)
    _, distance, directions = random_rays()
    even = lambda *rgb: np.broadcast_to(rgb, (RAYS, 8, 3))  # noqa: E731
    vol = step(empty(s), found(even(1.0, 1.0, 1.0), distance, directions), s)
    got = s_map(step(vol, found(even(0.6, 1.0, 1.0), distance, directions), s), s)
    assert np.allclose(got[..., 0], 0.75 + 0.25 * 0.6, rtol=1e-4)


@pytest.mark.parametrize(
    ("event", "light", "distance"),
    [("small light", [0.85] * 4 + [1] * 8, [1] * 12), ("large light", [0.5] * 10 + [1] * 2, [1] * 12),
     ("large object", [0.5] * 10 + [1] * 2, [0.5] * 7 + [1] * 5)],
)  # fmt: skip
def test_after_an_event_less_is_kept_for_a_while(event, light, distance):
    """By what share of the way each update goes from 1 towards 2, for irradiance and for distances."""
    s = settings(blend_warm_up=0, blend_hysteresis=0.8, blend_gamma=1.0)
    _, _, directions = random_rays()
    even = lambda x: (np.full((RAYS, 8, 3), x), np.full((RAYS, 8), 0.2 * x), directions)  # noqa: E731
    vol = step(empty(s), found(*even(1.0)), s)
    vol = replace(vol, haste=vol.haste.after(event))
    at, far = 1.0, 0.2
    for cut, cut_distance in zip(light, distance, strict=True):
        vol = step(vol, found(*even(2.0)), s)
        now, there = float(s_map(vol, s)[0, 0, 0, 0]), float(d_map(vol, s)[0, 0, 0, 0])
        assert (2 - now) / (2 - at) == pytest.approx(0.8 * cut, abs=2e-3)
        assert (0.4 - there) / (0.4 - far) == pytest.approx(0.8 * cut_distance, abs=2e-3)
        at, far = now, there


def test_events_that_overlap_and_those_that_there_are_not():
    small_one = Haste.none().after("small light").passing()
    both = small_one.after("large light").passing()
    assert (float(both.light_cut[0]), int(both.light_left[0])) == (0.5, 9)
    again = both.after("small light")
    assert (float(again.light_cut[0]), int(again.light_left[0])) == (0.5, 9)
    with pytest.raises(SettingsError, match="no scene event 'flood': there are small light"):
        Haste.none().after("flood")


def test_hysteresis_without_warm_up():
    assert np.allclose(sequence(5, blend_warm_up=0, blend_hysteresis=0.9), [0, 0.9, 0.9, 0.9, 0.9])


def test_no_hysteresis_keeps_nothing():
    assert sequence(20, blend_hysteresis=0.0) == [0.0] * 20


def test_hysteresis_at_great_age():
    s = settings()
    for age in (1_000_000, 2**31 - 1):
        assert float(hysteresis(mi.UInt32(age), s.blend)[0]) == pytest.approx(0.97)


def test_warm_up_then_running_mean():
    """Updates worth 1, 2, 3, ...: the map shows the last one, then the mean since the warm-up's end."""
    s = settings(blend_warm_up=3, blend_recency=1.0)
    vol = empty(s)
    shown = []
    for n in range(1, 8):
        vol = step(vol, even(float(n)), s)
        shown.append(s_map(vol, s).mean())
    assert np.allclose(shown, [1, 2, 3, (3 + 4) / 2, (3 + 4 + 5) / 3, 18 / 4, 25 / 5], rtol=1e-5)


def test_alpha_is_the_share_of_the_old_value():
    s = settings(blend_warm_up=0, blend_hysteresis=0.8)
    vol = step(step(empty(s), even(10.0, distance=0.2), s), even(0.0, distance=0.7), s, 1)
    assert np.allclose(s_map(vol, s), 8.0, rtol=1e-5)
    assert np.allclose(d_map(vol, s)[..., 0], 0.8 * 0.2 + 0.2 * 0.7, rtol=1e-4)
    assert np.allclose(d_map(vol, s)[..., 1], 0.8 * 0.04 + 0.2 * 0.49, rtol=1e-4)


@pytest.mark.parametrize("root", [True, False])
@pytest.mark.parametrize("gamma", [1.0, 2.0, 2.5, 5.0])
def test_blend_in_encoded_space(gamma, root):
    """(alpha old^(1/gamma) + (1 - alpha) new^(1/gamma))^gamma, whatever the map holds."""
    s = settings(blend_warm_up=0, blend_hysteresis=0.75, blend_gamma=gamma, query_sqrt_blending=root)
    vol = step(step(empty(s), even(4.0), s), even(0.25), s, 1)
    expected = (0.75 * 4.0 ** (1 / gamma) + 0.25 * 0.25 ** (1 / gamma)) ** gamma
    assert np.allclose(s_map(vol, s), expected, rtol=5e-5)


@pytest.mark.parametrize("gamma", [1.0, 5.0])
def test_a_step_of_light_decays_geometrically(gamma):
    s = settings(blend_warm_up=0, blend_hysteresis=0.9, blend_gamma=gamma)
    vol = step(empty(s), even(1.0), s)
    for k in range(1, 8):
        vol = step(vol, even(0.0), s, k)
        assert np.allclose(s_map(vol, s), 0.9 ** (k * gamma), rtol=1e-4)


def towards_one_side(s, value=0.3):
    """All distances that count lie around +z; the texels around -z see none."""
    directions = sphere_points(RAYS, 3)
    directions[:, 2] = np.abs(directions[:, 2]) + 1.0
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return found(np.ones((RAYS, 8, 3)), np.full((RAYS, 8), value), directions)


def test_texels_without_samples_hold_the_reach_at_first():
    s = settings()
    got = d_map(step(empty(s), towards_one_side(s), s), s).reshape(8, -1, 2)
    away = texels()[:, 2] < -0.5
    assert np.allclose(got[:, away], 1.0, rtol=1e-6)
    assert np.allclose(got[:, texels()[:, 2] > 0.7], [0.3, 0.09], rtol=1e-3)


def test_texels_without_samples_keep_the_old_value():
    s = settings(blend_warm_up=0, blend_hysteresis=0.5)
    vol = step(empty(s), even(1.0, distance=0.6), s)
    got = d_map(step(vol, towards_one_side(s), s, 1), s).reshape(8, -1, 2)
    away = texels()[:, 2] < -0.5
    assert np.allclose(got[:, away], [0.6, 0.36], rtol=1e-3)
    assert np.allclose(got[:, texels()[:, 2] > 0.7, 0], 0.45, rtol=1e-3)


def test_rejecting_everything_leaves_the_reach():
    s = settings(blend_long_distances="reject")
    assert np.allclose(d_map(step(empty(s), even(1.0, distance=3.0), s), s), 1.0)
    vol = step(step(empty(s), even(1.0, distance=0.4), s), even(1.0, distance=3.0), s, 1)
    assert np.allclose(d_map(vol, s)[..., 0], 0.4, rtol=1e-4)


def test_kept_long_distances_keep_their_length():
    s = settings(blend_long_distances="off")
    assert np.allclose(d_map(step(empty(s), even(1.0, distance=3.0), s), s), [3.0, 9.0], rtol=1e-4)
    assert np.allclose(d_map(step(empty(s), even(1.0, distance=np.inf), s), s), 1.0)


def test_age_counts_updates_and_reset_clears_it():
    s = settings()
    vol = step(step(empty(s), even(1.0), s), even(1.0), s)
    assert int(vol.age[0]) == 2
    again = IrradianceField([vol], mi.UInt32(0)).reset()
    assert int(again.volumes[0].age[0]) == 0
    assert np.allclose(s_map(again.volumes[0], s), 1, rtol=1e-5)  # old light stays visible


@pytest.mark.parametrize("name", ["float16", "rgbe8", "r11g11b10"])
def test_small_formats_do_not_stall(name):
    """0.97 old and 0.03 new must arrive, though each step is below a unit of the format."""
    s = settings(volume_irradiance_format=name, blend_warm_up=0, query_sqrt_blending=False)
    vol, seen = step(empty(s), even(1.9), s), even(2.1)
    again = dr.freeze(lambda vol, seen, time: blend(vol, seen, None, time, s.volume, s.blend, s.query))
    for tick in range(1, 250):
        vol = again(vol, seen, clock(0, tick))
    # 0.97^249 of the way is left, 0.05 %; over 8 * 25 texels the dither's mean is within
    # a step (1/64, blue 1/32) * 3 (memory of 33 updates, sqrt(33/2)/...) / sqrt(200).
    worst = {"float16": 2e-3, "rgbe8": 4e-3, "r11g11b10": 8e-3}[name]
    assert np.abs(s_map(vol, s).mean((0, 1, 2)) / 2.1 - 1).max() <= worst


def test_blend_gives_a_new_volume():
    s = settings()
    old = empty(s)
    new = step(old, even(1.0), s)
    assert np.array(old.irradiance).max() == 0
    assert new is not old
    assert changed(s, blend_gamma=2.0).blend.gamma == 2.0
