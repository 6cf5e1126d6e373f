"""A digest of everything that shapes a path-traced picture of a scene, but for the camera.

Equal in every process for the same scene; other light, geometry, materials or files on disk change it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from ddgi.scene.scene import Scene

OURS = ("sensor", "film", "sampler", "integrator", "rfilter")
"""Kinds of plugins that are not part of what there is to see."""


def fingerprint(scene: Scene) -> str:
    """64 hexadecimal digits."""
    digest = hashlib.sha256()
    for node in scene.source.nodes:
        if str(node.type).rsplit(".", 1)[-1].lower() not in OURS:
            for part in _node(node):
                digest.update(part)
    return digest.hexdigest()


def _node(node: Any) -> Iterator[bytes]:
    """A plugin's name and properties, in order."""
    properties, kinds = node.props, mi.Properties.Type
    yield f"\n{properties.plugin_name()} {properties.id()}".encode()
    for key in properties.keys():  # noqa: SIM118, not a dict
        yield f"\n{key}=".encode()
        value = properties[key]
        if properties.type(key) == kinds.ResolvedReference:
            yield str(value.index()).encode()
        elif properties.type(key) == kinds.String and key == "filename":
            yield _file(value)
        else:
            yield from _value(value)


def _file(name: str) -> bytes:
    """A file on disk, by its place, size and time of change."""
    path = Path(str(mi.file_resolver().resolve(name)))
    if not path.is_file():
        return name.encode()
    status = path.stat()
    return f"{path.resolve()} {status.st_size} {status.st_mtime_ns}".encode()


def _value(value: Any) -> Iterator[bytes]:
    """Anything that a property holds."""
    if isinstance(value, mi.Object) and not isinstance(value, mi.Bitmap):
        yield value.class_name().encode()
        parameters = mi.traverse(value)
        for name in sorted(parameters.keys()):
            yield f"\n{name}:".encode()
            yield from _value(parameters[name])
    elif isinstance(value, mi.Bitmap) or dr.is_array_v(value):
        yield np.array(value).tobytes()
    elif hasattr(value, "matrix"):  # a transform
        yield np.array(value.matrix, np.float64).tobytes()
    else:
        yield repr(value).encode()
