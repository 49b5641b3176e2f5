"""Who is on a CANopen bus, by their answers and heartbeats; twins that share a number."""

import struct

import pytest

from drivers.canopen.discovery import survey_canopen
from rig.hal import FastCanBus

STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0x04, 0x05, 0x7F
BY_COMMAND = {0x01: OPERATIONAL, 0x02: STOPPED, 0x80: PRE_OPERATIONAL}
REGULATORS = 0x10


class Node:
    """A device with a device type and a serial number, and a heartbeat if it was told to."""

    def __init__(self, number, *, serial=1, state=PRE_OPERATIONAL, beats=True, speaks=True):
        self.number, self.serial, self.state = number, serial, state
        self.beats, self.speaks = beats, speaks
        self.objects = {(0x1000, 0): 0x00030191, (0x1018, 4): serial}

    def receive(self, can_id, data):
        if can_id == 0x000 and data[1] in (0, self.number):
            self.state = BY_COMMAND[data[0]]
        elif can_id == 0x600 + self.number and self.state != STOPPED and self.speaks:
            _, index, sub = struct.unpack_from("<BHB", data)
            value = self.objects.get((index, sub))
            command, value = (0x80, 0x06090011) if value is None else (0x43, value)
            yield 0x580 + self.number, struct.pack("<BHBI", command, index, sub, value)

    def beat(self):
        if self.beats and self.speaks:
            yield 0x700 + self.number, bytes((self.state,))


class Bus(FastCanBus):
    """A bus and its time: heartbeats come every 100 ms."""

    def __init__(self, *nodes):
        self.nodes, self.time, self.waiting, self.sent = nodes, 0.0, [], []
        self._beats = 0

    def now(self):
        return self.time

    def sleep_until(self, t):
        self.time = t
        while self._beats < t // 0.1:
            self._beats += 1
            for node in self.nodes:
                self.waiting += node.beat()

    def send_data(self, can_id, data):
        self.sent.append((can_id, data))
        for node in self.nodes:
            self.waiting += node.receive(can_id, data) or ()

    def drain(self, limit):
        frames, self.waiting = self.waiting, []
        return frames


def survey(*nodes, expected=(REGULATORS,)):
    bus = Bus(*nodes)
    return survey_canopen(bus, bus, expected), bus


def test_one_device_answers_once():
    ((found,), _) = survey(Node(REGULATORS, serial=7))
    assert (found.node, found.profile, found.serials) == (REGULATORS, 401, (7,))
    assert (found.state, found.answers) == ("PRE-OPERATIONAL", 1)


@pytest.mark.parametrize("other", [Node(0x33, state=OPERATIONAL), None], ids=["runs", "is run"])
def test_nobodys_state_is_changed_where_the_bus_is_in_use(other):
    nodes = [Node(REGULATORS), other] if other else [Node(REGULATORS)]
    bus = Bus(*nodes)
    if other is None:
        bus.waiting.append((0x080, b""))  # somebody's SYNC
    found = survey_canopen(bus, bus, (REGULATORS,))
    assert [item.answers for item in found] == [1] * len(nodes)
    assert all(can_id != 0x000 for can_id, _ in bus.sent)


def test_a_stopped_device_is_woken_and_counts_once():
    ((found,), bus) = survey(Node(REGULATORS, state=STOPPED))
    assert (found.state, found.answers) == ("PRE-OPERATIONAL", 1)
    assert (0x000, bytes((0x80, REGULATORS))) in bus.sent


@pytest.mark.parametrize("first", [PRE_OPERATIONAL, STOPPED])
@pytest.mark.parametrize("second", [PRE_OPERATIONAL, STOPPED])
@pytest.mark.parametrize("beats", [True, False])
def test_twins_are_two_whatever_state_they_are_in(first, second, beats):
    """A run that ended leaves its nodes STOPPED and mute; a twin switched on since is not."""
    twins = (
        Node(REGULATORS, state=first, beats=beats),
        Node(REGULATORS, state=second, beats=beats),
    )
    ((found,), bus) = survey(*twins)
    assert found.answers == 2
    assert {data[0] for can_id, data in bus.sent if can_id == 0x000} <= {0x80}


def test_a_device_that_was_stopped_meanwhile_is_still_one():
    """As at the end of a run that somebody else does on this bus."""
    node = Node(REGULATORS)
    bus = Bus(node)
    beat = node.beat

    def stopped_at_half_a_second():
        if bus.time > 0.5:
            node.state = STOPPED
        return beat()

    node.beat = stopped_at_half_a_second
    (found,) = survey_canopen(bus, bus, (REGULATORS,))
    assert found.answers == 1


def test_a_twin_that_hears_and_never_speaks_is_nobody():
    """What sends nothing cannot be found by anything that is asked: the limit of every survey."""
    ((found,), _) = survey(Node(REGULATORS), Node(REGULATORS, speaks=False))
    assert found.answers == 1


class LateNode(Node):
    """A device, or its computer, that is busy when it is asked for the first time."""

    def __init__(self, number, late):
        super().__init__(number)
        self.late, self.held = late, []

    def receive(self, can_id, data):
        answers = list(super().receive(can_id, data) or ())
        if can_id == 0x600 + self.number and not self.held:
            self.held = answers
            return
        yield from answers

    def beat(self):
        self.late -= 0.1
        if self.held and abs(self.late) < 0.05:
            yield from self.held
        yield from super().beat()


@pytest.mark.parametrize("late", [0.3, 0.4, 0.5, 0.6, 0.7, 0.8])
def test_a_late_answer_to_the_first_question_is_no_second_device(late):
    ((found,), _) = survey(LateNode(REGULATORS, late))
    assert (found.answers, found.serials) == (1, (1,))
