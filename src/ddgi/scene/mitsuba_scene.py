"""A parsed Mitsuba scene to ours: what is read, in which order, and what is left out."""

from __future__ import annotations

import fnmatch
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from ddgi.box import Box
from ddgi.errors import SceneError
from ddgi.plural import counted
from ddgi.scene.added import Added
from ddgi.scene.camera import Camera
from ddgi.scene.ceiling import Height, describe_ceiling
from ddgi.scene.clear import make_clear
from ddgi.scene.daylight import default_daylight
from ddgi.scene.emitters import EmitterReader, make_lights
from ddgi.scene.lambertian import make_lambertian
from ddgi.scene.materials import MaterialReader, material_table
from ddgi.scene.motion import Motion
from ddgi.scene.named_lights import name_lights
from ddgi.scene.no_surface import none_has_area
from ddgi.scene.notes import NO_LIGHT, Notes
from ddgi.scene.old_plugins import replace_old_plugins
from ddgi.scene.plugin_tree import PluginTree, one_line
from ddgi.scene.pose import Pose
from ddgi.scene.recentre import movable, move, note_origin, origin_for
from ddgi.scene.scene import Scene
from ddgi.scene.sensors import CAMERAS, read_camera, sensor_up
from ddgi.scene.shapes import Geometry, ShapeReader, Traced
from ddgi.scene.stage import Stage
from ddgi.scene.textures import TextureReader
from ddgi.scene.validate import check_bounds

ENVIRONMENTS = ("constant", "envmap", "sunsky", "timed_sunsky")
NAMED = 3
"""Names that a remark lists at most."""
CEILING = "added-ceiling"
OLD_FILTERS = ("trilinear", "ewa")
OURS = (
    mi.ObjectType.Integrator,
    mi.ObjectType.Sampler,
    mi.ObjectType.Film,
    mi.ObjectType.ReconstructionFilter,
)
FILM_KEYS = ("width", "height", "crop_width", "crop_height", "crop_offset_x", "crop_offset_y")


def import_scene(
    tree: PluginTree,
    name: str,
    *,
    added: Added,
    up: np.ndarray | None = None,
    box: Box | None = None,
    diffuse: bool = False,
    notes: Notes | None = None,
    origin: np.ndarray | None = None,
    animated: Collection[str] = (),
) -> Scene:
    """Build the scene that a plugin tree describes; without a camera if it names none.

    Args:
        tree: The parsed scene; what is added goes in, and film, sampler and integrator cleared.
        name: What to call it.
        added: What to add, and what to take out.
        up: (3,) unit vector; by default the axis nearest the first camera's up, or +y.
        box: What probes should cover [m], if the scene's maker says.
        diffuse: Make every surface Lambertian, in the tree as well.
        notes: What was changed or left out before.
        origin: (3,) what the tree counts from already, in the coordinates of its file; None: nothing
            was moved, and a scene that lies far from the origin will be, in the tree as well.
        animated: Names of shapes that an animation moves; those that were left out do not count.

    Raises:
        SceneError: An element cannot be used; the message names it.
    """
    notes = notes or Notes()
    tree.notes = notes
    replace_old_plugins(tree, notes)
    make_clear(tree, added.clear, notes)
    _clear_what_is_ours(tree, notes)
    moved = np.zeros(3) if origin is None else origin
    cameras, camera_up = _cameras(tree, notes, moved)
    if up is None:
        up = nearest_axis(camera_up) if camera_up is not None else np.array([0.0, 1.0, 0.0])
    if added.lights.has_environment:
        _drop_environment(tree, notes)
    if added.lights:
        move(tree, tree.graft(added.lights.description(up), "added to the scene"), moved)

    shapes, emitters = _read(tree, name, notes)
    if origin is None and (moved := _moved(tree, shapes.geometry, notes)).any():
        unheard = Notes()  # all was said the first time
        cameras, _ = _cameras(tree, unheard, moved)
        shapes, emitters = _read(tree, name, unheard)
    if added.ceiling is not None:
        _add_ceiling(tree, shapes, added.ceiling, up, moved, name, notes)
    geometry = shapes.geometry
    if diffuse:
        geometry = make_lambertian(tree, geometry)
        notes.add("every surface taken as diffuse, in the path-traced picture as well")
    if not (geometry.area_lights or emitters.delta or emitters.environment):
        notes.add(NO_LIGHT)
        for index in tree.graft(default_daylight().description(up), "added for want of light"):
            emitters.add(tree.build(index))

    still, movers = _parted(geometry, added.movable, animated)
    mi_scene = _assembled(still, emitters.environment)
    stage = Stage(movers, geometry.names) if movers else None
    _check_bounds(_around(mi_scene, stage), moved, name)
    note_origin(moved, notes)
    lights = make_lights(emitters.delta, geometry.area_lights, mi_scene.environment())
    named = name_lights(emitters, geometry)
    return Scene(
        name=name,
        mi_scene=mi_scene,
        materials=material_table(geometry.rows),
        lights=lights,
        cameras=tuple(cameras),
        up=_point(up),
        box=box,
        triangles=geometry.triangles,
        shapes=geometry.names,
        named_lights=named,
        notes=notes.lines(),
        parsed=tree.state,
        motion=Motion(stage, lights, {c.name: c for c in cameras}, _nodes(tree, movers, geometry, emitters)),
        origin=_point(moved),
    )


