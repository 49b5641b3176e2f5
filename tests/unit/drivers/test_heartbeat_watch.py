"""A node's heartbeats: what they say, that they come, and when the master's own is due."""

import random
from math import inf, nextafter

import pytest

from drivers.canopen.heartbeat import (
    HeartbeatProducer,
    HeartbeatWatch,
    NmtState,
    describe_state,
)
from rig.hal import DeviceFault

TIMEOUT = 2.0**-5
BOOT_UP, OPERATIONAL = bytes([NmtState.BOOT_UP]), bytes([NmtState.OPERATIONAL])


def armed(at=1.0):
    watch = HeartbeatWatch("valves", 5, TIMEOUT)
    watch.receive(OPERATIONAL, at)
    watch.arm()
    return watch


def complaint(watch, now=1.0):
    with pytest.raises(DeviceFault) as caught:
        watch.check(now)
    assert watch.good_until < now  # who heeds that alone is told as well
    assert caught.value.node == 5
    return str(caught.value)


def test_a_watch_knows_nothing_at_first_and_expects_nothing():
    watch = HeartbeatWatch("valves", 5, TIMEOUT)
    assert (watch.state, watch.last, watch.boots, watch.good_until) == (None, -inf, 0, inf)
    watch.check(1e9)


def test_states_have_the_numbers_of_the_standard():
    assert [int(state) for state in NmtState] == [0, 4, 5, 127]


def test_states_have_names():
    assert describe_state(None) == "unknown"
    assert [describe_state(state) for state in NmtState] == [
        "booting", "STOPPED", "OPERATIONAL", "PRE-OPERATIONAL",
    ]  # fmt: skip
    assert describe_state(0x2A) == "unknown state 0x2A"


def test_silence_up_to_the_timeout_is_well():
    watch = armed()
    assert watch.good_until == 1.0 + TIMEOUT
    watch.check(1.0 + TIMEOUT)
    said = complaint(watch, nextafter(1.0 + TIMEOUT, inf))
    assert "heartbeat is lost" in said and "0.031 s of silence" in said and "0.03125 s" in said


@pytest.mark.parametrize("state", [0x04, 0x7F, 0x2A, *random.Random(3).sample(range(6, 0x7F), 3)])
def test_a_node_that_leaves_operational_is_a_fault_with_its_state(state):
    watch = armed()
    watch.receive(bytes([state]), 1.0)
    said = complaint(watch)
    assert "left OPERATIONAL by itself" in said and describe_state(state) in said
    watch.receive(OPERATIONAL, 1.0)
    watch.check(1.0)


def test_a_state_that_is_forgotten_is_not_operational():
    watch = armed()
    watch.forget()
    assert "unknown" in complaint(watch)


def test_a_node_that_rebooted_stays_out_of_use_until_it_is_armed_again():
    watch = armed()
    watch.receive(BOOT_UP, 1.0)
    watch.receive(OPERATIONAL, 1.0)
    for _ in range(3):
        assert "rebooted while running" in complaint(watch)
    assert watch.boots == 1
    watch.arm()
    watch.check(1.0)
    assert watch.good_until == 1.0 + TIMEOUT


def test_a_node_that_is_not_armed_is_not_judged():
    watch = HeartbeatWatch("valves", 5, TIMEOUT)
    watch.check(1e9)
    watch.receive(BOOT_UP, 0.0)
    watch.check(1e9)
    watch = armed()
    watch.receive(BOOT_UP, 1.0)
    watch.disarm()
    watch.check(1e9)
    assert watch.good_until == inf


def test_a_node_that_was_never_heard_cannot_be_armed_unnoticed():
    watch = HeartbeatWatch("valves", 5, TIMEOUT)
    watch.arm()
    assert "unknown" in complaint(watch, 0.0)


@pytest.mark.parametrize("data", [b"", b"\x04\x00", b"\x00" * 8])
def test_a_heartbeat_of_another_length_is_none(data):
    watch = armed()
    watch.receive(data, 1.01)
    assert (watch.state, watch.last, watch.boots) == (NmtState.OPERATIONAL, 1.0, 0)


def test_the_toggle_bit_of_node_guarding_is_no_state():
    watch = armed()
    watch.receive(b"\x85", 1.01)
    watch.check(1.01 + 0.9 * TIMEOUT)
    assert watch.state == NmtState.OPERATIONAL


def test_the_masters_heartbeat_does_not_drift_and_is_not_made_up_for():
    producer = HeartbeatProducer(0.25)
    assert producer.due < 0.0  # at once
    producer.sent(1.0)
    assert producer.due == 1.25
    producer.sent(1.375)  # a cycle late: the next keeps to the grid
    assert producer.due == 1.5
    producer.sent(1.75)  # one was left out: none comes twice
    assert producer.due == 2.0
    producer.restart()
    assert producer.due < 0.0
