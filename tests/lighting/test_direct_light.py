"""Light from lights alone: closed forms, Mitsuba's emitters, and shadows."""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.lighting import direct
from ddgi.sampling import PIXEL_LIGHT, clock
from probing import load, points, rgb, room, surface_at

# float32 with a square root and a division.
CLOSE = 1e-5


def far_floor(**more):
    """Something to be a scene, out of the way."""
    below = mi.ScalarTransform4f().translate([0, 0, -900]).scale([500, 500, 1])
    floor = {"type": "rectangle", "to_world": below}
    return load({"type": "scene", "floor": floor, **more})


def arriving(scene, surface, tick=0, specular=False, samples=1, **values):
    """(N, 3) irradiance, and the specular part."""
    got = direct.direct_light(
        scene.tracer, scene.lights, surface, direct.Settings(**values),
        time=clock(0, tick), stream=PIXEL_LIGHT, samples=samples, specular=specular,
    )  # fmt: skip
    width = dr.width(surface.distance)
    wide = lambda c: np.array(c + dr.zeros(mi.Color3f, width), np.float64).T  # noqa: E731
    return wide(got.irradiance), wide(got.specular)


def point(x, y, z, intensity=1.0):
    return {"type": "point", "position": [x, y, z], "intensity": rgb(intensity)}


def somewhere(count=200, seed=0):
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=(count, 3))
    return rng.uniform(-2, 2, (count, 3)), normal / np.linalg.norm(normal, axis=1, keepdims=True)


# ---- delta lights -------------------------------------------------------------------------------------


def test_point_light_is_intensity_times_cosine_over_distance_squared():
    scene = far_floor(light={"type": "point", "position": [0.5, 1.0, 2.0], "intensity": rgb(3, 2, 1)})
    position, normal = somewhere()
    to_light = np.array([0.5, 1.0, 2.0]) - position
    d = np.linalg.norm(to_light, axis=1)
    cosine = np.maximum((to_light * normal).sum(1) / d, 0)
    expected = (cosine / d**2)[:, None] * np.array([3, 2, 1])
    got, _ = arriving(scene, surface_at(position, normal))
    assert np.allclose(got, expected, rtol=1e-4, atol=CLOSE)
    assert (got[cosine == 0] == 0).all()


def test_point_light_twice_as_far_gives_a_quarter():
    scene = far_floor(light=point(0, 0, 0, 8.0))
    got, _ = arriving(scene, surface_at([(0, 0, -1), (0, 0, -2), (0, 0, -4)], (0, 0, 1)))
    assert np.allclose(got[:, 0], [8, 2, 0.5], rtol=CLOSE)


def test_directional_light_is_the_same_everywhere():
    sun = {"type": "directional", "direction": [0, -3.0, -4.0], "irradiance": rgb(2.0)}
    scene = far_floor(light=sun)
    position, _ = somewhere()
    got, _ = arriving(scene, surface_at(position, (0, 0, 1)))
    assert np.allclose(got, 2 * 0.8, rtol=CLOSE)


SPOT = {
    "type": "spot",
    "intensity": {"type": "rgb", "value": [5.0, 4.0, 3.0]},
    "cutoff_angle": 40.0,
    "beam_width": 15.0,
}


def test_spot_falls_off_as_mitsubas():
    look = mi.ScalarTransform4f().look_at(origin=[0.3, 0.2, 3.0], target=[0.5, 0.0, 0.0], up=[0, 1, 0])
    spot = SPOT | {"to_world": look}
    scene = far_floor(light=spot)
    position, _ = somewhere(2000)
    position[:, 2] = 0
    surface = surface_at(position, (0, 0, 1))
    got, _ = arriving(scene, surface)

    emitter = mi.load_dict({k: (dict(v) if isinstance(v, dict) else v) for k, v in spot.items()})
    here = dr.zeros(mi.SurfaceInteraction3f, 2000)
    here.p = surface.position
    found, weight = emitter.sample_direction(here, mi.Point2f(0.5))
    expected = np.array(weight, np.float64).T * np.maximum(np.array(found.d.z, np.float64), 0)[:, None]
    lit = expected[:, 0] > 0
    assert 200 < lit.sum() < 1900  # the cone's rim is in the picture
    # The angle comes from an arc cosine: 1e-4 rad of a 25 degree slope.
    assert np.allclose(got, expected, atol=2e-4 * expected.max())


def test_spot_known_angles():
    """Full inside the beam, half way between beam and cutoff one half, nothing beyond."""
    down = mi.ScalarTransform4f().look_at(origin=[0, 0, 1], target=[0, 0, 0], up=[0, 1, 0])
    scene = far_floor(light=SPOT | {"to_world": down})
    angles = np.radians([0, 10, 27.5, 39.9, 41])
    at = np.stack([np.tan(angles), 0 * angles, 0 * angles], 1)
    got, _ = arriving(scene, surface_at(at, (0, 0, 1)))
    intensity = got[:, 0] / np.cos(angles) ** 3  # one metre below: cosine over distance squared
    assert np.allclose(intensity, [5, 5, 2.5, 5 * 0.1 / 25, 0], atol=5e-3)