def _parted(
    geometry: Geometry, movable: Sequence[str], animated: Collection[str]
) -> tuple[list[Traced], list[Traced]]:
    """The shapes that stay, and those that can move: named by the user, by name or pattern, or by an animation.

    Raises:
        SceneError: The user names no shape that there is.
    """
    names = [name for name, _ in geometry.traced]
    moving = set(animated)
    for wanted in movable:
        found = {wanted} & set(names) or set(fnmatch.filter(names, wanted))
        if not found:
            raise SceneError(f"movable: no shape called {wanted!r}: there are {', '.join(names)}")
        moving |= found
    still = [shape for shape in geometry.traced if shape[0] not in moving]
    return still, [shape for shape in geometry.traced if shape[0] in moving]


def _nodes(
    tree: PluginTree, movers: Sequence[Traced], geometry: Geometry, emitters: EmitterReader
) -> dict[str, int | str]:
    """Where in the tree the things are that can move, by name: plugins by number, objects by key."""
    found: dict[str, int | str] = {
        light.name: light.node for light in emitters.delta if light.node is not None
    }
    objects = {id(child): key for key, child in tree.children(0) if not isinstance(child, int)}
    for name, _ in movers:
        owner = geometry.owners.get(geometry.names.get(name, -1))
        if isinstance(owner, int):
            found[name] = owner
        elif id(owner) in objects:
            found[name] = objects[id(owner)]
    return found


def _around(scene: mi.Scene, stage: Stage | None) -> np.ndarray:
    """(2, 3) low and high corner around all geometry, at rest."""
    box = scene.bbox()
    low, high = np.ravel(box.min), np.ravel(box.max)
    if stage is not None:
        moving = stage.box(Pose())
        low, high = np.fmin(low, moving[0]), np.fmax(high, moving[1])
    return np.stack([low, high])


def _moved(tree: PluginTree, geometry: Geometry, notes: Notes) -> np.ndarray:
    """(3,) the origin that the tree counts from now: another one where the scene was far from it."""
    boxes = [shape.bbox() for _, shape in geometry.traced if shape.class_name() != "ShapeGroupPlugin"]
    if not boxes:
        return np.zeros(3)  # it is refused later
    low = np.min([np.ravel(box.min) for box in boxes], 0)
    high = np.max([np.ravel(box.max) for box in boxes], 0)
    origin = origin_for(low, high)
    if origin.any() and not movable(tree):
        notes.add("far from the origin, and not moved, as some of it came as objects: it is inexact")
        return np.zeros(3)
    if origin.any():
        move(tree, (child for _, child in tree.children(0) if isinstance(child, int)), origin)
        tree.forget(mi.ObjectType.Shape, mi.ObjectType.Emitter, mi.ObjectType.Sensor)
    return origin


def _read(tree: PluginTree, name: str, notes: Notes) -> tuple[ShapeReader, EmitterReader]:
    """Everything in the scene that is seen, and the lights that are not."""
    textures = TextureReader(tree, notes)
    emitters = EmitterReader(tree, textures, notes)
    shapes = ShapeReader(tree, MaterialReader(textures, notes), emitters, notes)
    for key, child in tree.children(0):
        kind = tree.kind(child) if isinstance(child, int) else None
        if kind == mi.ObjectType.Shape or isinstance(child, mi.Shape):
            shapes.add(child, key)
        elif kind == mi.ObjectType.Emitter or isinstance(child, mi.Emitter):
            emitters.add(tree.build(child) if isinstance(child, int) else child)
        elif kind in (mi.ObjectType.BSDF, mi.ObjectType.Texture):
            tree.build(child)  # unused ones too: a mistake in them is a mistake in the file
    geometry = shapes.geometry
    if clear := geometry.clear:
        names = ", ".join(clear[:NAMED]) + (", ..." if len(clear) > NAMED else "")
        notes.add(
            f"{counted(len(clear), 'clear shape')}, such as glass, left out, light passes straight: {names}"
        )
    if geometry.without_area:
        notes.add(f"{geometry.without_area} triangle(s) without area, which no ray meets")
    if geometry.triangles == 0 and geometry.without_area:
        raise SceneError(none_has_area(geometry.without_area))
    if geometry.triangles == 0:
        raise SceneError("there is no geometry in the scene")
    return shapes, emitters


