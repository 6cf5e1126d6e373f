"""Libraries that only some files need: imported when one does, and asked for by name where missing."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from ddgi.errors import SceneError


def require(module: str, extension: str) -> ModuleType:
    """Import the library that decodes an extension.

    Raises:
        SceneError: It is not installed; says how to get it.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise SceneError(
            f"{extension} needs the library {module}: pip install 'ddgi[gltf]' (or {module})"
        ) from error
