"""Where a scene comes from: a built-in name, a glTF, OBJ, PLY or Mitsuba file, or a Mitsuba dictionary."""

from __future__ import annotations

import gc
import os
from collections.abc import Sequence
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ddgi.backend import use_backend
from ddgi.errors import SceneError, SettingsError
from ddgi.scene.added import Added
from ddgi.scene.camera import Camera, look_at, with_size
from ddgi.scene.daylight import AddedLights
from ddgi.scene.scene import Scene

if TYPE_CHECKING:  # it needs no variant, but what it is used with does
    from ddgi.scene.ceiling import Height
    from ddgi.scene.notes import Notes
    from ddgi.scene.rig import Rig

MATERIALS = ("full", "diffuse")
GLTF = (".glb", ".gltf")
KINDS = (*GLTF, ".obj", ".ply", ".xml")
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def load_scene(
    source: str | Path | dict[str, Any],
    *,
    camera: str | int | Camera | None = None,
    look: Sequence[float] | None = None,
    size: tuple[int, int] | None = None,
    up: str | Sequence[float] | None = None,
    sun: tuple[float, float, float] | None = None,
    sky: str | Sequence[float] | None = None,
    env: str | Path | None = None,
    lights: Sequence[dict[str, Any]] = (),
    ceiling: Height | None = None,
    clear: Sequence[str] = (),
    materials: str = "full",
    movable: Sequence[str] = (),
) -> Scene:
    """Load a scene.

    Args:
        source: The name of a built-in scene, the path of a glTF (`.glb`, `.gltf`), `.obj`, `.ply`
            or Mitsuba `.xml` file, or a dictionary as for `mi.load_dict`.
        camera: Name or number of the scene's camera to look through, or a camera of your own; by
            default the scene's first, or one that is chosen if it has none (`ddgi.scene.viewpoint`).
        look: Look from a point to a point instead, through the same lens: six numbers [m].
        size: (width, height) of pictures [pixels]; by default what the camera says.
        up: "x", "y", "z", with a minus sign to turn it around, or a vector; by default +y for
            built-in scenes and the axis nearest the camera's up for others.
        sun: Parallel light to add: azimuth and elevation [degrees], and irradiance facing it
            [W/m^2]. Azimuth runs from +z to +x where +y is up (`daylight.horizontal_axes`).
        sky: "sunsky" for a clear sky, with its own sun unless `sun` is given; or the RGB radiance
            [W/(m^2 sr)] of an even one. Takes the place of the scene's environment.
        env: An `.hdr` or `.exr` picture of the surroundings, latitude by longitude; likewise.
        lights: Point, spot and directional lights to add, each a dictionary as for `mi.load_dict`.
        ceiling: A white slab to add over the walls: the height of its lower face along `up` [m], or
            "auto" for the top of the walls.
        clear: Names of materials, or of shapes, that light is to pass straight, as if they were not
            there: opaque window panes. Capitals do not matter; lamps stay.
        materials: "full", or "diffuse" for a comparison: every surface is Lambertian with its albedo,
            gloss left out, and glass is gone, here and in the scene's `source`. Shapes handed
            over as Mitsuba objects keep their Lambertian BSDF afterwards.
        movable: Names of shapes that are to be able to move (`Scene.moved`, `Scene.bent`), or patterns
            such as "ball-*". What the animations of a glTF file move can always. Probes are placed as
            if these shapes were not there.

    Returns:
        The scene. A scene without any light gets a clear sky with its sun, and a note that says so.

    Raises:
        SceneError: The source does not exist or cannot be used; one line that names the element.
        BackendError: Nothing here can compute.
        SettingsError: The picture size is not positive, or `look` describes no camera.
    """
    if not isinstance(source, (str, Path, dict)):
        raise SceneError(f"a scene is a name, a path or a dictionary, not a {type(source).__name__}")
    if materials not in MATERIALS:
        raise SceneError(f"materials must be {' or '.join(MATERIALS)}, not {materials!r}")
    if isinstance(clear, str):
        raise SceneError(f"clear must be a list of names, not {clear!r}")
    use_backend()
    added = Added(AddedLights(sun, sky, env, tuple(lights)), ceiling, tuple(clear), tuple(movable))
    if isinstance(movable, str):
        raise SceneError(f"movable must be a list of names, not {movable!r}")
    scene = _imported(source, added, up, materials == "diffuse")
    scene = _seen(scene, camera, look, indoors=ceiling is not None)
    if size is not None:
        scene = replace(scene, cameras=tuple(with_size(c, size) for c in scene.cameras))
    # What the import left behind must not go away later: a change in Mitsuba's registry of objects
    # makes Dr.Jit record every frozen function anew.
    gc.collect()
    return scene


