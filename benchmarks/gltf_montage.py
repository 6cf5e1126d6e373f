"""Every file of ../shared/scenes/gltf-features in one picture: docs/pictures/gltf-features.png.

    python benchmarks/gltf_montage.py            # all, into docs/pictures
    python benchmarks/gltf_montage.py Texture -o /tmp/textures.png --size 640x480

Files without light of their own get three parallel lights and a dim sky. What shows no triangle has no tile.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click
import numpy as np

import ddgi
from ddgi.config import load_settings
from ddgi.errors import SceneError
from ddgi.judge.sheet import Tile, laid_out
from ddgi.output import save_display
from ddgi.passes.tone import tone_map
from ddgi.scene.camera import Camera, look_at
from ddgi.still import still
from studies import FILES, PICTURES

FEATURES = FILES / "gltf-features"
COLUMNS = 7
FRONT, ABOVE = (0.25, 0.3, 1.0), (0.2, 1.0, 0.55)
"""Towards the viewer, by default and for what lies flat."""
DIRECTIONS = {
    "AlphaBlendModeTest": (0, 0, 1), "TextureSettingsTest": (0, 0, 1), "TextureTransformTest": (0, 0, 1),
    "TextureCoordinateTest": (0, 0, 1), "OrientationTest": (0.5, 0.6, 1), "22_vertex_color": (0.2, -1, 0.5),
}  # fmt: skip
OWN_LIGHT = ("14_emission_strength",)
SETTINGS = ("grid.budget=300", "rays.per_probe=32", "direct.environment=sampled", "tone.curve=linear")
FIELD_OF_VIEW = 40.0
SKY = (0.2, 0.2, 0.2)
LIGHTS = tuple(
    {"type": "directional", "direction": towards, "irradiance": {"type": "rgb", "value": strength}}
    for towards, strength in (((-0.5, -1, -0.8), 1.5), ((1, -0.3, -0.6), 0.7), ((0.2, 1, -0.5), 0.5))
)
"""From above, from the side, and a weak one from below."""


def framed(scene: ddgi.Scene, name: str, size: tuple[int, int]) -> Camera:
    """A camera that sees all of a scene's box."""
    box = scene.mi_scene.bbox()
    low, high = np.array(box.min).ravel(), np.array(box.max).ravel()
    extent, middle = high - low, (low + high) / 2
    lies = extent[1] < 0.1 * max(extent[0], extent[2])
    towards = np.array(DIRECTIONS.get(name, ABOVE if lies else FRONT), float)
    towards /= np.linalg.norm(towards)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * extent / 2
    across = np.cross([0, 1, 0], towards)
    across /= np.linalg.norm(across)
    slope = np.tan(np.radians(FIELD_OF_VIEW) / 2)
    distance = 0.0
    for axis, half in ((across, slope), (np.cross(towards, across), slope * size[1] / size[0])):
        distance = max(distance, float((np.abs(corners @ axis) / half + corners @ towards).max()))
    return look_at(middle + 1.04 * distance * towards, middle, fov=FIELD_OF_VIEW, size=size)


def tile(path: Path, size: tuple[int, int], frames: int) -> Tile | None:
    """A file's picture; None without triangles."""
    own = path.stem in OWN_LIGHT
    try:
        scene = ddgi.load_scene(path) if own else ddgi.load_scene(path, sky=SKY, lights=LIGHTS)
    except SceneError as error:
        print(path.stem, error, sep=": ", flush=True)
        return None
    scene = replace(scene, cameras=(framed(scene, path.stem, size),))
    settings = load_settings("default", None, (*SETTINGS, "tone.exposure=-1" if own else "tone.exposure=0.5"))
    frame = still(scene, settings, frames, lambda: None).frame
    print(path.stem, *scene.notes, sep="\n    ", flush=True)
    return Tile(path.stem, np.rint(tone_map(frame.numpy(), settings.tone) * 255).astype(np.uint8))


@click.command()
@click.argument("part", default="")
@click.option("-o", "output", default=str(PICTURES / "gltf-features.png"))
@click.option("--size", default="200x150")
@click.option("--frames", default=16)
def main(part: str, output: str, size: str, frames: int) -> None:
    """Draw the files whose path has PART in it."""
    width, height = map(int, size.split("x"))
    paths = sorted((p for p in FEATURES.rglob("*.gl*") if part in str(p)), key=lambda p: p.stem.lower())
    found = (tile(path, (width, height), frames) for path in paths if path.suffix in (".gltf", ".glb"))
    tiles = [made for made in found if made is not None]
    rows = [tiles[start : start + COLUMNS] for start in range(0, len(tiles), COLUMNS)]
    save_display(output, laid_out(rows, []))


if __name__ == "__main__":
    main()
