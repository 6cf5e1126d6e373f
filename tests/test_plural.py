"""Numbers in words."""

import pytest

from ddgi.plural import counted, percent


@pytest.mark.parametrize(
    ("number", "text"), [(0, "0 frames"), (1, "1 frame"), (2, "2 frames"), (4096, "4,096 frames")]
)
def test_one_is_singular(number, text):
    assert counted(number, "frame") == text


@pytest.mark.parametrize(("share", "text"), [(0.0, "0 %"), (0.126, "13 %"), (1.0, "100 %")])
def test_shares_are_whole_percents(share, text):
    assert percent(share) == text
