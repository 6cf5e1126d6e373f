"""Every invalid file of ../shared/scenes/gltf-invalid: refused, or loaded although Khronos' validator objects.

    python benchmarks/invalid_gltf.py            # into docs/results/invalid.json

Many of them hold meshes, pictures and lights that no scene shows, and which nobody would read. So each is
loaded as it is, then all its data is read, and then it is loaded with everything shown. Limits are those
of `contained.py`.
"""

from __future__ import annotations

import base64
import copy
import json
import shutil
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click

from contained import Outcome, outcome, outcomes
from fuzz_seeds import TESTS, taken_apart
from gltf_writing import CORNERS, SQUARE, SQUARE_UV, Writer, glb_bytes
from studies import FILES, RESULTS, machine

INVALID = FILES / "gltf-invalid"
HARMLESS = {
    "an empty list, or object, says nothing": "EMPTY_ENTITY",
    "bounds are not read: they are measured": (
        "ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND ACCESSOR_ELEMENT_OUT_OF_MIN_BOUND ACCESSOR_MAX_MISMATCH "
        "ACCESSOR_MIN_MISMATCH ANIMATION_SAMPLER_INPUT_ACCESSOR_WITHOUT_BOUNDS "
        "MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS"
    ),
    "not read, here or at all: hints, offsets and limits without effect, parts without a use": (
        "ACCESSOR_NORMALIZED_INVALID BUFFER_VIEW_INVALID_BYTE_STRIDE BUFFER_VIEW_TOO_BIG_BYTE_STRIDE "
        "CAMERA_ZFAR_LEQUAL_ZNEAR MESH_PRIMITIVE_INVALID_ATTRIBUTE MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY "
        "MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR ONE_OF_MISMATCH "
        "SKIN_NO_COMMON_ROOT SKIN_SKELETON_INVALID UNSATISFIED_DEPENDENCY VALUE_MULTIPLE_OF"
    ),
    "made right: clamped, normalised, or one of two that say the same is taken": (
        "ACCESSOR_NON_CLAMPED ACCESSOR_VECTOR3_NON_UNIT ACCESSOR_INVALID_SIGN NODE_MATRIX_TRS ROTATION_NON_UNIT"
    ),
    "a joint that exists is named twice; one that does not, and bad weights, are refused where a skin uses them": (
        "ACCESSOR_JOINTS_INDEX_DUPLICATE ACCESSOR_JOINTS_INDEX_OOB ACCESSOR_WEIGHTS_NEGATIVE "
        "ACCESSOR_WEIGHTS_NON_NORMALIZED"
    ),
    "vertex 255 of 256 exists, whatever else its number means to some hardware": "ACCESSOR_INDEX_PRIMITIVE_RESTART",
    "whole numbers of 32 bits are read like those of 16": "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT",
    "meshes morph by the targets they have": "MESH_PRIMITIVES_UNEQUAL_TARGETS_COUNT",
    "a note: the picture shows one colour": "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS",
    "nothing needs tangents": "MESH_PRIMITIVE_NO_TANGENT_SPACE",
    "animations are kept, not played; channels that cannot be are left out with a note": (
        "ACCESSOR_ANIMATION_INPUT_NEGATIVE ACCESSOR_ANIMATION_INPUT_NON_INCREASING "
        "ACCESSOR_ANIMATION_SAMPLER_OUTPUT_NON_NORMALIZED_QUATERNION ANIMATION_CHANNEL_TARGET_NODE_MATRIX "
        "ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS ANIMATION_DUPLICATE_TARGETS "
        "ANIMATION_SAMPLER_INPUT_ACCESSOR_INVALID_FORMAT ANIMATION_SAMPLER_INPUT_ACCESSOR_TOO_FEW_ELEMENTS "
        "KHR_ANIMATION_POINTER_ANIMATION_CHANNEL_TARGET_NODE KHR_ANIMATION_POINTER_ANIMATION_CHANNEL_TARGET_PATH "
        "PATTERN_MISMATCH"
    ),
    "the bytes are there, and say themselves what they are": (
        "BUFFER_DATA_URI_MIME_TYPE_INVALID GLB_CHUNK_LENGTH_UNALIGNED GLB_DUPLICATE_CHUNK "
        "GLB_UNEXPECTED_BIN_CHUNK IMAGE_MIME_TYPE_INVALID INVALID_URI INVALID_JSON"
    ),
    "extensions that are not read, or stand where they mean nothing": (
        "DUPLICATE_ELEMENTS KHR_MATERIALS_VARIANTS_NON_UNIQUE_VARIANT NON_REQUIRED_EXTENSION TYPE_MISMATCH "
        "UNDECLARED_EXTENSION UNDEFINED_PROPERTY UNEXPECTED_EXTENSION_OBJECT UNRESOLVED_REFERENCE VALUE_NOT_IN_RANGE"
    ),
}
"""Why a file may load although the validator counts these as errors."""


@cache
def paths() -> list[Path]:
    """All of them."""
    return sorted(p for p in INVALID.rglob("*") if p.suffix in (".gltf", ".glb"))


def mistakes(path: Path) -> list[str]:
    """What the validator's report beside a file counts as errors; none without a report."""
    report = path.with_name(path.name + ".report.json")
    if not report.exists():
        return []
    messages = json.loads(report.read_text())["issues"]["messages"]
    return sorted({message["code"] for message in messages if message["severity"] == 0})


# Everything in a file shown ------------------------------------------------------------------------------


