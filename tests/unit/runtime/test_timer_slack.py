"""The timer slack of a process that runs loops is its own again after each of them."""

import ctypes

import pytest

from rig.runtime.realtime import real_time, timer_slack

SET = 29
LIBC = ctypes.CDLL(None, use_errno=True)


@pytest.fixture
def slack():
    """Return what sets the timer slack of this thread, ns; what was there is set again."""
    before, _ = timer_slack()
    yield lambda nanoseconds: LIBC.prctl(SET, nanoseconds)
    LIBC.prctl(SET, before)


@pytest.mark.parametrize("priority", [0, 10])
@pytest.mark.parametrize("own", [1_000, 123_456, 4_000_000])
def test_a_loop_leaves_the_slack_as_it_was(slack, own, priority):
    slack(own)
    with real_time(priority):
        assert timer_slack()[0] <= 1
        with real_time(priority):
            assert timer_slack()[0] <= 1
        assert timer_slack()[0] <= 1
    assert timer_slack()[0] == own


def test_a_loop_that_ends_by_an_error_does_so_too(slack):
    slack(234_567)
    with pytest.raises(ValueError, match="law"), real_time(0):
        raise ValueError("law")
    assert timer_slack()[0] == 234_567
