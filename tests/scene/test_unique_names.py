"""Names that are each given once."""

import pytest

from ddgi.scene.gltf.names import Names
from ddgi.scene.unique_names import UniqueNames


def test_equal_names_are_numbered_around_those_that_are_there():
    names = UniqueNames()
    wanted = ["a", "a-3", "a", "a", "a-2", "a", "b"]
    assert [names.unique(name) for name in wanted] == ["a", "a-3", "a-2", "a-4", "a-2-2", "a-5", "b"]


@pytest.mark.timeout(20)  # counting from 2 each time takes minutes
@pytest.mark.parametrize("kind", [UniqueNames, Names])
def test_very_many_equal_names(kind):
    names = kind()
    given = [names.unique("leaf") for _ in range(100_000)]
    assert given[-1] == "leaf-100000"
    assert len(set(given)) == len(given)


def test_keys_of_plugins_are_no_names():
    assert [Names().unique(name) for name in ("_shape-3", "_shape")] == ["_shape-3-2", "_shape"]
