"""Every number that names an element must name one that exists, in parts that nothing shows as well."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from ddgi.errors import SceneError
from ddgi.scene.gltf.schema import Document, To


def check_references(document: Document) -> None:
    """Follow every reference of a document.

    Raises:
        SceneError: One names an element that does not exist.
    """
    for where, collection, index in _references(document, ""):
        if index >= (count := len(getattr(document, collection))):
            label = collection.replace("_", " ")
            raise SceneError(f"{where} names number {index} of the {label}, but there are {count}")


def _references(item: BaseModel, where: str) -> Iterator[tuple[str, str, int]]:
    """Where, the list meant, and the number."""
    for name, field in type(item).model_fields.items():
        place = f"{where}.{field.alias or name}".lstrip(".")
        value = getattr(item, name)
        marks = [mark for mark in field.metadata if isinstance(mark, To)]
        if marks:
            yield from ((at, marks[0].collection, index) for at, index in _found(int, value, place))
        else:
            for at, inner in _found(BaseModel, value, place):
                yield from _references(inner, at)


def _found(kind: type, value: Any, where: str) -> Iterator[tuple[str, Any]]:
    """Everything of a kind in lists and dictionaries, with its place."""
    if isinstance(value, kind):
        yield where, value
    elif isinstance(value, list):
        for number, inner in enumerate(value):
            yield from _found(kind, inner, f"{where}[{number}]")
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from _found(kind, inner, f"{where}.{key}")
