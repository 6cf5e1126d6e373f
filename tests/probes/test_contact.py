"""Light from nearby surfaces, which replaces what probes saw in the same direction."""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi import sampling
from ddgi.errors import SettingsError
from ddgi.frame import Frame, render_frame, render_view
from ddgi.probes.bounce import Illumination, around
from ddgi.probes.contact import MOST, in_turn, near_light
from ddgi.probes.field import IrradianceField, irradiance_map, radiance_map
from ddgi.probes.octahedral import direction_to_square, texel_directions
from ddgi.sampling import clock
from probing import (
    camera_in,
    changed,
    dark_light,
    diffuse,
    hand_made,
    lattice,
    load,
    many_ticks,
    rgb,
    room,
    small,
    sphere_points,
    surface_at,
    updated,
)

RADIUS, HEIGHT = 0.3, 0.4
SAMPLES = 4096


def under_a_disk(radiance=0.0, turn=90, bsdf=None):
    return load(scene_of_disk(radiance, turn, bsdf))


def scene_of_disk(radiance=0.0, turn=90, bsdf=None):
    """A disk over the origin that looks down, or turned by -90 up, and emits evenly; nothing else."""
    down = mi.ScalarTransform4f().translate([0, HEIGHT, 0]).rotate([1, 0, 0], turn).scale(RADIUS)
    disk = {"type": "disk", "to_world": down, "bsdf": bsdf or diffuse(0.0, two_sided=True)}
    if radiance:
        disk["emitter"] = {"type": "area", "radiance": rgb(radiance)}
    return {"type": "scene", "disk": disk, "dark": dark_light()}


def with_radiance(**values):
    return small(direct_area="field", **values)


def even_field(s):
    """Probes a metre apart that saw a radiance of one everywhere."""
    return hand_made(lattice((3, 3, 3), (-1, -1, -1)), s, np.ones((27, 3)))


def samples(scene, s, field, reach, pixels=False):
    """What near_light adds at the origin, which looks up. (3, SAMPLES)."""
    by = Illumination(
        scene.tracer, scene.lights, field, many_ticks(SAMPLES), s.gather, s.direct, s.query, s.volume
    )
    at = surface_at(np.zeros((SAMPLES, 3)), (0, 1, 0))
    return np.array(
        near_light(by, at, around(by, at), reach, sampling.PIXEL_CONTACT, pixels=pixels), np.float64
    )


def added(scene, s, reach, pixels=False):
    """Their mean, under a sky of radiance one."""
    return samples(scene, s, even_field(s), reach, pixels).mean(1)


@pytest.mark.parametrize("pixels", [False, True])
@pytest.mark.parametrize("radiance", [0.0, 1.0, 3.0])
def test_a_disk_overhead_takes_its_share_of_the_sky(radiance, pixels):
    """Form factor of a parallel disk from a point on its axis: r^2 / (r^2 + h^2)."""
    factor = RADIUS**2 / (RADIUS**2 + HEIGHT**2)
    expected = np.pi * factor * (radiance - 1)
    error = 4.5 * np.pi * abs(radiance - 1) * np.sqrt(factor * (1 - factor) / SAMPLES)
    assert added(under_a_disk(radiance), with_radiance(), 50.0, pixels) == pytest.approx(
        [expected] * 3, abs=error + 1e-5
    )


@pytest.mark.parametrize("pixels", [False, True])
def test_pixels_know_what_is_near_to_what_is_near(pixels):
    """A grey disk over a black floor: the field lights it, though nothing but the floor can be seen from it."""
    flat = mi.ScalarTransform4f().translate([0, -1e-3, 0]).rotate([1, 0, 0], -90).scale(20)
    floor = {"type": "rectangle", "to_world": flat, "bsdf": diffuse(0.0)}
    scene = load(scene_of_disk(bsdf=diffuse(0.5, two_sided=True)) | {"floor": floor})
    factor = RADIUS**2 / (RADIUS**2 + HEIGHT**2)
    sent = 0.0 if pixels else 0.5
    assert added(scene, with_radiance(), 200.0, pixels) == pytest.approx(
        [np.pi * factor * (sent - 1)] * 3, rel=0.05
    )


