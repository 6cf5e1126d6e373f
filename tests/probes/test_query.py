"""The query against answers known on paper, and against the papers' formulas in NumPy."""

import itertools

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.probes import query
from ddgi.settings import RenderSettings
from probing import floats, hand_made, lattice, query_at, receiver, small, sphere_points, with_gutter

PLAIN = {
    "query_trilinear": True, "query_wrap": "off", "query_visibility": False, "query_crush": 0.0,
    "query_bias": "off", "query_sqrt_blending": False,
}  # fmt: skip
CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))[:, ::-1]  # in the order of probe numbers
# float32, eight probes: roundings of 1e-7 each.
CLOSE = 2e-5


def plain(**values):
    """Only the trilinear weight, and then what is asked for."""
    return small(**(PLAIN | values))


def one_cell(radiance, s, moments=None, spacing=(1.0, 1.0, 1.0)):
    """A cell with corners at 0 and `spacing`; each probe has one radiance in all directions."""
    radiance = np.repeat(np.asarray(radiance, np.float64)[:, None], 3, 1)
    return hand_made(lattice((2, 2, 2), spacing=spacing), s, radiance, moments)


def share_of(probe, s, position=(0.5, 0.5, 0.5), normal=(0, 0, 1), moments=None):
    """Share of one probe in the result."""
    vol = one_cell(np.arange(8) == probe, s, moments)
    return query_at(vol, s, position, normal)[0, 0] / np.pi


def unit(*v):
    return np.array(v, float) / np.linalg.norm(v)


# ---- a constant field --------------------------------------------------------------------------------

# Relative error that the stored bits allow: one step; twice that where the root is stored.
FORMATS = {"float32": 1e-3, "float16": 5e-3, "rgbe8": 2 / 128, "r11g11b10": 2 / 32}
SWITCHES = [
    {},
    PLAIN,
    {"query_trilinear": False},
    {"query_visibility": False},
    {"query_sqrt_blending": False},
    {"query_crush": 0.0, "query_visibility_floor": 0.0},
    {"query_crush": 1.0},
    *({"query_wrap": w} for w in ("half_cosine", "wrap", "sharp", "off")),
    *({"query_bias": b} for b in ("scale", "ctu", "mff", "off")),
    {"query_wrap": "sharp", "query_crush": 0.2, "query_visibility_floor": 0.0},
]
PRESETS = ["default", "scale", "blog", "ctu", "mff", "classic"]


