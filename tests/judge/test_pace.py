"""How many samples fit, on a clock that is ours."""

import pytest

from ddgi.judge import pace


@pytest.fixture
def clock(monkeypatch):
    class Clock:
        now = 100.0

    monkeypatch.setattr(pace, "perf_counter", lambda: Clock.now)
    return Clock


def test_samples_and_their_judgement_fit_in_the_time_left(clock):
    limit = pace.Pace(10.0)
    clock.now += 1.0  # what came before
    with limit.sampling(8):
        clock.now += 2.0
    with limit.judging():
        clock.now += 1.5
    # 10 - 1 - 2 - 1.5 = 5.5 s are left, 1.5 of them for judging, at 4 samples a second.
    assert limit.affordable() == 16
    with limit.sampling(16):
        clock.now += 4.0
    assert limit.affordable() == 0


def test_late_is_nothing(clock):
    limit = pace.Pace(1.0)
    with limit.sampling(8):
        clock.now += 2.0
    assert limit.affordable() < 1