def _seen(
    scene: Scene, camera: str | int | Camera | None, look: Sequence[float] | None, *, indoors: bool
) -> Scene:
    """The scene with the camera to look through first; where it has none, one is chosen."""
    from ddgi.scene import viewpoint

    own = scene.cameras
    if isinstance(camera, Camera):
        scene = replace(scene, cameras=(camera, *own))
    elif not own:
        found = viewpoint.find(scene, indoors=indoors)
        scene = replace(scene, cameras=(found.camera,))
        if look is None:
            scene = replace(scene, notes=scene.notes + found.notes)
    if camera is not None and not isinstance(camera, Camera):
        scene = scene.select_camera(camera)
    if look is not None:
        scene = replace(scene, cameras=(_looking(scene, look), *(scene.cameras if own else ())))
    return scene


def _looking(scene: Scene, look: Sequence[float]) -> Camera:
    """A camera from a point to a point, with the lens and picture size of the scene's first."""
    if len(look) != 6:
        raise SettingsError(f"look must be six numbers, from and to, not {look}")
    own = scene.camera
    half = np.linalg.norm(np.ravel(own.right))
    fov = 60.0 if own.orthographic else float(np.degrees(2 * np.arctan(half)))
    return look_at(look[:3], look[3:], scene.up, fov=fov, size=own.size, name="look")


def _imported(
    source: str | Path | dict[str, Any],
    added: Added,
    up: str | Sequence[float] | None,
    diffuse: bool,
) -> Scene:
    from ddgi.scene.mitsuba_scene import import_scene
    from ddgi.scene.plugin_tree import PluginTree, searching

    axis = None if up is None else _direction(up)
    if isinstance(source, dict):
        return import_scene(PluginTree.parse(source), "scene", added=added, up=axis, diffuse=diffuse)
    if (path := _file(source)) is None:
        return _built_in(str(source), added, axis, diffuse)
    if path.suffix.lower() in GLTF:
        return _gltf(path, added, axis, diffuse)
    if path.suffix.lower() == ".obj":
        return _obj(path, added, axis, diffuse)
    if path.suffix.lower() == ".ply":
        return _ply(path, added, axis, diffuse)
    try:
        with searching(path.parent):
            return import_scene(PluginTree.parse(path), _name(path), added=added, up=axis, diffuse=diffuse)
    except SceneError as error:
        if path.name in str(error):  # elements have their place in the file
            raise
        raise SceneError(f"{path}: {error}") from error


def _gltf(path: Path, added: Added, up: np.ndarray | None, diffuse: bool) -> Scene:
    from ddgi.scene.gltf.description import read_gltf
    from ddgi.scene.notes import Notes
    from ddgi.scene.play import moving_shapes

    notes = Notes()
    read = read_gltf(path, notes)
    scene = _described(
        path, read.description, notes, added, up, diffuse, read.origin, read.called,
        moving_shapes(read.rig),
    )  # fmt: skip
    return _rigged(scene, read.rig)


def _rigged(scene: Scene, rig: Rig) -> Scene:
    """The scene with what its animations need."""
    from ddgi.scene.play import Player

    assert scene.motion is not None
    player = Player(rig, scene.origin) if rig.clips else None
    return replace(scene, rig=rig, motion=replace(scene.motion, player=player))


def _obj(path: Path, added: Added, up: np.ndarray | None, diffuse: bool) -> Scene:
    from ddgi.scene.notes import Notes
    from ddgi.scene.obj.description import read_obj

    notes = Notes()
    description, origin = read_obj(path, notes)
    return _described(path, description, notes, added, up, diffuse, origin)