def anywhere(count=400, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(-1.5, 3.5, (count, 3)), sphere_points(count, seed + 1), sphere_points(count, seed + 2)


def any_moments(probes, size=8, seed=3):
    """Distance maps without rhyme or reason, but possible: mean square at least the square of the mean."""
    rng = np.random.default_rng(seed)
    mean = rng.uniform(0, 1, (probes, size, size))
    return np.stack([mean, mean**2 + rng.uniform(0, 0.1, mean.shape)], -1)


@pytest.mark.parametrize("values", SWITCHES, ids=str)
def test_a_constant_field_is_reproduced(values):
    """Every weight on or off: a weighted mean of equal values is that value, E = pi L."""
    s = small(**values)
    vol = hand_made(lattice((3, 3, 3)), s, np.tile([2.0, 0.5, 0.03], (27, 1)), any_moments(27))
    e = query_at(vol, s, *anywhere())
    assert np.allclose(e, np.pi * np.array([2.0, 0.5, 0.03]), rtol=1e-3 / 10)


@pytest.mark.parametrize("root", [True, False])
@pytest.mark.parametrize("name", FORMATS)
def test_a_constant_field_in_each_format(name, root):
    s = small(volume_irradiance_format=name, query_sqrt_blending=root)
    for radiance in (0.011, 0.3, 1.0, 7.7):
        vol = hand_made(lattice((3, 3, 3)), s, np.full((27, 3), radiance))
        e = query_at(vol, s, *anywhere(50))
        assert np.allclose(e / (np.pi * radiance), 1, atol=FORMATS[name])


@pytest.mark.parametrize("name", ["float32", "float16", "unorm8"])
def test_a_constant_field_in_each_distance_format(name):
    s = small(volume_distance_format=name)
    vol = hand_made(lattice((3, 3, 3)), s, np.ones((27, 3)), any_moments(27))
    assert np.allclose(query_at(vol, s, *anywhere(50)), np.pi, rtol=1e-4)


@pytest.mark.parametrize("taps", [False, True])
def test_special_places_give_numbers(taps):
    """Exactly at a probe, on cell faces, on the volume's boundary, and far away."""
    places = np.array(
        [
            (0, 0, 0),
            (1, 1, 1),
            (2, 2, 2),
            (0.5, 1, 1),
            (1, 0.5, 0),
            (-9, 3, 3),
            (1e6, -1e6, 5),
            (1e12, 0, 0),
            (-1e12,) * 3,
        ],
        float,
    )
    normals = [*np.eye(3), *-np.eye(3), unit(1, 1, 1)]
    all_places, all_normals = np.repeat(places, len(normals), 0), np.tile(normals, (len(places), 1))
    for name in PRESETS:
        s = RenderSettings.preset(name)
        # Walls exactly at the probe, nothing in sight, a distance without variance, anything.
        kinds = [np.zeros(2), np.ones(2), np.array([0.5, 0.25])]
        moments = [np.tile(k, (27, 1)) for k in kinds] + [any_moments(27, s.volume.distance_size)]
        for moment in moments:
            vol = hand_made(lattice((3, 3, 3)), s, np.ones((27, 3)), moment)
            tap = mi.Point2f(0.3, 0.6) if taps else None
            e = query_at(vol, s, all_places, all_normals, tap=tap)
            assert np.isfinite(e).all()
            assert np.allclose(e, np.pi, rtol=2 * 2**-5 if name == "blog" else 2e-3)


def test_inactive_lanes_give_nothing():
    s = small()
    vol = hand_made(lattice((3, 3, 3)), s, np.ones((27, 3)))
    at = receiver(*anywhere(4), [True, False, True, False])
    e = query.irradiance(vol, at, s.volume, s.query)
    assert np.allclose(np.array(e)[:, [1, 3]], 0)
    assert np.allclose(np.array(e)[:, [0, 2]], np.pi, rtol=1e-4)


# ---- trilinear ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("counts", [(2, 2, 2), (4, 3, 5)])
def test_linear_fields_are_reproduced(counts):
    s = plain()
    layout = lattice(counts, origin=(1.0, -2.0, 0.5), spacing=(0.5, 2.0, 0.25))
    at = np.array(layout.position(dr.arange(mi.UInt32, layout.size)), np.float64).T
    plane = lambda p: 9.0 + p @ np.array([[1.0, 0.0, 0.3], [0.0, 0.5, -0.2], [0.0, 0.0, 2.0]])  # noqa: E731
    vol = hand_made(layout, s, plane(at))
    inside = np.random.default_rng(1).uniform(at.min(0), at.max(0), (500, 3))
    assert np.allclose(query_at(vol, s, inside, sphere_points(500)), np.pi * plane(inside), rtol=CLOSE)
    beyond = at.min(0) + np.random.default_rng(2).uniform(-2, 3, (200, 3)) * np.ptp(at, axis=0)
    nearest = np.clip(beyond, at.min(0), at.max(0))
    assert np.allclose(query_at(vol, s, beyond, (0, 0, 1)), np.pi * plane(nearest), rtol=CLOSE)


def test_square_root_blending_averages_roots():
    """SCALE listing 2: half way between probes of 4 and 16 lies ((2 + 4) / 2)^2 = 9, not 10."""
    values = np.where(CORNERS[:, 0] == 0, 4.0, 16.0)
    for root, expected in ((True, 9.0), (False, 10.0)):
        s = plain(query_sqrt_blending=root)
        assert query_at(one_cell(values, s), s, (0.5, 0.2, 0.7), (0, 1, 0))[0, 0] == pytest.approx(
            np.pi * expected, rel=1e-5
        )


def test_without_trilinear_all_eight_count_alike():
    s = plain(query_trilinear=False)
    for probe in range(8):
        assert share_of(probe, s, (0.1, 0.9, 0.3)) == pytest.approx(1 / 8, rel=1e-5)


# ---- wrap --------------------------------------------------------------------------------------------
# At the middle of a cube, with the normal towards one corner, the eight probes lie at cosines
# 1, 1/3 (three times), -1/3 (three times) and -1.

DIAGONAL = unit(1, 1, 1)
SEEN_AT = {7: 1.0, 6: 1 / 3, 1: -1 / 3, 0: -1.0}
WRAPS = {
    "half_cosine, 2019": (
        {"query_wrap": "half_cosine", "query_wrap_offset": 0.2},
        lambda c: ((c + 1) / 2) ** 2 + 0.2,
    ),
    "half_cosine, MFF 3.3": (
        {"query_wrap": "half_cosine", "query_wrap_offset": 0.0},
        lambda c: ((c + 1) / 2) ** 2,
    ),
    "wrap, CTU 4.4, a = 1": ({"query_wrap": "wrap", "query_wrap_a": 1.0}, lambda c: ((c + 1) / 2) ** 2),
    "wrap, CTU 4.4, a = 1/2": (
        {"query_wrap": "wrap", "query_wrap_a": 0.5},
        lambda c: (max(c + 0.5, 0) / 1.5) ** 1.5,
    ),
    "wrap, CTU 4.4, a = 0": ({"query_wrap": "wrap", "query_wrap_a": 0.0}, lambda c: max(c, 0)),
    "sharp, MFF 3.1": ({"query_wrap": "sharp"}, lambda c: max(c, 0)),
    "off": ({"query_wrap": "off"}, lambda c: 1.0),
}


@pytest.mark.parametrize("name", WRAPS)
def test_wrap_along_the_diagonal(name):
    values, weight = WRAPS[name]
    s = plain(query_trilinear=False, **values)
    total = weight(1.0) + 3 * weight(1 / 3) + 3 * weight(-1 / 3) + weight(-1.0)
    for probe, cosine in SEEN_AT.items():
        assert share_of(probe, s, normal=DIAGONAL) == pytest.approx(weight(cosine) / total, abs=1e-5)


@pytest.mark.parametrize("name", WRAPS)
def test_wrap_at_the_horizon(name):
    """Normal (1, -1, 0): four probes at cosine 0, two at each of +-2/sqrt(6)."""
    values, weight = WRAPS[name]
    s = plain(query_trilinear=False, **values)
    total = 4 * weight(0.0) + 2 * weight(2 / np.sqrt(6)) + 2 * weight(-2 / np.sqrt(6))
    assert share_of(7, s, normal=unit(1, -1, 0)) == pytest.approx(weight(0.0) / total, abs=1e-5)


def test_half_cosine_share_on_paper():
    """1 / (1 + 3 * 4/9 + 3 * 1/9) = 3/8 for the probe straight ahead."""
    s = plain(query_trilinear=False, query_wrap="half_cosine", query_wrap_offset=0.0)
    assert share_of(7, s, normal=DIAGONAL) == pytest.approx(3 / 8, rel=1e-4)
    assert share_of(0, s, normal=DIAGONAL) == pytest.approx(0, abs=1e-5)


# ---- visibility --------------------------------------------------------------------------------------
# At the middle of a unit cube all probes are sqrt(3)/2 away: 1/3 of the reach, 1.5 sqrt(3). The four
# probes at x = 1 hold the moments of a wall, the others see everything; so with weight w of a hidden
# probe, and radiance 1 behind the wall and 0 before it, E / pi = w / (1 + w).

R = 1 / 3
BEHIND = CORNERS[:, 0] == 1


def hidden_weight(moments, **values):
    s = plain(query_visibility=True, query_trilinear=False, query_visibility_floor=0.0, **values)
    seen = np.where(BEHIND[:, None], np.array(moments, float), 1.0)
    share = query_at(one_cell(BEHIND.astype(float), s, seen), s, (0.5, 0.5, 0.5), (0, 0, 1))[0, 0] / np.pi
    return share / (1 - share)


@pytest.mark.parametrize("exponent", [1.0, 2.5, 3.0])
@pytest.mark.parametrize(("mean", "variance"), [(0.2, 0.02), (0.1, 0.001), (0.3, 0.0005)])
def test_chebyshev_by_hand(mean, variance, exponent):
    expected = (variance / (variance + (R - mean) ** 2)) ** exponent
    got = hidden_weight((mean, mean**2 + variance), query_chebyshev_exponent=exponent)
    # The moments' difference loses digits: 1e-7 of mean^2 against the variance.
    assert got == pytest.approx(expected, rel=1e-3)


def test_chebyshev_is_one_up_to_the_mean():
    assert hidden_weight((0.34, 0.34**2 + 1e-4)) == pytest.approx(1, rel=1e-5)


def test_visibility_floor():
    s = plain(query_visibility=True, query_trilinear=False, query_visibility_floor=0.25)
    seen = np.where(BEHIND[:, None], [0.05, 0.0025], 1.0)
    share = query_at(one_cell(BEHIND.astype(float), s, seen), s, (0.5, 0.5, 0.5), (0, 0, 1))[0, 0] / np.pi
    assert share == pytest.approx(0.25 / 1.25, rel=1e-4)


@pytest.mark.parametrize("preset", ["default", "scale", "ctu", "mff"])
def test_a_probe_behind_a_wall_hardly_counts(preset):
    """A wall half way to the probes at x = 1: what they see must stay there."""
    s = RenderSettings.preset(preset)
    # Seen from them the wall is 0.1 of the reach away; the sample lies at a third.
    seen = np.where(BEHIND[:, None], [0.1, 0.0101], 1.0)
    vol = one_cell(BEHIND.astype(float), s, seen)
    e = query_at(vol, s, (0.5, 0.5, 0.5), (-1, 0, 0), viewer=(-1, 0, 0))[0, 0] / np.pi
    assert e < 0.01
    behind = query_at(vol, s, (0.5, 0.5, 0.5), (-1, 0, 0), viewer=(-1, 0, 0))
    assert np.isfinite(behind).all()


def test_all_hidden_is_still_a_mean():
    s = small(query_visibility_floor=0.0)
    vol = one_cell(np.full(8, 3.0), s, np.tile([0.01, 0.0001], (8, 1)))
    assert query_at(vol, s, (0.4, 0.6, 0.5), (0, 0, 1))[0, 0] == pytest.approx(3 * np.pi, rel=1e-4)


# ---- crush -------------------------------------------------------------------------------------------


def crushed(c):
    mean, variance = 0.2, 0.02
    w = (variance / (variance + (R - mean) ** 2)) ** 3
    return w, hidden_weight((mean, mean**2 + variance), query_crush=c)


def test_crush_below_the_threshold():
    """CTU eq. 4.10: w becomes w^3 / c^2."""
    w, got = crushed(0.9)
    assert got == pytest.approx(w**3 / 0.9**2, rel=2e-3)


def test_crush_above_the_threshold_and_off():
    w, got = crushed(0.1)
    assert got == pytest.approx(w, rel=1e-3)
    assert crushed(0.0)[1] == pytest.approx(w, rel=1e-3)


def test_crush_is_continuous_at_its_threshold():
    w, _ = crushed(0.0)
    below, above = crushed(w * 1.001)[1], crushed(w * 0.999)[1]
    assert below == pytest.approx(above, rel=4e-3)  # slope 3 below, 1 above


# ---- against the formulas in NumPy ---------------------------------------------------------------------


def bias_of(s, normal, viewer, spacing):
    q = s.query
    if q.bias == "scale":  # eq. 2
        return (normal * 0.2 + viewer * 0.8) * (0.75 * spacing.min()) * q.bias_scale
    if q.bias == "ctu":  # eq. 4.11
        return (0.8 * normal + 0.3 * viewer) * q.bias_scale
    if q.bias == "mff":  # listing 3.9
        return (normal + 3 * viewer) * q.bias_scale
    return 0 * normal


def wrap_of(s, cosine):
    q = s.query
    if q.wrap == "half_cosine":
        return ((cosine + 1) / 2) ** 2 + q.wrap_offset
    if q.wrap == "wrap":
        return (max(cosine + q.wrap_a, 0) / (1 + q.wrap_a)) ** (1 + q.wrap_a)
    return max(cosine, 0) if q.wrap == "sharp" else 1.0


def look_up(wide, direction):
    """Bilinear in a bordered map (n + 2, n + 2, C)."""
    n = wide.shape[0] - 2
    p = direction / np.abs(direction).sum()
    square = p[:2] if p[2] >= 0 else (1 - np.abs(p[1::-1])) * np.where(p[:2] >= 0, 1, -1)
    x, y = (square + 1) / 2 * n + 0.5
    c, r = int(x), int(y)
    fx, fy = x - c, y - r
    return (wide[r, c] * (1 - fx) + wide[r, c + 1] * fx) * (1 - fy) + (
        wide[r + 1, c] * (1 - fx) + wide[r + 1, c + 1] * fx
    ) * fy


def reference(s, radiance, moments, origin, spacing, counts, position, normal, viewer):
    """Irradiance at one point by the papers' formulas, in double precision."""
    place = (position - origin) / spacing
    base = np.clip(np.floor(place), 0, np.array(counts) - 2).astype(int)
    place = np.clip(place - base, 0, 1)
    reach = s.volume.longest_distance * np.linalg.norm(spacing)
    total, weights = np.zeros(3), 0.0
    for corner in CORNERS:
        cell = base + corner
        probe = cell[0] + counts[0] * (cell[1] + counts[1] * cell[2])
        at = origin + cell * spacing
        to_probe = at - position
        w = wrap_of(s, normal @ to_probe / np.linalg.norm(to_probe))
        if s.query.visibility:
            from_probe = position + bias_of(s, normal, viewer, spacing) - at
            r = np.linalg.norm(from_probe) / reach
            mean, square = look_up(moments[probe], from_probe)
            variance = abs(square - mean**2)
            if r > mean:
                w *= max(
                    (variance / (variance + (r - mean) ** 2)) ** s.query.chebyshev_exponent,
                    s.query.visibility_floor,
                )
        w = max(w, query.SMALLEST)
        if s.query.crush and w < s.query.crush:
            w = w**3 / s.query.crush**2
        if s.query.trilinear:
            w *= np.prod(np.where(corner == 1, place, 1 - place))
        value = look_up(radiance[probe] ** (0.5 if s.query.sqrt_blending else 1.0), normal)
        total, weights = total + w * value, weights + w
    return np.pi * (total / weights) ** (2 if s.query.sqrt_blending else 1)


MIXES = {
    "default": {},
    "plain": PLAIN,
    "ctu": {
        "query_wrap": "wrap",
        "query_chebyshev_exponent": 1.0,
        "query_visibility_floor": 0.0,
        "query_bias": "ctu",
        "query_bias_scale": 0.25,
    },
    "mff": {
        "query_wrap_offset": 0.0,
        "query_visibility_floor": 0.0,
        "query_crush": 0.0,
        "query_bias": "mff",
        "query_bias_scale": 0.1,
    },
    "sharp": {"query_wrap": "sharp", "query_sqrt_blending": False},
    "wrap": {"query_wrap": "wrap", "query_wrap_a": 0.3, "query_chebyshev_exponent": 2.0},
    "no trilinear": {"query_trilinear": False},
    "strong bias": {"query_bias_scale": 1.0},
}


@pytest.mark.parametrize("name", MIXES)
def test_query_against_the_formulas(name):
    s = small(**MIXES[name])
    counts, origin, spacing = (3, 4, 3), np.array([0.5, -1.0, 2.0]), np.array([0.7, 0.5, 1.1])
    rng = np.random.default_rng(8)
    n, m = s.volume.irradiance_size, s.volume.distance_size
    radiance = rng.uniform(0.2, 3, (36, n, n, 3))
    mean = rng.uniform(0.1, 0.9, (36, m, m))
    moments = np.stack([mean, mean**2 + rng.uniform(0.01, 0.1, mean.shape)], -1)
    vol = hand_made(lattice(counts, origin, spacing), s, radiance, moments)
    low, high = origin - 0.3 * spacing, origin + (np.array(counts) - 0.7) * spacing
    position, normal, viewer = rng.uniform(low, high, (40, 3)), sphere_points(40, 4), sphere_points(40, 5)
    got = query_at(vol, s, position, normal, viewer)
    wide = with_gutter(radiance), with_gutter(moments)
    for k in range(40):
        # The root is taken of the texels, before they are interpolated.
        expected = reference(s, *wide, origin, spacing, counts, position[k], normal[k], viewer[k])
        assert np.allclose(got[k], expected, rtol=1e-3)


# ---- one tap instead of four ---------------------------------------------------------------------------


def taps(count):
    """(count^2, 2) the middles of count^2 cells of the unit square: bilinear weights in fine steps."""
    t = (np.arange(count) + 0.5) / count
    return np.stack([a.ravel() for a in np.meshgrid(t, t)])


@pytest.mark.parametrize("root", [False, True])
def test_stochastic_taps_have_the_bilinear_mean(root):
    """Of the interpolated map value, which is the root of the irradiance where roots are stored."""
    s = small(query_visibility=False, query_sqrt_blending=root)
    radiance = np.random.default_rng(4).uniform(0.1, 4, (27, 6, 6, 3))
    vol = hand_made(lattice((3, 3, 3)), s, radiance)
    rng = np.random.default_rng(5)
    k, power = 64, 0.5 if root else 1.0
    for position, normal in zip(rng.uniform(0, 2, (6, 3)), sphere_points(6, 6), strict=True):
        exact = (query_at(vol, s, position, normal) / np.pi) ** power
        many = query_at(vol, s, np.tile(position, (k * k, 1)), normal, tap=mi.Point2f(*map(floats, taps(k))))
        # A border between texels is placed to within a cell: 1/64 of a jump along each axis, jumps up to 4.
        assert np.allclose(((many / np.pi) ** power).mean(0), exact[0], atol=4 * 2 / k)


def test_stochastic_taps_read_single_texels():
    """Between a black and a white texel a tap is one or the other."""
    s = plain()
    radiance = np.zeros((8, 6, 6, 3))
    radiance[:, ::2] = 1.0
    vol = hand_made(lattice((2, 2, 2)), s, radiance)
    e = query_at(vol, s, np.full((4096, 3), 0.4), (0.3, 0.2, 0.93), tap=mi.Point2f(*map(floats, taps(64))))
    assert set(np.unique(np.round(e / np.pi, 4))) == {0.0, 1.0}


def test_interpolation_is_continuous_across_map_edges():
    """Normals on both sides of the octahedral square's edge read nearly the same."""
    s = plain()
    radiance = np.random.default_rng(9).uniform(0, 1, (8, 6, 6, 3))
    vol = hand_made(lattice((2, 2, 2)), s, radiance)
    t = np.linspace(-3, 3, 400)
    for a, b in (
        ((t, 1e-5 + 0 * t, -1 + 0 * t), (t, -1e-5 + 0 * t, -1 + 0 * t)),
        ((1e-5 + 0 * t, t, -1 + 0 * t), (-1e-5 + 0 * t, t, -1 + 0 * t)),
    ):
        a, b = (np.stack(v, 1) / np.linalg.norm(np.stack(v, 1), axis=1, keepdims=True) for v in (a, b))
        p = np.full(a.shape, 0.3)
        # 2e-5 of an angle crosses 1e-4 of a texel.
        assert np.abs(query_at(vol, s, p, a) - query_at(vol, s, p, b)).max() < 2e-3