def test_no_sample_of_a_pixel_takes_away_more_than_its_bound():
    """Probes saw most of their light around the zenith, where a black disk hides it from the point."""
    s = with_radiance()
    zenith = np.array(texel_directions(8)).reshape(3, 8, 8, 1)[1] > 0.8
    bright = np.broadcast_to(np.where(zenith, 9.0, 0.1), (27, 8, 8, 3))
    field = replace(even_field(s), radiance=hand_made(lattice((3, 3, 3), (-1, -1, -1)), s, bright).radiance)
    free, bounded = (samples(under_a_disk(), s, field, 50.0, pixels).min() for pixels in (False, True))
    assert free < -8 * np.pi
    assert bounded == pytest.approx(-MOST * np.pi, rel=1e-3)  # the field gives pi


def test_beyond_its_reach_the_field_stands():
    assert (added(under_a_disk(), with_radiance(), 0.99 * HEIGHT) == 0).all()


def test_in_the_second_half_of_its_reach_a_surface_counts_less():
    whole, part = (added(under_a_disk(), with_radiance(), reach)[0] for reach in (50.0, 1.5 * HEIGHT))
    # Seen at distances from h to 1.25 h, the share falls from 2 - 2/1.5 to 2 - 2.5/1.5.
    assert 1 / 3 * abs(whole) * 0.9 < abs(part) < 2 / 3 * abs(whole) * 1.1


def test_a_single_sided_surface_from_behind_is_black():
    turned = under_a_disk(3.0, -90, diffuse(0.5))
    factor = RADIUS**2 / (RADIUS**2 + HEIGHT**2)
    assert added(turned, with_radiance(), 50.0)[0] == pytest.approx(-np.pi * factor, rel=0.1)


def furnace():
    shut = room(diffuse(0.5))
    shut["room"]["emitter"] = {"type": "area", "radiance": rgb(0.5)}
    return load(shut)


@pytest.mark.parametrize(("hits", "every"), [(0.0, 1), (1.5, 1), (1.5, 3)])
def test_in_the_furnace_nothing_changes(hits, every):
    """Everything has radiance 1, near and far: S = 1, in pixels as in maps."""
    s = with_radiance(
        contact_hits=hits, contact_pixels=1.5, contact_every=every, blend_warm_up=30, rays_per_probe=256
    )
    scene = furnace()
    field = updated(scene, s, 25)
    assert np.allclose(irradiance_map(field, s) / np.pi, 1, rtol=5e-3)
    assert np.allclose(radiance_map(field, s), 1, rtol=5e-3)
    _, frame = render_frame(scene, field, camera_in(), 30, s, Frame.empty(camera_in(), s))
    assert np.allclose(frame.numpy(), 1, rtol=2e-2)


def test_radiance_and_irradiance_maps_tell_the_same():
    """The cosine-weighted mean of the one is the other, as far as 8 x 8 texels go."""
    s = with_radiance(rays_per_probe=1024, blend_warm_up=0, blend_hysteresis=0.9)
    scene = load(
        room(diffuse(0.7), lamp={"type": "point", "position": [0.4, 0.2, -0.3], "intensity": rgb(2.0)})
    )
    field = updated(scene, s, 40)
    looks, seen = sphere_points(20_000), radiance_map(field, s)[..., 0]
    cells = mi.Vector3f(*(mi.Float(c) for c in looks.T))
    square = np.array(direction_to_square(cells)).T
    x, y = np.clip(((square + 1) * 4).astype(int), 0, 7).T
    normals = np.array(texel_directions(s.volume.irradiance_size)).T
    cosine = np.maximum(normals @ looks.T, 0)  # (texels, looks)
    mean = np.einsum("tl,pl->pt", cosine, seen[:, y, x]) / cosine.sum(1)
    found = irradiance_map(field, s)[..., 0].reshape(len(mean), -1) / np.pi
    assert np.abs(mean / found - 1).mean() < 0.05


