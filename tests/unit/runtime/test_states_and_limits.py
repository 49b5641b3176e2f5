"""The state machine, the stop requests and the one choke point of commands."""

import contextlib
import math
import os
import random
import signal
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.hal import DeviceFault, LimitExceeded
from rig.runtime import stop as stop_module
from rig.runtime.limits import VectorLimiter
from rig.runtime.states import IllegalMove, RigState, StateMachine
from rig.runtime.stop import ENDING, PATIENCE, UNHEARD, StopRequests


def test_fault_is_latched():
    states = StateMachine()
    states.move(RigState.IDLE)
    states.move(RigState.RUNNING)
    first = DeviceFault("regulators", "it fell silent")
    states.latch_fault(first)
    states.latch_fault(DeviceFault("encoder", "it fell silent too"))
    assert states.fault is first
    for state in RigState:
        with pytest.raises(IllegalMove, match="latched by: regulators"):
            states.move(state)
    assert states.state is RigState.FAULT


def test_a_rig_does_not_run_before_it_is_connected():
    states = StateMachine()
    assert states.fault is None
    with pytest.raises(IllegalMove, match=r"disconnected and cannot become running$"):
        states.move(RigState.RUNNING)


def test_changes_of_state_are_told():
    told = []
    states = StateMachine(lambda old, new: told.append((old, new)))
    states.move(RigState.IDLE)
    assert told == [(RigState.DISCONNECTED, RigState.IDLE)]


def test_requests_count_in_the_loop_interrupt_outside_and_are_put_back():
    before = signal.getsignal(signal.SIGINT)
    with StopRequests() as stop:
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
        stop.in_loop = True
        for number in ENDING:
            os.kill(os.getpid(), number)
        stop.in_loop = False
        stop.shield()
        os.kill(os.getpid(), signal.SIGINT)
        assert stop.count == 2 + len(ENDING) and not stop.in_cycles
    assert signal.getsignal(signal.SIGINT) is before


def test_a_loop_in_another_thread_leaves_the_signals_to_the_main_one():
    before = signal.getsignal(signal.SIGINT)
    found = []

    def run():
        with StopRequests() as stop:
            stop.request()
            found.append((stop.count, signal.getsignal(signal.SIGINT)))

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    assert found == [(1, before)]


def test_a_request_while_nothing_may_be_interrupted_interrupts_as_soon_as_it_may():
    stop = StopRequests()
    stop.shield()
    stop.expose()  # nobody asked
    stop.shield()
    stop.request()
    assert stop.count == 1
    with pytest.raises(KeyboardInterrupt):
        stop.expose()
    assert not stop.shielded


@pytest.mark.parametrize("ends", [None, RuntimeError])
def test_what_closes_after_a_block_is_not_torn_by_a_second_request(ends):
    closed = []

    @contextlib.contextmanager
    def closes():
        try:
            yield
        finally:
            os.kill(os.getpid(), signal.SIGINT)
            closed.append(True)

    with StopRequests() as stop, contextlib.suppress(*(() if ends is None else (ends,))):
        with closes(), stop.shielding_the_end():
            assert not stop.shielded
            if ends is not None:
                raise ends
        assert stop.shielded
    assert closed and stop.count == 1


@pytest.fixture
def at(monkeypatch):
    """Send this process Ctrl-C at a given time, s, or ask for a stop in another way."""
    now = []
    monkeypatch.setattr(stop_module, "monotonic", lambda: now[-1])

    def send(t, ask=lambda: os.kill(os.getpid(), signal.SIGINT)):
        now.append(t)
        ask()

    return send


def in_a_cycle(stop):
    stop.in_loop = stop.in_cycles = True
    return stop


@pytest.mark.parametrize("seed", range(4))
def test_a_further_request_interrupts_a_cycle_that_hears_none(seed, at):
    drawn = random.Random(seed)
    t = drawn.uniform(0.0, 1e5)
    with in_a_cycle(StopRequests()) as stop:
        at(t)
        for wait in sorted(drawn.uniform(0.0, PATIENCE) for _ in range(3)):
            at(t + 0.999 * wait)  # two in haste are no reason to tear a cycle
        assert stop.count == 4
        t += drawn.uniform(PATIENCE + 1e-3, 60.0)
        with pytest.raises(KeyboardInterrupt, match=f"^{UNHEARD}$"):
            at(t)
        at(t + drawn.uniform(0.0, 0.999))  # what follows has this time to make the rig safe
        with pytest.raises(KeyboardInterrupt, match=UNHEARD):
            at(t + drawn.uniform(PATIENCE + 1e-3, 60.0))


@pytest.mark.parametrize("seed", range(4))
def test_who_presses_in_haste_waits_no_longer(seed, at):
    drawn = random.Random(seed)
    with in_a_cycle(StopRequests()):
        at(t := drawn.uniform(0.0, 1e5))
        at(t + drawn.uniform(0.5, 0.9))
        with pytest.raises(KeyboardInterrupt):
            at(t + drawn.uniform(1.01, 1.4))


def test_patience_is_a_second_and_ends_with_it(at):
    with in_a_cycle(StopRequests()):
        at(64.0)
        with pytest.raises(KeyboardInterrupt):
            at(65.0)
    assert UNHEARD == "in a cycle that did not end"


@pytest.mark.parametrize("seed", range(4))
def test_requests_that_are_heard_interrupt_nothing(seed, at):
    drawn = random.Random(seed)
    t = 0.0
    with in_a_cycle(StopRequests()) as stop:
        for count in range(1, 6):
            at(t := t + drawn.uniform(2.0, 60.0))
            assert stop.count == count
            stop.heard = stop.count
        at(t + 5.0)
        with pytest.raises(KeyboardInterrupt):  # the one before was not heard
            at(t + 7.0)


def test_what_makes_safe_is_not_interrupted_and_keeps_nobody_waiting(at):
    with in_a_cycle(StopRequests()) as stop:
        at(0.0)
        stop.in_cycles = False
        at(30.0)
        at(60.0)
        assert stop.count == 3


def test_a_request_of_another_thread_that_is_not_heard_counts_as_well(at):
    with in_a_cycle(StopRequests()) as stop:
        at(8.0, stop.request)
        with pytest.raises(KeyboardInterrupt):
            at(9.5)


PRESSURE = st.floats(-1e7, 1e7)


@given(start=st.floats(0.0, 5e5), commands=st.lists(PRESSURE, min_size=1, max_size=20))
def test_limiter_never_leaves_range_or_rate(start, commands):
    limiter = VectorLimiter("pressure", 0.0, 5e5, rate=1e6, period=0.01, unit="Pa")
    limiter.reset((start,))
    before = start
    for command in commands:
        (applied,) = limiter.limit((command,))
        assert 0.0 <= applied <= 5e5
        assert abs(applied - before) <= 1e4 + 1e-6
        if 0.0 <= command <= 5e5 and abs(command - before) <= 1e4:
            assert applied == command
        before = applied


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_limiter_refuses_what_is_not_a_number(value):
    limiter = VectorLimiter("pressure", 0.0, 5e5, rate=1e6, period=0.01, unit="Pa")
    limiter.reset((0.0, 0.0))
    with pytest.raises(LimitExceeded, match="commanded pressure"):
        limiter.limit((0.0, value))


def test_limiter_counts_what_it_clips():
    limiter = VectorLimiter("pressure", 0.0, 5e5, rate=1e9, period=0.01, unit="Pa")
    limiter.reset((0.0,))
    assert limiter.limit((6e5,)) == (5e5,)
    assert (limiter.range_hits, limiter.rate_hits) == (1, 0)