def _ply(path: Path, added: Added, up: np.ndarray | None, diffuse: bool) -> Scene:
    from ddgi.scene.notes import Notes
    from ddgi.scene.ply.description import read_ply

    notes = Notes()
    description, origin = read_ply(path, notes)
    return _described(path, description, notes, added, up, diffuse, origin)


def _described(
    path: Path,
    description: dict[str, Any],
    notes: Notes,
    added: Added,
    up: np.ndarray | None,
    diffuse: bool,
    origin: np.ndarray | None,
    called: dict[str, str] | None = None,
    animated: frozenset[str] = frozenset(),
) -> Scene:
    """The scene that a description made of a file stands for; +y is up unless the caller says.

    `origin`: see `import_scene`; `called`: see `PluginTree`.
    """
    from ddgi.scene.mitsuba_scene import import_scene
    from ddgi.scene.plugin_tree import PluginTree

    up = np.array(AXES["y"]) if up is None else up
    try:
        tree = PluginTree.parse(description)
        tree.called = called or {}
        return import_scene(
            tree,
            _name(path),
            added=added,
            up=up,
            diffuse=diffuse,
            notes=notes,
            origin=origin,
            animated=animated,
        )
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from error


def _built_in(name: str, added: Added, up: np.ndarray | None, diffuse: bool) -> Scene:
    from ddgi.scene.library import BUILT_IN
    from ddgi.scene.mitsuba_scene import import_scene
    from ddgi.scene.play import moving_shapes
    from ddgi.scene.plugin_tree import PluginTree

    if name not in BUILT_IN:
        close = get_close_matches(name, BUILT_IN, n=1)
        meant = f"did you mean {close[0]}? Else " if close else ""
        raise SceneError(
            f"no scene {name!r}: {meant}give a .glb, .gltf, .obj, .ply or .xml file, or one of {', '.join(sorted(BUILT_IN))}"
        )
    blueprint = BUILT_IN[name].build()
    tree = PluginTree.parse(blueprint.description)
    up = np.array(AXES["y"]) if up is None else up
    animated = moving_shapes(blueprint.rig) if blueprint.rig is not None else frozenset()
    scene = import_scene(
        tree, name, added=added, up=up, box=blueprint.box, diffuse=diffuse, animated=animated
    )
    return scene if blueprint.rig is None else _rigged(scene, blueprint.rig)


def _file(source: str | Path) -> Path | None:
    """The file that `source` means; None if it is a bare name."""
    path = Path(source)
    bare = isinstance(source, str) and path.name == source and not path.suffix
    if bare and not path.exists():
        return None
    if path.is_dir():
        raise SceneError(f"{path} is a folder: give the scene file in it")
    if not path.exists():
        raise SceneError(f"{path}: file not found")
    if path.suffix.lower() not in KINDS:
        raise SceneError(f"{path}: unknown kind of scene file {path.suffix!r}, expected {', '.join(KINDS)}")
    if path.stat().st_size == 0:
        raise SceneError(f"{path}: the file is empty")
    if not os.access(path, os.R_OK):
        raise SceneError(f"{path}: cannot be read: permission denied")
    return path


def _name(path: Path) -> str:
    """A file's name, or its folder's where the file is called "scene" like all of them."""
    return path.resolve().parent.name if path.stem.startswith("scene") else path.stem


def _direction(up: str | Sequence[float]) -> np.ndarray:
    """(3,) unit vector."""
    if isinstance(up, str):
        sign, name = (-1.0 if up.startswith("-") else 1.0), up.lstrip("+-")
        if name not in AXES:
            raise SceneError(f"up must be x, y or z, with a sign if you like, not {up!r}")
        return sign * np.array(AXES[name])
    vector = np.asarray(up, np.float64)
    if vector.shape != (3,) or not np.isfinite(vector).all() or not np.linalg.norm(vector) > 0:
        raise SceneError(f"up must be three numbers, not all zero, not {up}")
    return vector / np.linalg.norm(vector)
