"""Plugins of Mitsuba 0.x to 2 that Mitsuba 3 has no more, replaced by the nearest that it has.

They are replaced in the plugin tree, so that the path-traced reference renders the same substitute.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from typing import Any

import mitsuba as mi

from ddgi.scene.notes import Notes
from ddgi.scene.plugin_tree import PluginTree

DROPPED = {
    mi.ObjectType.Integrator: "integrator",
    mi.ObjectType.Sampler: "sampler",
    mi.ObjectType.Film: "film",
    mi.ObjectType.ReconstructionFilter: "reconstruction filter",
}
"""What is ours in any case; of those that Mitsuba would refuse a note says so."""


def replace_old_plugins(tree: PluginTree, notes: Notes) -> None:
    """Put a substitute in the place of every plugin that no longer exists and has one."""
    for index in range(len(tree.state.nodes)):
        plugin, kind = tree.plugin(index), tree.kind(index)
        if kind in DROPPED:
            if not _exists(plugin, kind):
                notes.add(f"{tree.label(index)}: Mitsuba 3 has no such {DROPPED[kind]}, left out")
        elif (rule := _RULES.get((kind, plugin))) is not None:
            label = tree.label(index)
            substitute = rule(tree, index)
            if substitute is not None:
                substitute.set_id(tree.properties(index).id())
                tree.state.nodes[index].props = substitute
                notes.add(f"{label}: Mitsuba 3 has no such plugin, {substitute.plugin_name()} instead")
        if _lies(tree, index):
            _stand_up(tree.properties(index))
            notes.add(f"{tree.label(index)}: turned, as skies had +y up before Mitsuba 3")


def _exists(plugin: str, kind: Any) -> bool:
    """Whether Mitsuba has a plugin of that name and kind."""
    found = mi.PluginManager.instance().plugin_type(plugin)
    if found != mi.ObjectType.Unknown or not plugin.isidentifier():  # a path would be looked for on the disk
        return bool(found == kind)
    try:  # of those written in Python only building tells
        mi.load_dict({"type": plugin})
    except Exception as error:  # others complain of what they need
        return "not found" not in str(error)
    return True


def _lies(tree: PluginTree, index: int) -> bool:
    """A sky of an old file, unless the file turns it: somebody did that for Mitsuba 3."""
    sky = tree.kind(index) == _LIGHT and tree.plugin(index) == "sunsky"
    return sky and tree.version < (2,) and "to_world" not in tree.properties(index)


def _stand_up(properties: Any) -> None:
    """Skies had +y for their zenith, and have +z; the sun's direction is in the world's axes."""
    properties["to_world"] = mi.ScalarTransform4f().rotate([1, 0, 0], -90)


def _phong(tree: PluginTree, index: int) -> Any:
    exponent = _number(tree.properties(index), "exponent", 30.0)
    return _rough_plastic(tree, index, sqrt(2 / (exponent + 2)))  # Walter et al. 2007, the lobe's width


def _ward(tree: PluginTree, index: int) -> Any:
    properties = tree.properties(index)
    widths = _number(properties, "alpha_u", 0.1), _number(properties, "alpha_v", 0.1)
    return _rough_plastic(tree, index, sqrt(widths[0] * widths[1]))


def _rough_plastic(tree: PluginTree, index: int, alpha: float) -> Any:
    """Keeps the diffuse colour; the highlight is that of plastic."""
    substitute = _renamed(tree, index, "roughplastic", {"diffuse_reflectance": "diffuse_reflectance"})
    substitute["alpha"] = min(max(alpha, 0.001), 1.0)
    return substitute


def _diffuse_transmitter(tree: PluginTree, index: int) -> Any:
    substitute = _renamed(tree, index, "principledthin", {"transmittance": "base_color"})
    substitute["diff_trans"], substitute["roughness"] = 2.0, 1.0
    return substitute


def _uncoated(tree: PluginTree, index: int) -> Any | None:
    """What is below the coat; None where it is not there or came as an object."""
    for _, child in tree.children(index):
        if isinstance(child, int) and tree.kind(child) == mi.ObjectType.BSDF:
            rule = _RULES.get((mi.ObjectType.BSDF, tree.plugin(child)))
            return rule(tree, child) if rule else mi.parser.SceneNode(tree.state.nodes[child]).props
    return None


def _mixture(tree: PluginTree, index: int) -> Any | None:
    """Two materials are a blend; of more Mitsuba's refusal says where."""
    properties = tree.properties(index)
    weights = [float(w) for w in str(properties.get("weights", "")).replace(",", " ").split()]
    nested = [c for _, c in tree.children(index) if isinstance(c, int) and tree.kind(c) == mi.ObjectType.BSDF]
    if len(weights) != 2 or len(nested) != 2 or not sum(weights) > 0:
        return None
    substitute = mi.Properties("blendbsdf")
    substitute["weight"] = weights[1] / sum(weights)
    for number, child in enumerate(nested):
        substitute[f"bsdf_{number}"] = mi.Properties.ResolvedReference(child)
    return substitute


def _sky(tree: PluginTree, index: int) -> Any:
    return _sun_or_sky(tree, index, "sun_scale")


def _sun(tree: PluginTree, index: int) -> Any:
    return _sun_or_sky(tree, index, "sky_scale")


def _sun_or_sky(tree: PluginTree, index: int, without: str) -> Any:
    same = {key: key for key in ("turbidity", "sun_direction", "albedo", "to_world")}
    substitute = _renamed(tree, index, "sunsky", same)
    substitute[without] = 0.0
    return substitute


def _vertex_colors(tree: PluginTree, index: int) -> Any:
    substitute = mi.Properties("mesh_attribute")
    substitute["name"] = "vertex_color"
    return substitute


def _renamed(tree: PluginTree, index: int, plugin: str, keys: dict[str, str]) -> Any:
    """Another plugin with some of the properties, called as it calls them."""
    properties, substitute = tree.properties(index), mi.Properties(plugin)
    for old, new in keys.items():
        if old in properties:
            substitute[new] = properties[old]
    return substitute


def _number(properties: Any, key: str, default: float) -> float:
    """A number of the file; a texture in its place counts as the default."""
    numbers = (mi.Properties.Type.Float, mi.Properties.Type.Integer)
    found = key in properties and properties.type(key) in numbers
    return float(properties[key]) if found else default


_BSDF, _LIGHT, _TEXTURE = mi.ObjectType.BSDF, mi.ObjectType.Emitter, mi.ObjectType.Texture
_RULES: dict[tuple[Any, str], Callable[[PluginTree, int], Any | None]] = {
    (_BSDF, "phong"): _phong,
    (_BSDF, "ward"): _ward,
    (_BSDF, "difftrans"): _diffuse_transmitter,
    (_BSDF, "coating"): _uncoated,
    (_BSDF, "roughcoating"): _uncoated,
    (_BSDF, "mixturebsdf"): _mixture,
    (_LIGHT, "sky"): _sky,
    (_LIGHT, "sun"): _sun,
    (_TEXTURE, "vertexcolors"): _vertex_colors,
}
