"""No setting without effect: each field of each group, given another value, changes the result.

A new field fails here until `OTHER` says how it shows.
"""

from dataclasses import fields, is_dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SettingsError
from ddgi.frame import render_frame
from ddgi.passes.tone import tone_map
from ddgi.probes.field import IrradianceField, distance_map, irradiance_map
from ddgi.probes.states import attend
from ddgi.probes.update import update
from ddgi.sampling import clock
from ddgi.settings import RenderSettings
from probing import camera_in, changed, diffuse, load, rgb, small

# field: (another value, what else must hold for it to matter)
MAPS = {
    "seed": (1, {}),
    "grid.box": (((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)), {}),
    "grid.counts": ((3, 4, 5), {}),
    "grid.spacing": (0.9, {"grid_counts": None}),
    "grid.budget": (90, {"grid_counts": None}),
    "grid.margin": (0.3, {}),
    "relocation.method": ("scale", {}),
    "relocation.limit": (0.1, {}),
    "relocation.clearance": (0.5, {}),
    "relocation.iterations": (
        1,
        {"relocation_method": "scale", "relocation_iterations": 5, "relocation_clearance": 0.5},
    ),
    "relocation.rays": (7, {"relocation_method": "scale"}),
    "relocation.certainty_hysteresis": (
        0.95,
        {"relocation_method": "mff", "relocation_iterations": 6, "relocation_clearance": 0.5},
    ),
    "states.method": ("off", {"grid_counts": (9, 9, 9)}),
    "states.rays": (8, {"grid_counts": (9, 9, 9)}),
    "states.every": (
        0,
        {"grid_counts": (9, 9, 9), "states_rays": 8, "states_every": 1, "states_look_rays": 512},
    ),
    "states.look_rays": (512, {"grid_counts": (9, 9, 9), "states_rays": 8, "states_every": 1}),
    "states.alive": (
        0,
        {"states_method": "ctu", "states_every": 2, "states_look_rays": 1, "grid_counts": (9, 9, 9)},
    ),
    "volume.irradiance_size": (4, {}),
    "volume.distance_size": (5, {}),
    "volume.irradiance_format": ("r11g11b10", {}),
    "volume.distance_format": ("unorm8", {}),
    "volume.longest_distance": (0.5, {}),
    "rays.per_probe": (32, {}),
    "rays.from_lamps": (0, {}),
    "gather.bounces": ("path", {"gather_path_length": 2}),
    "gather.path_length": (2, {}),
    "gather.energy_preservation": (0.5, {}),
    "gather.back_face_distance": (1.0, {}),
    "gather.taps": ("bilinear", {}),
    "gather.gloss": ("matt", {}),
    "blend.hysteresis": (0.5, {"blend_warm_up": 0}),
    "blend.warm_up": (0, {}),
    "blend.recency": (1.0, {"blend_warm_up": 1}),
    "blend.growth": (8, {"blend_warm_up": 0}),
    "blend.thresholds": (True, {"blend_warm_up": 0}),
    "blend.small_change": (0.0, {"blend_warm_up": 0, "blend_thresholds": True, "blend_large_change": 1.0}),
    "blend.large_change": (0.0, {"blend_warm_up": 0, "blend_thresholds": True}),
    "blend.gamma": (3.0, {"blend_gamma": 1.0, "blend_warm_up": 0, "blend_hysteresis": 0.5}),
    "blend.sharpness": (5.0, {}),
    "blend.fit_texels": (False, {}),
    "blend.long_distances": ("reject", {}),
    "query.trilinear": (False, {}),
    "query.follow_moved": (True, {"relocation_method": "scale", "relocation_clearance": 0.5}),
    "query.wrap": ("sharp", {}),
    "query.wrap_offset": (0.7, {"query_wrap": "half_cosine"}),
    "query.wrap_a": (0.2, {"query_wrap": "wrap"}),
    "query.visibility": (False, {}),
    "query.chebyshev_exponent": (1.0, {}),
    "query.visibility_floor": (0.6, {}),
    "query.crush": (0.9, {}),
    "query.bias": ("mff", {}),
    "query.bias_scale": (1.5, {}),
    "query.sight": ("maps", {}),
    "query.sqrt_blending": (True, {}),
    "volume.radiance_size": (4, {}),
    "contact.hits": (0.0, {}),
    "contact.every": (1, {}),
    "direct.area": ("field", {}),
    "direct.environment": ("sampled", {}),
    "direct.probe_samples": (2, {}),
}
PICTURE = {
    "direct.camera_samples": (2, {}),
    "contact.pixels": (0.0, {}),
    "gloss.bounces": (0, {}),
    "gbuffer.antialias": (False, {}),
    "tone.exposure": (3.0, {}),
    "tone.curve": ("linear", {}),
}
# Shown by tests of their own, below.
ELSEWHERE = {
    "grid.memory_limit",
    "picture.layers",
    "relocation.rejects",
    "blend.watch",
    "blend.watch_deviations",
}


