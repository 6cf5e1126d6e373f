"""A PLY file to the dictionary that Mitsuba's parser takes: geometry through Mitsuba's own reader.

The format has no materials: surfaces are matt, grey or of the vertices' colours, and two-sided.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ddgi.errors import SceneError
from ddgi.scene.mesh_keys import COLOR_ATTRIBUTE

GREY = 0.5
COLOR_PROPERTIES = (("r", "g", "b"), ("red", "green", "blue"))
BRIGHTEST = {"uchar": 255, "uint8": 255, "ushort": 65535, "uint16": 65535}
"""What stands for 1, by a property's type."""
LONGEST_HEADER = 1 << 16


def read_ply(path: Path) -> dict[str, Any]:
    """Describe a .ply file.

    Raises:
        SceneError: It is none.
    """
    types = _vertex_properties(path)
    names = next((names for names in COLOR_PROPERTIES if set(names) <= set(types)), None)
    color: dict[str, Any] = {"type": "rgb", "value": GREY}
    if names is not None:
        # Mitsuba takes whole numbers as they are: 255 would reflect 255 times the light.
        scale = 1 / BRIGHTEST.get(types[names[0]], 1)
        color = {"type": "mesh_attribute", "name": COLOR_ATTRIBUTE, "scale": scale}
    bsdf = {"type": "twosided", "nested": {"type": "diffuse", "reflectance": color}}
    return {
        "type": "scene",
        "_shape-0": {"type": "ply", "id": path.stem, "filename": str(path.resolve()), "bsdf": bsdf},
    }


def _vertex_properties(path: Path) -> dict[str, str]:
    """Types of the properties of vertices, by name."""
    with path.open("rb") as file:
        header, end, _ = file.read(LONGEST_HEADER).partition(b"end_header")
    if not header.startswith(b"ply") or not end:
        raise SceneError(f"{path}: is not a PLY file")
    types: dict[str, str] = {}
    element = ""
    for line in header.decode("ascii", errors="replace").splitlines():
        parts = line.split()
        if parts[:1] == ["element"] and len(parts) > 1:
            element = parts[1]
        elif parts[:1] == ["property"] and element == "vertex" and len(parts) > 2:
            types[parts[-1]] = parts[1]
    return types
