"""Texel formats: what is stored comes back, within what the bits allow."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.probes import formats

# Largest relative error of a round trip with the worst rounding (up or down): one step of the
# mantissa. R11G11B10 has 6, 6 and 5 bits, half precision 10; rgbe8 256 steps below the largest
# channel, which is at least 128 of them.
STEP = {
    "float32": (0, 0, 0),
    "float16": (2.0**-10,) * 3,
    "rgbe8": (1 / 128,) * 3,
    "r11g11b10": (1 / 64, 1 / 64, 1 / 32),
}
IRRADIANCE = sorted(STEP)
DISTANCE = ("float32", "float16", "unorm8")
DITHERS = (0.0, 0.25, 0.5, 0.75, 1 - 2.0**-24)


def irradiance_trip(name, rgb, dither):
    """Encode, store, read. rgb: (N, 3)."""
    fmt = formats.IRRADIANCE[name]
    lanes = [mi.Float(np.ascontiguousarray(c, np.float32)) for c in np.asarray(rgb).T]
    store = formats.pack(fmt, mi.Color3f(*lanes), mi.Float(dither))
    n = len(rgb)
    assert np.array(store).nbytes == n * fmt.bytes
    return np.array(formats.read(fmt, store, dr.arange(mi.UInt32, n), mi.Bool(True)), np.float64).T


def distance_trip(name, moments, dither):
    fmt = formats.DISTANCE[name]
    lanes = [mi.Float(np.ascontiguousarray(c, np.float32)) for c in np.asarray(moments).T]
    store = formats.pack(fmt, mi.Vector2f(*lanes), mi.Float(dither))
    return np.array(formats.read(fmt, store, dr.arange(mi.UInt32, len(moments)), mi.Bool(True)), np.float64).T


def grey(x):
    return np.repeat(np.asarray(x, np.float32).astype(np.float64)[:, None], 3, 1)


@pytest.mark.parametrize("dither", DITHERS)
@pytest.mark.parametrize("name", IRRADIANCE)
def test_round_trip_within_one_step(name, dither):
    x = grey(np.geomspace(2e-4, 3e4, 4001))
    error = np.abs(irradiance_trip(name, x, dither) / x - 1).max(0)
    assert (error <= np.array(STEP[name]) * (1 + 1e-5)).all()


@pytest.mark.parametrize("dither", DITHERS)
@pytest.mark.parametrize("name", IRRADIANCE)
def test_round_trip_at_powers_of_two(name, dither):
    """Where the exponent changes, and one unit of float32 to either side of there."""
    two = 2.0 ** np.arange(-12, 15, dtype=np.float32)
    x = np.concatenate([two, np.nextafter(two, np.float32(0)), np.nextafter(two, np.float32(1e9))])
    x = grey(np.concatenate([x, two * np.float32(1 - 3e-7), two * np.float32(1 - 1e-6)]))
    error = np.abs(irradiance_trip(name, x, dither) / x - 1).max(0)
    assert (error <= np.array(STEP[name]) * (1 + 1e-5)).all()


@pytest.mark.parametrize("name", IRRADIANCE)
def test_channels_do_not_mix(name):
    x = np.random.default_rng(3).uniform(0.5, 1, (500, 3))
    error = np.abs(irradiance_trip(name, x, 0.5) - x).max(0)
    assert (error <= np.array(STEP[name]) + 1e-6).all()
    x = np.eye(3) * 0.75
    assert np.array_equal(irradiance_trip(name, x, 0.5), x)  # three quarters is a number in every format


@pytest.mark.parametrize("dither", DITHERS)
@pytest.mark.parametrize("name", IRRADIANCE)
def test_zero_is_exact(name, dither):
    assert (irradiance_trip(name, np.zeros((3, 3)), dither) == 0).all()


@pytest.mark.parametrize("name", IRRADIANCE)
def test_new_maps_are_black(name):
    fmt = formats.IRRADIANCE[name]
    store = formats.allocate(fmt, 5)
    assert (np.array(formats.read(fmt, store, dr.arange(mi.UInt32, 5), mi.Bool(True))) == 0).all()


@pytest.mark.parametrize("name", IRRADIANCE)
def test_inactive_lanes_read_zero(name):
    fmt = formats.IRRADIANCE[name]
    store = formats.pack(fmt, mi.Color3f(dr.full(mi.Float, 3, 4)), mi.Float(0.5))
    read = formats.read(fmt, store, mi.UInt32([0, 4_000_000]), mi.Bool([True, False]))
    assert np.allclose(np.array(read)[:, 1], 0)


@pytest.mark.parametrize("dither", [0.0, 0.5])
@pytest.mark.parametrize("name", IRRADIANCE)
def test_monotone(name, dither):
    x = grey(np.geomspace(1e-5, 6e4, 20001))
    assert (np.diff(irradiance_trip(name, x, dither), axis=0) >= 0).all()


@pytest.mark.parametrize("name", IRRADIANCE)
def test_dither_is_unbiased(name):
    """The mean over evenly spread dithers is the value itself, also just below a power of two."""
    n = 256
    rng = np.random.default_rng(5)
    values = np.concatenate([rng.uniform(1, 2, 40), [1.999, 1.9995, 0.999, 0.997, 1.0, 1.001, 0.7]]) * 0.5
    x = np.repeat(grey(values), n, axis=0)
    dithers = mi.Float(np.tile((np.arange(n, dtype=np.float32) + 0.5) / n, len(values)))
    mean = irradiance_trip(name, x, dithers).reshape(len(values), n, 3).mean(1)
    # n evenly spread dithers place the mean within 1/n of a step, and float32 rounds.
    bound = np.array(STEP[name]) / n + 1e-6
    assert (np.abs(mean / grey(values) - 1) <= bound).all()


@pytest.mark.parametrize("name", IRRADIANCE)
def test_small_steps_do_not_stall(name):
    """What dithering is for: 97 % old and 3 % new moves every stored value towards the new one."""
    lanes, target = 4096, 1.02
    rng = np.random.default_rng(7)
    value = np.full((lanes, 3), 0.98)
    for _ in range(200):
        dither = mi.Float(rng.random(lanes, np.float32))
        value = irradiance_trip(name, 0.97 * value + 0.03 * target, dither)
    # 0.97^200 = 0.2 %. The mean over lanes of what dithers leave: a step over the root of their number.
    spread = max(STEP[name]) * 3 / np.sqrt(lanes) * 4
    assert np.abs(value.mean(0) - target).max() <= 0.04 * 0.0023 + spread + 1e-5


@pytest.mark.parametrize("huge", [1e6, 1e9, 1e30])
@pytest.mark.parametrize("name", IRRADIANCE)
def test_overflow_saturates(name, huge):
    """Too much light becomes the most the format holds: never infinite, which would spread."""
    stored = irradiance_trip(name, grey([huge]), 0.9)
    most = {"float32": np.inf, "float16": 65504.0, "rgbe8": np.inf, "r11g11b10": 64512.0}[name]
    assert np.isfinite(stored).all()
    assert (stored >= min(most, huge) * 0.98).all()


# ---- against decoders written from the formats' definitions ----------------------------------------


def decode_r11g11b10(word):
    """DXGI_FORMAT_R11G11B10_FLOAT: red in the low bits; exponent bias 15, denormals, no sign."""
    out = []
    for shift, mantissa in ((0, 6), (11, 6), (22, 5)):
        bits = (int(word) >> shift) & ((1 << (mantissa + 5)) - 1)
        exponent, fraction = bits >> mantissa, (bits & ((1 << mantissa) - 1)) / (1 << mantissa)
        assert exponent < 31  # no infinities
        out.append(fraction * 2.0**-14 if exponent == 0 else (1 + fraction) * 2.0 ** (exponent - 15))
    return out


def decode_rgbe8(texel):
    """Ward 1991: mantissa / 256 times 2^(e - 128)."""
    return [int(m) / 256 * 2.0 ** (int(texel[3]) - 128) for m in texel[:3]]


def wide_range(count=2000, seed=11):
    rng = np.random.default_rng(seed)
    return 2.0 ** rng.uniform(-18, 15.5, (count, 1)) * rng.uniform(0, 1, (count, 3))


@pytest.mark.parametrize("dither", [0.0, 0.5])
def test_r11g11b10_against_its_definition(dither):
    fmt = formats.IRRADIANCE["r11g11b10"]
    x = wide_range().astype(np.float32).astype(np.float64)
    store = formats.pack(fmt, mi.Color3f(*(mi.Float(np.float32(c)) for c in x.T)), mi.Float(dither))
    words = np.array(store)
    ours = np.array(formats.read(fmt, store, dr.arange(mi.UInt32, len(x)), mi.Bool(True)), np.float64).T
    theirs = np.array([decode_r11g11b10(w) for w in words])
    assert np.allclose(ours, theirs, rtol=1e-6, atol=0)
    step = np.maximum(x, 2.0**-14) * np.array(
        [1 / 64, 1 / 64, 1 / 32]
    )  # denormals: steps of 2^-14 / 2^mantissa
    assert (np.abs(theirs - x) <= step * (1 + 1e-5)).all()


@pytest.mark.parametrize(
    "word", [0, 1, 63, 64, 0x7BF, 0x7BF << 11, 31 << 22, 32 << 22, (30 << 27) | (31 << 22)]
)
def test_r11g11b10_decodes_any_word(word):
    fmt = formats.IRRADIANCE["r11g11b10"]
    read = formats.read(fmt, mi.UInt32(word), mi.UInt32(0), mi.Bool(True))
    assert np.allclose(np.array(read).ravel(), decode_r11g11b10(word), rtol=1e-6, atol=0)


@pytest.mark.parametrize("dither", [0.0, 0.5])
def test_rgbe8_against_its_definition(dither):
    fmt = formats.IRRADIANCE["rgbe8"]
    x = wide_range(seed=12).astype(np.float32).astype(np.float64)
    store = formats.pack(fmt, mi.Color3f(*(mi.Float(np.float32(c)) for c in x.T)), mi.Float(dither))
    texels = np.array(store).reshape(-1, 4)
    ours = np.array(formats.read(fmt, store, dr.arange(mi.UInt32, len(x)), mi.Bool(True)), np.float64).T
    theirs = np.array([decode_rgbe8(t) for t in texels])
    assert np.allclose(ours, theirs, rtol=1e-6, atol=0)
    assert (np.abs(theirs - x) <= x.max(1, keepdims=True) / 128 * (1 + 1e-5)).all()
    assert (texels[:, :3].max(1) >= 127).all()  # the shared exponent fits the largest channel


# ---- distances -------------------------------------------------------------------------------------

MOMENT_STEP = {"float32": 0.0, "float16": 2.0**-10, "unorm8": 1 / 255}


@pytest.mark.parametrize("dither", DITHERS)
@pytest.mark.parametrize("name", DISTANCE)
def test_moments_round_trip(name, dither):
    t = np.float64(np.float32(np.linspace(0, 1, 1001)))
    x = np.stack([t, t * t], 1)
    back = distance_trip(name, x, dither)
    step = MOMENT_STEP[name]
    assert (np.abs(back[:, 0] - x[:, 0]) <= step * (1 + 1e-5) + 1e-7).all()
    # unorm8 keeps the root of the mean square, so its error grows with the root: 2 t step.
    assert (np.abs(np.sqrt(back[:, 1]) - t) <= step * (1 + 1e-5) + 1e-6).all()


@pytest.mark.parametrize("name", DISTANCE)
def test_moments_at_the_ends(name):
    for dither in DITHERS:
        assert (distance_trip(name, np.zeros((1, 2)), dither) == 0).all()
    assert np.allclose(distance_trip(name, np.ones((1, 2)), 0.5), 1)


@pytest.mark.parametrize("name", DISTANCE)
def test_moments_dither_is_unbiased(name):
    n = 256
    t = np.random.default_rng(6).uniform(0.3, 0.98, 40)
    x = np.repeat(np.stack([t, t * t], 1), n, 0)
    dithers = mi.Float(np.tile((np.arange(n, dtype=np.float32) + 0.5) / n, len(t)))
    mean = distance_trip(name, x, dithers).reshape(len(t), n, 2).mean(1)
    step = MOMENT_STEP[name]
    assert (np.abs(mean[:, 0] - t) <= step / n + 1e-6).all()
    # The mean of squares exceeds the square of the mean by the variance, at most a quarter step squared.
    assert (np.abs(mean[:, 1] - t * t) <= 2 * step / n + step**2 / 4 + 1e-6).all()


@pytest.mark.parametrize("name", DISTANCE)
def test_long_distances_stay_finite(name):
    """With `long_distances = "off"` a hit may lie hundreds of cells away."""
    assert np.isfinite(distance_trip(name, np.array([[400.0, 160_000.0]]), 0.5)).all()
