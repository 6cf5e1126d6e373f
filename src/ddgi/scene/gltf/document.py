"""The container: JSON by itself (.gltf), or in a binary file with the bytes it speaks of (.glb).

glTF 2.0 specification, sections 3.2 (version), 3.12 (extensions) and 4 (GLB).
"""

from __future__ import annotations

import json
import re
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ddgi.errors import SceneError
from ddgi.scene.gltf.references import check_references
from ddgi.scene.gltf.schema import Document

MAGIC, JSON_CHUNK, BINARY_CHUNK = b"glTF", 0x4E4F534A, 0x004E4942
HEADER, CHUNK_HEADER = struct.Struct("<4sII"), struct.Struct("<II")

UNDERSTOOD = frozenset(
    {
        "EXT_mesh_gpu_instancing",
        "EXT_meshopt_compression",
        "KHR_draco_mesh_compression",
        "KHR_lights_punctual",
        "KHR_materials_emissive_strength",
        "KHR_materials_ior",
        "KHR_materials_pbrSpecularGlossiness",
        "KHR_materials_specular",
        "KHR_materials_transmission",
        "KHR_materials_unlit",
        "KHR_materials_volume",
        "KHR_mesh_quantization",
        "KHR_node_visibility",
        "KHR_texture_transform",
    }
)
"""Extensions that are read."""
REFINEMENTS = frozenset(
    {
        "KHR_animation_pointer",
        "KHR_materials_anisotropy",
        "KHR_materials_clearcoat",
        "KHR_materials_diffuse_transmission",
        "KHR_materials_dispersion",
        "KHR_materials_iridescence",
        "KHR_materials_sheen",
        "KHR_materials_variants",
        "KHR_xmp_json_ld",
    }
)
"""Extensions without which the picture is still the right one, only plainer: required ones too."""


@dataclass(frozen=True)
class Container:
    """A file taken apart."""

    path: Path
    document: Document
    binary: bytes | None  # the GLB's own bytes, which its first buffer may mean


def read_container(path: Path) -> Container:
    """Read a .gltf or .glb; its first bytes say which.

    Raises:
        SceneError: It is not one, or needs an extension that this package does not have.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise SceneError(f"cannot be read: {error.strerror}") from error
    text, binary = _chunks(data) if data[:4] == MAGIC or path.suffix.lower() == ".glb" else (data, None)
    document = _document(_parsed(text))
    check_references(document)
    return Container(path, document, binary)


def _chunks(data: bytes) -> tuple[bytes, bytes | None]:
    """JSON and binary chunk of a GLB; unknown chunks after them are skipped."""
    if len(data) < HEADER.size or data[:4] != MAGIC:
        raise SceneError("not a GLB file: it must begin with a header of 12 bytes and the letters glTF")
    _, version, length = HEADER.unpack_from(data)
    if version != 2:
        raise SceneError(f"GLB of version {version}; this package reads version 2")
    if length > len(data):
        raise SceneError(f"the file is cut short: its header says {length} bytes, but there are {len(data)}")
    found: list[tuple[int, bytes]] = []
    start = HEADER.size
    while start < length:
        if start + CHUNK_HEADER.size > length:
            raise SceneError(f"the header of chunk {len(found)} is cut short")
        size, kind = CHUNK_HEADER.unpack_from(data, start)
        start += CHUNK_HEADER.size
        if start + size > length:
            raise SceneError(f"chunk {len(found)} of {size} bytes reaches beyond the end of the file")
        found.append((kind, data[start : start + size]))
        start += size
    if not found or found[0][0] != JSON_CHUNK:
        raise SceneError("the first chunk must be JSON")
    if any(kind == JSON_CHUNK for kind, _ in found[1:]):
        raise SceneError("there is more than one JSON chunk")
    binary = found[1][1] if len(found) > 1 and found[1][0] == BINARY_CHUNK else None
    return found[0][1], binary


def _parsed(text: bytes) -> dict[str, Any]:
    if not text.strip(b" \t\r\n\0"):
        raise SceneError("the file holds no JSON")
    try:
        content = json.loads(text.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise SceneError(f"not a glTF file: byte {error.start} is not UTF-8 text") from error
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, column {error.colno}"
        raise SceneError(f"not valid JSON: {error.msg} at {place}") from error
    except (ValueError, RecursionError) as error:  # numbers of thousands of digits, thousands of brackets
        raise SceneError(f"not usable JSON: {str(error).splitlines()[0]}") from error
    if not isinstance(content, dict):
        raise SceneError("not a glTF file: its JSON is not an object")
    return content


def _document(content: dict[str, Any]) -> Document:
    _check_version(content.get("asset"))
    _check_extensions(content.get("extensionsRequired", []))
    try:
        return Document.model_validate(content)
    except (ValidationError, RecursionError) as error:
        raise SceneError(_first_mistake(error)) from error


def _check_version(asset: Any) -> None:
    if not isinstance(asset, dict):
        raise SceneError("not a glTF file: its asset, which says the version, is missing")
    version = asset.get("minVersion", asset.get("version"))
    if not isinstance(version, str) or not re.fullmatch(r"[0-9]+\.[0-9]+", version):
        raise SceneError(f"asset.version must be a text such as 2.0, not {version!r}")
    newer = "minVersion" in asset and version != "2.0"
    if version.split(".")[0] != "2" or newer:
        raise SceneError(f"glTF {version}; this package reads glTF 2.0")


def _check_extensions(required: Any) -> None:
    """Refuse a file that says of itself that it cannot be shown without what is not here."""
    if not isinstance(required, list):
        raise SceneError("extensionsRequired must be a list")
    unknown = [str(name) for name in required if str(name) not in UNDERSTOOD | REFINEMENTS]
    if unknown:
        raise SceneError(f"needs the extension {', '.join(unknown)}, which this package does not have")


def _first_mistake(error: ValidationError | RecursionError) -> str:
    if isinstance(error, RecursionError):
        return "its JSON is nested too deeply"
    first = error.errors(include_url=False)[0]
    place = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in first["loc"])
    return f"{place.lstrip('.')}: {first['msg']}" if place else first["msg"]
