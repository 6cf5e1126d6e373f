"""Dynamic diffuse global illumination: scenes lit by ray-traced irradiance probes.

Names are imported on first use, so that `import ddgi` and `ddgi --help` stay fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ddgi.backend import point_to_llvm

if TYPE_CHECKING:
    from ddgi.backend import use_backend
    from ddgi.errors import BackendError, DDGIError, OutputError, SceneError, SettingsError
    from ddgi.frame import Frame, render_frame
    from ddgi.output import save
    from ddgi.probes.field import IrradianceField
    from ddgi.scene.camera import Camera, look_at
    from ddgi.scene.load import load_scene
    from ddgi.scene.scene import Scene
    from ddgi.settings import PRESETS, RenderSettings

__version__ = "0.1.0"

__all__ = [
    "PRESETS",
    "BackendError",
    "Camera",
    "DDGIError",
    "Frame",
    "IrradianceField",
    "OutputError",
    "RenderSettings",
    "Scene",
    "SceneError",
    "SettingsError",
    "__version__",
    "load_scene",
    "look_at",
    "render_frame",
    "save",
    "use_backend",
]

_HOMES = {
    "PRESETS": "ddgi.settings",
    "BackendError": "ddgi.errors",
    "Camera": "ddgi.scene.camera",
    "DDGIError": "ddgi.errors",
    "Frame": "ddgi.frame",
    "IrradianceField": "ddgi.probes.field",
    "OutputError": "ddgi.errors",
    "RenderSettings": "ddgi.settings",
    "Scene": "ddgi.scene.scene",
    "SceneError": "ddgi.errors",
    "SettingsError": "ddgi.errors",
    "load_scene": "ddgi.scene.load",
    "look_at": "ddgi.scene.camera",
    "render_frame": "ddgi.frame",
    "save": "ddgi.output",
    "use_backend": "ddgi.backend",
}
"""Where each public name lives."""


point_to_llvm()


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module 'ddgi' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
