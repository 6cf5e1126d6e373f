"""What to say of a scene in which there is something, but nothing that light meets."""

from __future__ import annotations

from ddgi.plural import counted

ADVICE = "export the model with surfaces, as light meets nothing else"


def only(things: dict[str, int]) -> str:
    """`3 lines and 1 point` of the numbers of things, without those of which there are none; empty if all are."""
    return " and ".join(counted(number, thing) for thing, number in things.items() if number)


def none_has_area(triangles: int) -> str:
    """Of a scene with triangles, one or more, which are lines or points all of them."""
    found = (
        "its only triangle has no area"
        if triangles == 1
        else f"none of the {triangles:,} triangles has an area"
    )
    return f"{found}: {ADVICE}"


def no_triangle(found: str) -> str:
    """Of a scene without triangles, in which there is something else."""
    return f"there is no triangle, only {found}: {ADVICE}"