def every_field():
    """All fields of all groups, as "group.field"."""
    default = RenderSettings.preset("default")
    for group in fields(RenderSettings):
        value = getattr(default, group.name)
        if is_dataclass(value):
            yield from (f"{group.name}.{f.name}" for f in fields(value))
        else:
            yield group.name


def test_the_table_is_complete():
    assert set(every_field()) == {*MAPS, *PICTURE, *ELSEWHERE}


@pytest.fixture(scope="module")
def scene():
    """A little of everything: three walls, a lamp, a bulb, a sky, a mask, and a sheet with a black back."""
    t = mi.ScalarTransform4f
    side = lambda bsdf, to_world, **more: {"type": "rectangle", "bsdf": bsdf, "to_world": to_world, **more}  # noqa: E731
    red = {"type": "diffuse", "reflectance": rgb(0.7, 0.2, 0.1)}
    return load({
        "type": "scene",
        "floor": side(diffuse(0.6), t().translate([0, -1, 0]).rotate([1, 0, 0], -90)),
        "back": side(red, t().translate([0, 0, -1])),
        "left": side(diffuse(0.8), t().translate([-1, 0, 0]).rotate([0, 1, 0], 90)),
        "sheet": side(diffuse(0.5), t().translate([0.3, -0.2, 0.2]).rotate([0, 1, 0], 140).scale(0.4)),
        "card": side(
            {"type": "mask", "opacity": 0.5, "nested": diffuse(0.5, two_sided=True)},
            t().translate([-0.4, 0, 0.3]).scale(0.3),
        ),
        "lamp": side(
            diffuse(0.0), t().translate([0, 0.95, 0]).rotate([1, 0, 0], 90).scale(0.3),
            emitter={"type": "area", "radiance": rgb(4.0)},
        ),
        "ball": {
            "type": "sphere", "center": [-0.1, 0.3, -0.5], "radius": 0.25,
            "bsdf": {"type": "conductor", "material": "none"},
        },
        "bulb": {"type": "point", "position": [0.6, 0.4, 0.7], "intensity": rgb(0.4)},
        "sky": {"type": "constant", "radiance": rgb(0.3)},
    })  # fmt: skip


UPDATES = 3


def base(values):
    """Few probes, and updates that keep some of the old."""
    return small(**({"blend_warm_up": 8, "grid_counts": (4, 4, 4), "grid_budget": 50} | values))


def maps(scene, s):
    field = IrradianceField.fit(scene, s)
    for tick in range(UPDATES):
        field = replace(field, volumes=[attend(vol, scene.tracer, tick, s) for vol in field.volumes])
        field = update(scene.tracer, scene.lights, field, clock(s.seed, tick), s)
        dr.eval(field)
    layout = field.volumes[0].grid
    return irradiance_map(field, s), distance_map(field, s), np.array(layout.origin), np.array(layout.spacing)


def shown(scene, s):
    field, frame = IrradianceField.fit(scene, s), None
    for tick in range(2):
        field, frame = render_frame(scene, field, camera_in((24, 18)), tick, s, frame)
    return (tone_map(frame.numpy(), s.tone),)


_before = {}


def differs(name, other, needs, make, scene):
    before = base(needs)
    group, _, field = name.partition(".")
    assert (getattr(getattr(before, group), field) if field else before.seed) != other, "no other value"
    key = (make, before)
    if key not in _before:
        _before[key] = make(scene, before)
    after = make(scene, changed(before, **{name.replace(".", "_", 1): other}))
    for a, b in zip(_before[key], after, strict=True):
        # Another value compiles another kernel, and may round otherwise: 1e-3 is no rounding.
        if a.shape != b.shape or np.abs(a - b).max() > 1e-3 * np.abs(a).max():
            return True
    return False


@pytest.mark.parametrize("name", MAPS)
def test_settings_change_the_maps(name, scene):
    assert differs(name, *MAPS[name], maps, scene)


@pytest.mark.parametrize("name", PICTURE)
def test_settings_change_the_picture(name, scene):
    assert differs(name, *PICTURE[name], shown, scene)


def test_the_memory_limit_refuses(scene):
    s = base({"grid_counts": (12, 12, 12)})
    IrradianceField.fit(scene, s)
    with pytest.raises(SettingsError, match="memory_limit"):
        IrradianceField.fit(scene, changed(s, grid_memory_limit=2.0))


def test_moves_beyond_a_limit_reject_what_was_gathered(scene):
    ages = []
    for limit in (0.0, 1.0):
        s = base({"relocation_rejects": limit, "states_method": "off", "blend_warm_up": 0})
        field = IrradianceField.fit(scene, changed(s, relocation_method="off"))
        field = update(scene.tracer, scene.lights, field, clock(s.seed, 0), s)
        s = changed(s, relocation_method="scale", relocation_clearance=0.5)
        ages.append(np.array(field.relocate(scene, s).volumes[0].age))
    assert (ages[0] == 0).any()
    assert (ages[1] == 1).all()


def test_layers_are_kept_when_asked_for(scene):
    for keep in (False, True):
        s = base({"picture_layers": keep})
        _, frame = render_frame(scene, IrradianceField.fit(scene, s), camera_in((24, 18)), 0, s)
        assert bool(frame.layers) == keep