def test_without_maps_of_radiance_contact_is_refused():
    scene, without = furnace(), small(volume_radiance_size=0, contact_pixels=0.0, contact_hits=0.0)
    with pytest.raises(SettingsError, match=r"volume\.radiance_size"):
        IrradianceField.fit(scene, changed(without, contact_hits=1.0))
    field = IrradianceField.fit(scene, without)
    with pytest.raises(SettingsError, match=r"volume\.radiance_size"):
        render_frame(scene, field, camera_in(), 0, changed(without, contact_pixels=1.0))
    with pytest.raises(SettingsError, match="radiance"):
        radiance_map(field, without)


@pytest.mark.parametrize(("count", "every"), [(128, 4), (10, 3), (9, 9), (7, 1)])
def test_every_ray_gets_its_turn(count, every):
    """The order is one of all rays; those that come first are spread over them, and others each time."""
    few, first = count // every, []
    for tick in range(every):
        order = np.array(in_turn(dr.arange(mi.UInt32, count), few, every, clock(0, tick)))
        assert sorted(order) == list(range(count))
        assert (np.diff(order[:few]) == every).all()
        first += order[:few].tolist()
    assert sorted(first) == list(range(few * every))


def thinned_room(every):
    """A lit room with a shelf in it, after some frames."""
    shelf = mi.ScalarTransform4f().translate([0, -0.6, 0]).rotate([1, 0, 0], -90).scale(0.5)
    scene = load(
        room(
            diffuse(0.7),
            lamp={"type": "point", "position": [0.4, 0.2, -0.3], "intensity": rgb(2.0)},
            shelf={"type": "rectangle", "to_world": shelf, "bsdf": diffuse(0.2, two_sided=True)},
        )
    )
    s = small(contact_every=every, contact_pixels=3.0, contact_hits=3.0, rays_per_probe=256)
    field, frame = IrradianceField.fit(scene, s), Frame.empty(camera_in(), s)
    for tick in range(48):
        field, frame = render_frame(scene, field, camera_in(), tick, s, frame)
    return frame.numpy().mean()


def test_few_samples_tell_the_same_as_all():
    assert thinned_room(4) == pytest.approx(thinned_room(1), rel=0.01)


def test_same_seed_same_light():
    s = with_radiance(contact_hits=1.0, contact_pixels=1.0)
    scene = furnace()
    blank = Frame.empty(camera_in(), s)
    pictures = [
        render_frame(scene, updated(scene, s, 2), camera_in(), 2, s, blank)[1].numpy() for _ in range(2)
    ]
    assert (pictures[0] == pictures[1]).all()


def test_only_pictures_that_add_up_look_for_what_is_near():
    """A frame by itself has no grain: it is what it would be without the rays from pixels."""
    scene, s = furnace_with_lamp(), small()
    field = updated(scene, s, 2)
    alone, plain = (
        render_view(scene, field, camera_in(), 2, x).numpy() for x in (s, changed(s, contact_pixels=0.0))
    )
    assert (alone == plain).all()
    summed = render_view(scene, field, camera_in(), 2, s, Frame.empty(camera_in(), s)).numpy()
    assert np.abs(summed - plain).max() > 0.01 * plain.max()
    other = Frame.empty(camera_in((16, 12)), s)  # of another view: nothing to go on from
    assert (render_view(scene, field, camera_in(), 2, s, other).numpy() == plain).all()


def furnace_with_lamp():
    return load(
        room(diffuse(0.5), lamp={"type": "point", "position": [0.4, 0.2, -0.3], "intensity": rgb(2.0)})
    )
