"""The line of setpoints against a queue of a known length, at periods that vary."""

import numpy as np
import pytest

from rig.mechanisms.pneumatic.alarms.dead_time import DeadTimeLine


@pytest.mark.parametrize("seed", range(5))
def test_the_newest_of_those_that_are_old_enough_acts(seed):
    rng = np.random.default_rng(seed)
    dead_time = rng.uniform(0.0, 0.05)
    line, sent, now = DeadTimeLine(dead_time), [], 3.0
    for k in range(500):
        now += rng.uniform(1e-4, 2e-2)
        sent.append((now, k))
        old = [one for at, one in sent if at <= now - dead_time]
        assert line.pass_on((k,), now) == ((old or [0])[-1],)


def test_without_dead_time_the_newest_acts():
    line = DeadTimeLine(0.0)
    assert [line.pass_on((k,), float(k)) for k in range(4)] == [(0,), (1,), (2,), (3,)]


def test_what_was_sent_before_a_pause_is_forgotten():
    line = DeadTimeLine(1.0)
    line.pass_on((1.0,), 0.0)
    line.clear()
    assert line.pass_on((2.0,), 5.0) == (2.0,)