def test_many_lights_add_up():
    """More lights than are unrolled are looped over; the sum is that of each by itself."""
    lights = {f"p{i}": point(np.cos(i), np.sin(i), 0.5 + 0.2 * i, 1.0 + i) for i in range(7)}
    assert len(lights) > direct.UNROLLED_LIGHTS
    wall = {"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0, 0, 0.8]).scale(0.3)}
    position, normal = somewhere(300)
    surface = surface_at(position, normal, viewer=normal, base=0.5, specular=0.04, alpha=0.3)
    together = arriving(far_floor(wall=dict(wall), **lights), surface, specular=True)
    single = [
        arriving(far_floor(wall=dict(wall), light=light), surface, specular=True) for light in lights.values()
    ]
    for part in (0, 1):
        expected = sum(one[part] for one in single)
        assert expected.max() > 0.1
        assert np.allclose(together[part], expected, rtol=1e-4, atol=1e-5)


def test_shadows_are_black():
    """A wall between light and floor: exactly nothing arrives."""
    wall = {"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0, 0, 1]).scale(10)}
    for light in (
        point(0, 0, 2),
        {"type": "directional", "direction": [0, 0, -1], "irradiance": rgb(1.0)},
        SPOT | {"to_world": mi.ScalarTransform4f().look_at(origin=[0, 0, 2], target=[0, 0, 0], up=[0, 1, 0])},
    ):
        position = np.random.default_rng(1).uniform(-1, 1, (100, 3)) * [1, 1, 0]
        surface = surface_at(position, (0, 0, 1), specular=0.04, alpha=0.2)
        got = arriving(far_floor(wall=wall, light=light), surface, specular=True)
        assert (got[0] == 0).all()
        assert (got[1] == 0).all()
        free = arriving(far_floor(light=light), surface, specular=True)
        assert (free[0] > 0).all()


def test_surfaces_do_not_shadow_themselves():
    """Points on the walls of a room, hit by rays, all see the light in its middle."""
    scene = load(room({"type": "diffuse"}, half=3.0, light=point(0, 0, 0)))
    v = np.random.default_rng(2).normal(size=(3000, 3))
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    surface = scene.tracer.intersect(
        mi.Point3f(0.1, -0.2, 0.3),
        mi.Vector3f(points(v)),
        mi.Bool(True),
        time=clock(0, 0),
        stream=PIXEL_LIGHT,
    )
    got, _ = arriving(scene, surface)
    p, n = np.array(surface.position, np.float64).T, np.array(surface.normal, np.float64).T
    d = np.linalg.norm(p, axis=1)
    assert np.allclose(got[:, 0], -(p * n).sum(1) / d**3, rtol=1e-4)


def test_back_sides_get_no_light():
    scene = far_floor(light=point(0, 0, 1))
    surface = surface_at([(0, 0, 0)], (0, 0, 1))
    assert (arriving(scene, replace(surface, back=mi.Bool(True)))[0] == 0).all()
    assert (arriving(scene, replace(surface, valid=mi.Bool(False)))[0] == 0).all()


# ---- area lights ----------------------------------------------------------------------------------------

N = 1 << 16


def lamp(x=0.0, y=0.0, half=(1.0, 0.5), height=2.0, radiance=3.0):
    """A rectangle that looks down."""
    t = mi.ScalarTransform4f().translate([x, y, height]).rotate([1, 0, 0], 180).scale([*half, 1])
    return {"type": "rectangle", "to_world": t, "emitter": {"type": "area", "radiance": rgb(radiance)}}


def form_factor(x, y, half=(1.0, 0.5), height=2.0):
    """From a small horizontal patch below to the rectangle: four corner terms (any radiometry text)."""

    def corner(a, b):
        a, b = a / height, b / height
        p, q = np.sqrt(1 + a * a), np.sqrt(1 + b * b)
        return (a / p * np.arctan(b / p) + b / q * np.arctan(a / q)) / (2 * np.pi)

    x0, x1, y0, y1 = x - half[0], x + half[0], y - half[1], y + half[1]
    return corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)


@pytest.mark.parametrize("at", [(0.0, 0.0), (1.5, -0.7)])
def test_area_light_against_its_form_factor(at):
    scene = far_floor(lamp=lamp(*at))
    got, _ = arriving(scene, surface_at(np.zeros((N, 3)), (0, 0, 1)), area="sampled")
    expected = np.pi * 3.0 * form_factor(*at)
    assert got[:, 0].mean() == pytest.approx(expected, abs=4.5 * got[:, 0].std() / np.sqrt(N))


def test_area_light_left_to_the_field_adds_nothing():
    got, _ = arriving(far_floor(lamp=lamp()), surface_at(np.zeros((16, 3)), (0, 0, 1)), area="field")
    assert (got == 0).all()


def test_area_light_does_not_shine_backwards():
    got, _ = arriving(
        far_floor(lamp=lamp()), surface_at(np.full((256, 3), [0, 0, 4.0]), (0, 0, -1)), area="sampled"
    )
    assert (got == 0).all()


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_every_point_converges_with_several_area_lights(count):
    """Not only the mean over points: one point's mean over frames must reach the exact value."""
    places = [(0.0, 0.0), (2.5, 0.3), (-2.4, 0.8), (0.2, 2.2)][:count]
    scene = far_floor(**{f"lamp{i}": lamp(*p, radiance=1.0 + i) for i, p in enumerate(places)})
    expected = sum(np.pi * (1.0 + i) * form_factor(*p) for i, p in enumerate(places))
    surface = surface_at(np.zeros((64, 3)), (0, 0, 1))
    frames = 256
    step = dr.freeze(
        lambda surface, time: direct.direct_light(
            scene.tracer, scene.lights, surface, direct.Settings(area="sampled"),
            time=time, stream=PIXEL_LIGHT, samples=1, specular=False,
        ).irradiance.x
    )  # fmt: skip
    total = np.zeros(64)
    for tick in range(frames):
        total += np.array(step(surface, clock(0, tick)), np.float64)
    # Independent samples would leave a spread of about 1.1 / sqrt(256) = 7 % with 4 lamps picked
    # in turn; a low-discrepancy sequence must do better, and no point may stay wrong.
    assert np.abs(total / frames / expected - 1).max() < 0.05


@pytest.mark.parametrize("height", [0.03, 0.3])
def test_a_lamp_close_above_a_floor_does_not_shade_it(height):
    """Where coordinates are large, rays start far off their surface: not beyond the lamp they go to."""
    half = height / 20
    to_world = (
        mi.ScalarTransform4f().translate([60, 60, height]).rotate([1, 0, 0], 180).scale([half, half, 1])
    )
    small_lamp = {"type": "rectangle", "to_world": to_world, "emitter": {"type": "area", "radiance": rgb(1)}}
    scene = load(
        {
            "type": "scene",
            "floor": {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale([100, 100, 1])},
            "lamp": small_lamp,
        }
    )
    above = points(np.tile([60.0, 60.0, height / 2], (64, 1)))
    surface = scene.tracer.intersect(
        above, mi.Vector3f(0, 0, -1), dr.full(mi.Bool, True, 64), time=clock(0, 0), stream=PIXEL_LIGHT
    )
    got, _ = arriving(scene, surface, area="sampled")
    # A small square straight above: its area over the squared distance; 1 % for coordinates of 60 in
    # single precision, and the square's size.
    assert got[:, 0] == pytest.approx(4 * half**2 / height**2, rel=0.01)


def test_more_samples_less_noise():
    scene = far_floor(lamp=lamp(half=(1.5, 1.5), height=1.0))
    surface = surface_at(np.zeros((4096, 3)), (0, 0, 1))
    one, many = (arriving(scene, surface, samples=n, area="sampled")[0][:, 0] for n in (1, 16))
    assert many.mean() == pytest.approx(one.mean(), rel=0.03)
    assert many.std() < one.std() / 3  # independent samples: a quarter; low-discrepancy: less


@pytest.mark.parametrize("height", [0.5, 20.0])
def test_sampled_light_casts_shadows(height):
    wall = {"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0, 0, 0.5 * height]).scale(50)}
    got, _ = arriving(
        far_floor(lamp=lamp(height=height), wall=wall),
        surface_at(np.zeros((256, 3)), (0, 0, 1)),
        area="sampled",
    )
    assert (got == 0).all()


# ---- environment ------------------------------------------------------------------------------------------


def test_sampled_constant_environment_gives_pi_l():
    scene = far_floor(sky={"type": "constant", "radiance": rgb(0.7)})
    got, _ = arriving(scene, surface_at(np.zeros((N, 3)), (0, 0, 1)), environment="sampled")
    assert got[:, 0].mean() == pytest.approx(np.pi * 0.7, abs=4.5 * got[:, 0].std() / np.sqrt(N))


def test_environment_left_to_the_field_adds_nothing():
    scene = far_floor(sky={"type": "constant", "radiance": rgb(0.7)})
    assert (arriving(scene, surface_at(np.zeros((9, 3)), (0, 0, 1)), environment="field")[0] == 0).all()
