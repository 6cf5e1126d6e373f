"""All settings of a frame, one group per stage, and the presets: each paper's, and ours."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

from annotated_types import Interval
from typing_extensions import Doc

from ddgi.errors import SettingsError
from ddgi.lighting import direct
from ddgi.passes import gbuffer, gloss, picture, tone
from ddgi.probes import blend, bounce, contact, grid, query, rays, relocation, states, volume
from ddgi.settings_group import settings_group


@settings_group()
class RenderSettings:
    """Everything that shapes a frame, by stage. Values are compile-time constants of the kernels."""

    seed: Annotated[
        int, Interval(ge=0, le=0xFFFFFFFF), Doc("same seed, same machine: same picture, bit by bit")
    ] = 0
    grid: grid.Settings = grid.Settings()
    relocation: relocation.Settings = relocation.Settings()
    states: states.Settings = states.Settings()
    volume: volume.Settings = volume.Settings()
    rays: rays.Settings = rays.Settings()
    gather: bounce.Settings = bounce.Settings()
    blend: blend.Settings = blend.Settings()
    query: query.Settings = query.Settings()
    contact: contact.Settings = contact.Settings()
    direct: direct.Settings = direct.Settings()
    gloss: gloss.Settings = gloss.Settings()
    gbuffer: gbuffer.Settings = gbuffer.Settings()
    picture: picture.Settings = picture.Settings()
    tone: tone.Settings = tone.Settings()

    @staticmethod
    def preset(name: str) -> RenderSettings:
        """The settings of a preset; `PRESETS` lists them.

        Raises:
            SettingsError: There is no such preset.
        """
        if name not in PRESETS:
            raise SettingsError(f"unknown preset {name!r}: choose one of {', '.join(PRESETS)}")
        return PRESETS[name]


_default = RenderSettings()

# The published systems blend from the second update on, read four texels per map, and leave
# emitters to the probes' rays; light between near things is ours. Each then differs as its own text says.
_published = replace(
    _default,
    gather=replace(_default.gather, taps="bilinear", gloss="matt"),
    blend=replace(_default.blend, warm_up=0, gamma=1.0, long_distances="clamp", fit_texels=False),
    query=replace(
        _default.query,
        sqrt_blending=False,
        wrap_offset=0.2,
        visibility_floor=0.05,
        bias_scale=0.3,
        sight="maps",
    ),
    direct=replace(_default.direct, area="field", environment="field"),
    volume=replace(_default.volume, irradiance_size=8, radiance_size=0),
    contact=contact.Settings(pixels=0.0, hits=0.0),
    rays=replace(_default.rays, from_lamps=0),
    gloss=gloss.Settings(bounces=0),
    relocation=relocation.Settings(method="off"),
    states=states.Settings(method="off"),
)

_scale = replace(
    _published,
    blend=replace(_published.blend, gamma=5.0, thresholds=True),  # 4.2, 4.3
    query=replace(_published.query, sqrt_blending=True),  # listing 2
    # 5. How near a front is near, it does not say.
    relocation=relocation.Settings(method="scale", iterations=5, clearance=0.15),
    states=states.Settings(method="scale"),  # 6
)

_blog = replace(
    _published,
    rays=replace(_published.rays, per_probe=192),  # "192 is a good default"
    # Texture sizes include the border there: 6x6 and 16x16 (papers disagree on counting).
    volume=replace(
        _published.volume,
        irradiance_size=4,
        distance_size=14,
        irradiance_format="r11g11b10",
        distance_format="float16",
    ),
    # BLOG precedes the self-shadow bias and the shortened back faces of SCALE.
    gather=replace(_published.gather, back_face_distance=1.0),
    query=replace(_published.query, bias="ctu", bias_scale=0.25),
)

_ctu = replace(
    _published,
    rays=replace(_published.rays, per_probe=64),  # 4.5: "64 rays per probe are usually enough"
    gather=replace(_published.gather, energy_preservation=0.85, back_face_distance=1.0),
    blend=replace(_published.blend, long_distances="off", growth=32),  # 6.1; it gives no number
    states=states.Settings(method="ctu"),  # 6.1
    query=replace(
        _published.query,
        wrap="wrap",
        wrap_a=1.0,  # eq. 4.4
        chebyshev_exponent=1.0,  # eq. 4.9
        visibility_floor=0.0,
        bias="ctu",
        bias_scale=0.25,  # eq. 4.11; k_n is "in [0, 1]", no value is given
    ),
)

_mff = replace(
    _published,
    volume=replace(_published.volume, irradiance_format="float16", distance_format="float16"),  # table 4.1
    gather=replace(_published.gather, bounces="path", path_length=4, back_face_distance=0.0),  # 3.2.5
    blend=replace(_published.blend, long_distances="reject"),  # 3.3.2
    query=replace(
        _published.query,
        wrap="half_cosine",
        wrap_offset=0.0,  # eq. 3.3
        visibility_floor=0.0,  # listing 3.10
        crush=0.0,
        bias="off",  # listing 3.9, DDGI_NO_NORMAL_OFFSET
        follow_moved=True,  # 3.3.1
    ),
    # 3.3.1, as many iterations as lead through the whole search. Its 15 cm are about that share of a spacing in its rooms.
    relocation=relocation.Settings(method="mff", iterations=50, clearance=0.15),
)

_classic = replace(
    _published,
    gather=replace(_published.gather, back_face_distance=1.0),
    query=replace(_published.query, visibility=False, wrap="off", crush=0.0, bias="off"),
)

# For stills: light between things finer than the probes, a third of the noise's variance, and skies whose
# light has sharp shadows; single frames show the grain of those.
_fine = replace(
    _default,
    volume=replace(_default.volume, irradiance_size=16),
    rays=replace(_default.rays, per_probe=384),
    contact=replace(_default.contact, every=1),
    direct=replace(_default.direct, environment="sampled"),
)

PRESETS: dict[str, RenderSettings] = {
    "default": _default,
    "fine": _fine,
    "scale": _scale,
    "blog": _blog,
    "ctu": _ctu,
    "mff": _mff,
    "classic": _classic,
}
"""`default` is ours, and `fine` with more time; `scale`, `blog`, `ctu` and `mff` are as published; `classic` is irradiance
probes without visibility, what DDGI improves on."""