def shown(path: Path, folder: Path) -> Path:
    """A copy of a file that loads, showing all it has, in a folder with the files that it names."""
    data = path.read_bytes()
    document, binary = (
        taken_apart(data) if path.suffix == ".glb" else (json.loads(data.decode("utf-8-sig")), b"")
    )
    copied = folder / f"shown-{path.name}"
    text = json.dumps(_with_all_shown(document)).encode()
    for beside in path.parent.iterdir():
        if beside.name.encode() in text:
            shutil.copy(beside, folder)
    copied.write_bytes(glb_bytes(text, binary) if path.suffix == ".glb" else text)
    return copied


@dataclass
class _Document:
    """JSON that may be of any shape, to which elements are added."""

    json: dict[str, Any]

    def count(self, name: str) -> int:
        """Elements of a list that may be missing, or none."""
        found = self.json.get(name)
        return len(found) if isinstance(found, list) else 0

    def add(self, name: str, element: dict[str, Any]) -> int:
        """An element's number in its list."""
        if not self.count(name):
            self.json[name] = []
        self.json[name].append(element)
        return len(self.json[name]) - 1


def _with_all_shown(document: dict[str, Any]) -> dict[str, Any]:
    """A node for every mesh, camera and light; a square for every material."""
    made = _Document(copy.deepcopy(document))
    if made.count("materials"):
        square = _square(made)
        for number in range(made.count("materials")):
            made.add("meshes", {"primitives": [square | {"material": number}]})
    extensions = made.json.get("extensions")
    punctual = extensions.get("KHR_lights_punctual") if isinstance(extensions, dict) else None
    lights = _Document(punctual).count("lights") if isinstance(punctual, dict) else 0
    nodes = [made.add("nodes", {"mesh": number}) for number in range(made.count("meshes"))]
    nodes += [made.add("nodes", {"camera": number}) for number in range(made.count("cameras"))]
    for number in range(lights):
        nodes.append(made.add("nodes", {"extensions": {"KHR_lights_punctual": {"light": number}}}))
    for number in range(made.count("scenes")):
        scene = made.json["scenes"][number]
        if isinstance(scene, dict) and nodes:
            scene["nodes"] = [*(scene.get("nodes") or []), *nodes]
    return made.json


def _square(made: _Document) -> dict[str, Any]:
    """A primitive out of a buffer of its own."""
    writer = Writer()
    arrays = writer.accessor(SQUARE), writer.accessor(SQUARE_UV), writer.accessor(CORNERS, "u2")
    uri = "data:application/octet-stream;base64," + base64.b64encode(writer.data).decode()
    buffer = made.add("buffers", {"uri": uri, "byteLength": len(writer.data)})
    numbers = []
    for array in arrays:
        spec = writer.json["accessors"][array]
        view = made.add("bufferViews", writer.json["bufferViews"][spec["bufferView"]] | {"buffer": buffer})
        numbers.append(made.add("accessors", spec | {"bufferView": view}))
    positions, texcoords, corners = numbers
    return {"attributes": {"POSITION": positions, "TEXCOORD_0": texcoords}, "indices": corners}


# All of them ---------------------------------------------------------------------------------------------


def strict_outcome(path: Path) -> Outcome:
    """What becomes of a file if nothing in it may be bad, be it shown or not."""
    found = outcome(path)
    if found.what == "loaded":
        found = outcome(path, _read_all)
    if found.what == "loaded":
        with TemporaryDirectory() as folder:
            found = outcome(shown(path, Path(folder)))
    return found


def _read_all(path: Path) -> None:
    from ddgi.scene.gltf.accessors import Accessors
    from ddgi.scene.gltf.buffers import Views
    from ddgi.scene.gltf.document import read_container
    from ddgi.scene.gltf.images import Images
    from ddgi.scene.notes import Notes

    container = read_container(path)
    document, views = container.document, Views(container)
    accessors, images = Accessors(document, views), Images(container, views, Notes())
    for number, image in enumerate(document.images):
        if image.uri is not None or image.buffer_view is not None:
            images.texels(number)
    for number in range(len(document.buffers)):
        views.buffer(number)
    for number in range(len(document.buffer_views)):
        views.content(number)
    for number in range(len(document.accessors)):
        accessors.converted(number, accessors.raw(number))


def _load(number: int) -> Outcome:
    return strict_outcome(paths()[number])


def _warm_up() -> None:
    for path in sorted((TESTS / "scene" / "gltf" / "encodings").glob("*.glb")):
        strict_outcome(path)


def meaningless(path: Path) -> list[str]:
    """The mistakes of a file that it must not load with."""
    return [code for code in mistakes(path) if not any(code in codes.split() for codes in HARMLESS.values())]


@click.command()
def main() -> None:
    """Load all; exit code 1 if one loads that should not, or fails in any other way than by being refused."""
    loaded: dict[str, list[str]] = {why: [] for why in HARMLESS}
    seconds = megabytes = 0.0
    wrong = refused = 0
    for number, found in outcomes(_load, range(len(paths())), _warm_up):
        path = paths()[number]
        name = str(path.relative_to(INVALID))
        seconds, megabytes = max(seconds, found.seconds), max(megabytes, found.megabytes)
        if not mistakes(path):
            continue
        refused += found.what == "refused"
        if found.what == "failed" or (found.what == "loaded" and meaningless(path)):
            wrong += 1
            print(f"{name} {found.what}: {found.how} {', '.join(meaningless(path))}", flush=True)
        elif found.what == "loaded":
            for why, codes in HARMLESS.items():
                if any(code in codes.split() for code in mistakes(path)):
                    loaded[why].append(name)
    row = {
        "files": len(paths()), "with_mistakes": sum(bool(mistakes(path)) for path in paths()), "refused": refused,
        "wrong": wrong, "seconds": round(seconds, 2), "megabytes": round(megabytes),
    }  # fmt: skip
    print(json.dumps(row))
    text = json.dumps({"machine": machine(), "rows": [row], "loaded": loaded}, indent=1)
    (RESULTS / "invalid.json").write_text(text + "\n")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
