"""Every number that names an element must name one that exists, in parts that nothing shows as well."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any, TypeAlias, get_args

from pydantic import BaseModel

from ddgi.errors import SceneError
from ddgi.scene.gltf.schema import Document, To

_Place: TypeAlias = tuple[str | int, ...]
"""Names and numbers on the way to an element; made into text for a mistake alone, as most are none."""


def check_references(document: Document) -> None:
    """Follow every reference of a document.

    Raises:
        SceneError: One names an element that does not exist.
    """
    for place, collection, index in _references(document, ()):
        if index >= (count := len(getattr(document, collection))):
            label = collection.replace("_", " ")
            raise SceneError(f"{_text(place)} names number {index} of the {label}, but there are {count}")


def _references(item: BaseModel, where: _Place) -> Iterator[tuple[_Place, str, int]]:
    """Where, the list meant, and the number."""
    given = item.model_fields_set  # defaults refer to nothing
    for name, label, collection in _followed(type(item)):
        if name not in given:
            continue
        place = (*where, label)
        if collection is not None:
            for at, index in _found(int, getattr(item, name), place):
                yield at, collection, index
        else:
            for at, inner in _found(BaseModel, getattr(item, name), place):
                yield from _references(inner, at)


@cache
def _followed(kind: type[BaseModel]) -> list[tuple[str, str, str | None]]:
    """Name, name in the file, and the list meant of fields that refer; no list of those that hold models."""
    out: list[tuple[str, str, str | None]] = []
    for name, field in kind.model_fields.items():
        marks = [mark for mark in field.metadata if isinstance(mark, To)]
        if marks or _holds_models(field.annotation):
            out.append((name, field.alias or name, marks[0].collection if marks else None))
    return out


def _holds_models(annotation: Any) -> bool:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return True
    return any(_holds_models(part) for part in get_args(annotation))


def _found(kind: type, value: Any, where: _Place) -> Iterator[tuple[_Place, Any]]:
    """Everything of a kind in lists and dictionaries, with its place."""
    if isinstance(value, kind):
        yield where, value
    elif isinstance(value, list):
        for number, inner in enumerate(value):
            yield from _found(kind, inner, (*where, number))
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from _found(kind, inner, (*where, key))


def _text(place: _Place) -> str:
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place).lstrip(".")
