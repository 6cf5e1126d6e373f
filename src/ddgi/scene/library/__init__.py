"""Scenes built by code, so that examples, tests and measurements need no download.

Listing them is cheap: the builders, and with them NumPy and Mitsuba, are imported when one is built.
"""

from __future__ import annotations

from importlib import import_module

from ddgi.scene.library.blueprint import Blueprint, BuiltIn

__all__ = ["BUILT_IN", "Blueprint", "BuiltIn"]


def _built_in(name: str, module: str, summary: str) -> BuiltIn:
    """A built-in scene whose builder is the function of that name in `module` (dashes become underscores), imported on the first call."""

    def build(**parameters: object) -> Blueprint:
        builder = getattr(import_module(f"{__name__}.{module}"), name.replace("-", "_"))
        blueprint: Blueprint = builder(**parameters)
        return blueprint

    return BuiltIn(name, summary, build)


BUILT_IN: dict[str, BuiltIn] = {
    scene.name: scene
    for scene in (
        _built_in("cornell", "cornell", "Cornell box with its area light"),
        _built_in("cornell-point", "cornell", "Cornell box lit by one point light"),
        _built_in("furnace", "furnace", "closed glowing box: radiance is 1 everywhere, exactly"),
        _built_in("house", "house", "house in the sun: one room open, one sealed and black (leak test)"),
        _built_in("two-rooms", "two_rooms", "two rooms and a doorway, a lamp in only one of them"),
        _built_in("courtyard", "courtyard", "arcaded court with curtains in the sun, over 200,000 triangles"),
        _built_in(
            "beach-balls", "beach_balls", "the courtyard, and a hundred balls that tumble through it (BLOG)"
        ),
        _built_in("color-boxes", "color_boxes", "closed box, two coloured objects, a spotlight (CTU 7.4)"),
        _built_in("occluder-box", "occluder_box", "closed white box, two occluders, a spotlight (CTU 7.1)"),
        _built_in(
            "ceiling-hole", "ceiling_hole", "room lit through its ceiling, a corner in shadow (CTU 7.3)"
        ),
        _built_in(
            "ceiling-caves-in", "ceiling_caves_in", "that room, its ceiling shut until a slab falls out of it"
        ),
        _built_in("flashlight", "flashlight", "two dark rooms, and a flashlight that looks around in them"),
        _built_in("room-with-door", "room_with_door", "closed rooms and a small door (leak test, CTU 7.1)"),
        _built_in("dragon-box", "dragon_box", "white box lit by what bounces off a red dragon (BLOG)"),
        _built_in("statue-box", "statue_box", "statue lit by an orange and a cyan wall alone (BLOG)"),
        _built_in(
            "cathedral", "cathedral", "vaulted church in the sun, lit almost wholly by what bounces in"
        ),
        _built_in("forest", "forest", "broad-leaved wood with a glade, where probes are known to fail"),
        _built_in("living-room", "living_room", "furnished room with two lamps, sunny windows and a mirror"),
    )
}
"""Every built-in scene by name."""
