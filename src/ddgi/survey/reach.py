"""Pictures without indirect light: because no probe sees what they show, or because no probe sees any light."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.passes import gbuffer
from ddgi.plural import percent
from ddgi.probes import query
from ddgi.probes.field import IrradianceField
from ddgi.sampling import clock
from ddgi.scene.camera import with_size
from ddgi.scene.scene import Scene
from ddgi.settings import RenderSettings

WIDTH = 96
"""Of the picture that is asked about [pixels]."""
MUCH = 0.2
"""Of a picture: more than what lies in corners and behind furniture."""


def unreached(scene: Scene, field: IrradianceField, settings: RenderSettings) -> float:
    """Share of what the first camera sees, in [0, 1], that no probe lights.

    Args:
        scene: What there is.
        field: Whose probes light it.
        settings: Of the frames.
    """
    width, height = scene.camera.size
    camera = with_size(scene.camera, (WIDTH, max(1, round(WIDTH * height / width))))
    surface = gbuffer.gbuffer(scene.tracer, camera, clock(settings.seed, 0), gbuffer.Settings())
    shares = query.shares(
        field.volumes[0], query.Receiver.on(surface), settings.volume, settings.query, scene.tracer
    )
    lit, total = np.array(surface.lit), np.array(mi.Float(sum(share for _, share in shares)))
    return float((total[lit] <= 0).mean()) if lit.any() else 0.0


def dark(field: IrradianceField) -> bool:
    """Whether no probe has seen any light. Whatever the format of the maps, it is zero in all of them then."""
    return not any(dr.any(vol.irradiance != 0)[0] for vol in field.volumes)


def remark(scene: Scene, field: IrradianceField, settings: RenderSettings) -> str | None:
    """What to say of a field that lights next to nothing of what the first camera sees; None if there is nothing to say."""
    advice = "name another grid.box (`ddgi info` says where it is)"
    if dark(field):
        return f"no probe sees any light: if there is some to see, the volume lies inside something, or elsewhere: {advice}"
    share = unreached(scene, field, settings)
    if share < MUCH:
        return None
    return (
        f"{percent(share)} of what the camera sees is seen by no probe and gets no indirect light: the volume lies inside "
        f"something, or behind walls: {advice}"
    )