def _add_ceiling(
    tree: PluginTree,
    shapes: ShapeReader,
    height: Height,
    up: np.ndarray,
    origin: np.ndarray,
    name: str,
    notes: Notes,
) -> None:
    """Lay a ceiling, whose height is in the file's coordinates, over what was read of a tree that counts from `origin`."""
    open_scene, below = _assembled(shapes.geometry.traced, None), float(origin @ up)
    _check_bounds(_around(open_scene, None), origin, name)
    slab, height = describe_ceiling(open_scene, height, up, below)
    for index in tree.graft({CEILING: slab}, "added to the scene"):
        shapes.add(index, CEILING)
    notes.add(f"a ceiling added at a height of {height:.4g}")


def _check_bounds(box: np.ndarray, origin: np.ndarray, name: str) -> None:
    """Refuse geometry without a usable box (2, 3) around it, which counts from `origin`."""
    check_bounds((_point(box[0] + origin), _point(box[1] + origin)), name)


def nearest_axis(direction: np.ndarray) -> np.ndarray:
    """(3,) the signed coordinate axis nearest a direction."""
    axis = np.zeros(3)
    axis[int(np.abs(direction).argmax())] = 1.0
    return axis * np.sign(direction @ axis)


def _point(values: Iterable[float]) -> tuple[float, float, float]:
    x, y, z = map(float, values)
    return x, y, z


def _clear_what_is_ours(tree: PluginTree, notes: Notes) -> None:
    """Drop integrator, samplers and all of films but their size; make file names absolute.

    Our own take their place, so nothing in them can stop a scene from loading; and the tree stays
    usable after the folder of the file is no longer searched.
    """
    for key, child in tree.children(0):
        if isinstance(child, int) and tree.kind(child) in OURS:
            tree.drop(0, key)
    string = mi.Properties.Type.String
    for index in range(len(tree.state.nodes)):
        properties = tree.properties(index)
        if tree.kind(index) == mi.ObjectType.Sensor:
            _drop_sampler(tree, index)
        elif tree.kind(index) == mi.ObjectType.Film:
            tree.state.nodes[index].props = _plain_film(properties)
        elif "filename" in properties and properties.type("filename") == string:
            _make_absolute(properties)
            if properties.get("filter_type", "bilinear") in OLD_FILTERS:
                notes.add(f"texture filter {properties['filter_type']!r}: bilinear instead")
                properties["filter_type"] = "bilinear"


def _drop_sampler(tree: PluginTree, sensor: int) -> None:
    for key, child in tree.children(sensor):
        if isinstance(child, int) and tree.kind(child) == mi.ObjectType.Sampler:
            tree.drop(sensor, key)


def _make_absolute(properties: Any) -> None:
    path = Path(str(mi.file_resolver().resolve(properties["filename"])))
    if path.is_file():
        properties["filename"] = str(path.resolve())


def _plain_film(properties: Any) -> Any:
    film = mi.Properties("hdrfilm")
    film.set_id(properties.id())
    for key in FILM_KEYS:
        if key in properties:
            film[key] = properties[key]
    film["pixel_format"], film["component_format"] = "rgb", "float32"
    return film


def _cameras(tree: PluginTree, notes: Notes, origin: np.ndarray) -> tuple[list[Camera], np.ndarray | None]:
    """All cameras, of a tree that counts from `origin`; and what the first one has for up."""
    cameras: list[Camera] = []
    up = None
    for key, child in tree.children(0):
        if isinstance(child, int) and tree.kind(child) == mi.ObjectType.Sensor:
            if tree.plugin(child) not in CAMERAS:
                notes.add(f"{tree.label(child)}: not a camera this package has, left out")
                tree.drop(0, key)  # Mitsuba may have no such plugin either
                continue
            sensor, moved = tree.build(child), origin
        elif isinstance(child, mi.Sensor):
            sensor, moved = child, np.zeros(3)  # what came as an object is where it was
        else:
            continue
        name = sensor.id() or f"camera-{len(cameras)}"
        if (camera := read_camera(sensor, name, tree, notes, moved)) is not None:
            cameras.append(camera)
            up = sensor_up(sensor) if up is None else up
    return cameras, up


def _drop_environment(tree: PluginTree, notes: Notes) -> None:
    for key, child in tree.children(0):
        if isinstance(child, int):
            found = tree.kind(child) == mi.ObjectType.Emitter and tree.plugin(child) in ENVIRONMENTS
        else:
            found = isinstance(child, mi.Emitter) and child.is_environment()
        if found:
            notes.add("the scene's own environment gives way to the one added")
            tree.drop(0, key)


def _assembled(shapes: Sequence[Traced], environment: mi.Emitter | None) -> mi.Scene:
    """Mitsuba's scene over traced shapes, which keep their names."""
    description: dict[str, Any] = {"type": "scene"}
    for number, (_, shape) in enumerate(shapes):
        description[f"shape-{number}"] = shape
    if environment is not None:
        description["environment"] = environment
    try:
        scene = mi.load_dict(description, optimize=False, parallel=False)
    except Exception as error:
        raise SceneError(one_line(error)) from error
    for name, shape in shapes:
        shape.set_id(name)  # the dictionary's keys became ids
    return scene
