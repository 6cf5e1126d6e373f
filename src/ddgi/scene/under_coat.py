"""What the matt part of a plastic reflects, under its coat.

Light enters through the coat, meets the pigment, and part of what comes back is reflected inwards to
meet it again: a grey of 0.5 sends back 0.26, one of 1 sends back 0.91.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache

import mitsuba as mi
import numpy as np

from ddgi.scene.reflectance import hemispherical_reflectance

MATT = 1
"""Of the parts that a plastic is made of; 0 is the coat."""


def under_coat(bsdf: mi.BSDF, eta: float, alpha: float) -> Callable[[np.ndarray], np.ndarray]:
    """How the reflectance x of the pigment becomes that of the matt part, both in [0, 1].

    The curve k x (1 - f) / (1 - f x): a share f of what comes back is kept inside (0 for plastics that are
    not `nonlinear`), and k is what a white one reflects. Both are measured on grey plastics like it.

    Args:
        bsdf: A `plastic` or `roughplastic`; the colour that it has does not matter.
        eta: Its index of refraction, relative to that around it.
        alpha: Its roughness, where it has one.
    """
    rough = bsdf.class_name() == "RoughPlastic"
    found = re.search(r"distribution = (\w+)", str(bsdf))
    white, kept = _measured(
        eta, alpha if rough else None, found.group(1) if found else "beckmann", "nonlinear = 1" in str(bsdf)
    )
    return lambda x: white * (1 - kept) * x / (1 - kept * np.clip(x, 0, 1))


@cache
def _measured(eta: float, alpha: float | None, distribution: str, nonlinear: bool) -> tuple[float, float]:
    """Reflectance of a white matt part, and the share kept inside; no alpha: of a smooth plastic."""
    described: dict[str, object] = {"type": "plastic", "int_ior": eta, "ext_ior": 1.0, "nonlinear": nonlinear}
    if alpha is not None:
        described |= {"type": "roughplastic", "alpha": alpha, "distribution": distribution}
    white, grey = (_matt_part(described, x) for x in (1.0, 0.5))
    share = grey / max(white, 1e-6)
    return white, min(max((1 - 2 * share) / (1 - share), 0.0), 0.999)


def _matt_part(described: dict[str, object], grey: float) -> float:
    plugin = mi.load_dict({**described, "diffuse_reflectance": {"type": "rgb", "value": [grey] * 3}})
    return float(hemispherical_reflectance(plugin, component=MATT).mean())
