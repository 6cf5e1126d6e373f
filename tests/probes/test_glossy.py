"""Rays that meet metals and gloss go on along the lobe: against mirrored worlds, known light and a path tracer."""

import mitsuba as mi
import numpy as np
import pytest

from ddgi.frame import Frame, render_frame
from ddgi.judge.path_tracer import PathTracer
from ddgi.probes.field import IrradianceField, irradiance_map, radiance_map
from ddgi.scene.camera import look_at
from probing import changed, diffuse, load, rgb, small, updated


def T():  # noqa: N802 (there is none before the variant is set)
    return mi.ScalarTransform4f()


MIRROR = {"type": "conductor", "material": "none"}


def flat(bsdf, height, half=50.0):
    """A floor, seen from above."""
    return {
        "type": "rectangle", "bsdf": bsdf, "to_world": T().translate([0, height, 0]).rotate([1, 0, 0], -90).scale(half),
    }  # fmt: skip


def card(side, kind):
    """A sheet above the floor (side 1) or below (-1), facing +z, that glows or that a spot shines at."""
    sheet = {"type": "rectangle", "bsdf": diffuse(0.7), "to_world": T().translate([0.2, 0.6 * side, -0.5]).scale([0.6, 0.4, 1])}  # fmt: skip
    if kind == "glows":
        return {
            f"card {side}": sheet | {"bsdf": diffuse(0.0), "emitter": {"type": "area", "radiance": rgb(3.0)}}
        }
    spot = {
        "type": "spot", "intensity": rgb(5.0), "cutoff_angle": 10.0,
        "to_world": T().look_at([0, 0.5 * side, 1], [0.2, 0.6 * side, -0.5], [0, 1, 0]),
    }  # fmt: skip
    return {f"card {side}": sheet, f"spot {side}": spot}


def corners():
    """Black specks that make the scene as large as the grid."""
    places = [[-2, -2, -2], [2, 2, 2]]
    return {f"speck {n}": {"type": "sphere", "center": p, "radius": 0.01, "bsdf": diffuse(0.0)} for n, p in enumerate(places)}  # fmt: skip


def world(**parts):
    return load({"type": "scene", **corners(), **parts})


def settled(scene, **more):
    """Mean maps over many updates, radiance and irradiance."""
    s = small(**{
        "grid_counts": (2, 2, 2), "grid_box": ((-1, 0.05, -0.4), (1, 1.2, 1)), "relocation_method": "off", "states_method": "off",
        "contact_hits": 0.0, "gather_energy_preservation": 0.0, "blend_fit_texels": False,
        "blend_warm_up": 1, "blend_recency": 1.0, "blend_hysteresis": 0.9999, "direct_area": "field",
    } | more)  # fmt: skip
    field = updated(scene, s, 200)
    return radiance_map(field, s), irradiance_map(field, s)


@pytest.mark.parametrize("kind", ["glows", "lit"])
def test_a_mirror_shows_the_world_upside_down(kind):
    """What probes see above a mirror is what they see with the mirror gone and a second world below."""
    mirrored = settled(world(mirror=flat(MIRROR, 0), **card(1, kind)))
    both = settled(world(**card(1, kind), **card(-1, kind)))
    one = settled(world(**card(1, kind)))
    for shown, wanted, without in zip(mirrored, both, one, strict=True):
        added = (wanted - without).mean()
        assert added > 0.02 * wanted.mean()
        assert shown.mean() - without.mean() == pytest.approx(added, rel=0.05)
        assert np.abs(shown - wanted).mean() < 0.3 * added


def test_of_sampled_lamps_a_mirror_sends_on_the_light_and_they_do_not():
    """They light surfaces themselves; of what probes see of them only their image is left."""
    scene = world(mirror=flat(MIRROR, 0), **card(1, "glows"))
    image = settled(scene, direct_area="sampled")
    both = settled(world(**card(1, "glows"), **card(-1, "glows")))
    one = settled(world(**card(1, "glows")))
    for shown, wanted, without in zip(image, both, one, strict=True):
        assert shown.mean() == pytest.approx((wanted - without).mean(), rel=0.05)


def test_a_mirror_under_an_even_sky_is_as_bright_as_the_sky():
    shown, _ = settled(world(floor=flat(MIRROR, 0), sky={"type": "constant", "radiance": rgb(1.0)}))
    assert np.abs(shown - 1).max() < 0.01


@pytest.mark.parametrize("alpha", [0.2, 0.4])
@pytest.mark.parametrize("gloss", ["traced", "matt"])
def test_light_that_metal_sends_on_is_that_of_a_path_tracer(alpha, gloss):
    """A lamp above a metal floor, a wall that the floor lights and the lamp does not; taken as matt it is too dark."""
    metal = {"type": "roughconductor", "material": "none", "alpha": alpha, "distribution": "ggx"}
    lamp = {
        "type": "rectangle", "to_world": T().translate([0, 1.5, -0.2]).rotate([1, 0, 0], 90).rotate([0, 1, 0], 20).scale(0.2),
        "bsdf": diffuse(0.0), "emitter": {"type": "area", "radiance": rgb(20.0)},
    }  # fmt: skip
    scene = load({"type": "scene", "floor": flat(metal, 0, 2.0), "lamp": lamp, "wall": {
        "type": "rectangle", "bsdf": diffuse(0.8), "to_world": T().translate([0, 1, -1]).scale(1),
    }})  # fmt: skip
    camera = look_at((0, 1.0, 1.5), (0, 0.9, -1), fov=50, size=(24, 18))
    s = small(grid_counts=(6, 6, 6), blend_warm_up=30, rays_per_probe=256, picture_layers=True)
    field, frame = IrradianceField.fit(scene, s), Frame.empty(camera, s)
    s = changed(s, gather_gloss=gloss)
    for tick in range(64):
        field, frame = render_frame(scene, field, camera, tick, s, frame)
    tracer = PathTracer(scene)
    truth = tracer.render(camera, 2048, 0).picture - tracer.render_direct(camera, 2048, 1).picture
    ratio = np.array(frame.layers["indirect"]).mean() / truth.mean()
    if gloss == "traced":
        assert ratio == pytest.approx(1, abs=0.06)
    else:
        assert abs(ratio - 1) > 0.12
