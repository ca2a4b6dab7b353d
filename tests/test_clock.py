"""Wall time by phase: every second counts once."""

import time

import pytest

from warp_origami.clock import PHASES, PhaseClock


@pytest.fixture
def now(monkeypatch):
    """A clock that moves when told to."""
    moment = [100.0]
    monkeypatch.setattr(time, "perf_counter", lambda: moment[0])
    return moment


def test_nested_phases_count_for_the_innermost(now):
    clock = PhaseClock()
    now[0] += 1.0
    with clock.phase("assembly"):
        now[0] += 2.0
        with clock.phase("contact"):
            now[0] += 4.0
        now[0] += 8.0
    now[0] += 16.0
    assert clock.total() == 31.0
    assert clock.seconds == dict.fromkeys(PHASES, 0.0) | {"other": 17.0, "assembly": 10.0, "contact": 4.0}


def test_time_before_the_clock_counts_as_other(now):
    clock = PhaseClock(started=90.0)
    with clock.phase("setup"):
        now[0] += 3.0
    assert (clock.total(), clock.seconds["other"], clock.seconds["setup"]) == (13.0, 10.0, 3.0)


def test_an_exception_ends_its_phase(now):
    clock = PhaseClock()
    with pytest.raises(KeyError), clock.phase("solve"):
        now[0] += 1.0
        raise KeyError
    now[0] += 5.0
    assert clock.total() == 6.0
    assert clock.seconds["solve"] == 1.0
    assert clock.seconds["other"] == 5.0
