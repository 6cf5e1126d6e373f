"""Numbers of things."""

import pytest

from ddgi.plural import counted


@pytest.mark.parametrize(
    ("number", "text"), [(0, "0 frames"), (1, "1 frame"), (2, "2 frames"), (4096, "4,096 frames")]
)
def test_one_is_singular(number, text):
    assert counted(number, "frame") == text
