"""Monitors that are asked for by SDO, one by one, in bytes."""

import struct
from math import inf

import pytest

from drivers.canopen.asked import AskedObjects
from drivers.canopen.mapping import Entry
from drivers.cia401.asked_monitors import AskedMonitors

ENTRIES = (Entry(0x6401, 1, "i16"), Entry(0x6401, 2, "i16"), Entry(0x2401, 3, "u32"))
SCALES = (10.0, 20.0, 0.5)
LOW, HIGH = -100, 30_000
WOKEN = (0x000, "8010")


def answer(entry, raw, code):
    """Return what a node answers: 0x4B two bytes, 0x43 four."""
    head = struct.pack("<BHB", code, entry.object, entry.sub)
    return head + struct.pack("<i", raw)


@pytest.fixture
def asked():
    """Return monitors, what they sent, and the objects that take the answers."""
    sent = []
    objects = AskedObjects(lambda can_id, data: sent.append((can_id, data.hex().upper())), 0x10)
    lines = [(k, lambda raw, by=by: by * raw, LOW, HIGH) for k, by in enumerate(SCALES)]
    monitors = AskedMonitors(objects, ENTRIES, lines, lambda: sent.append(WOKEN))
    return monitors, sent, objects


def test_one_is_asked_for_each_time_and_all_in_turn(asked):
    monitors, sent, _ = asked
    for _ in range(4):
        monitors.ask()
    assert sent.pop(0) == WOKEN  # once
    assert [data for _, data in sent] == [
        "4001640100000000", "4001640200000000", "4001240300000000", "4001640100000000",
    ]  # fmt: skip
    assert {can_id for can_id, _ in sent} == {0x610}


def test_what_is_known_is_as_old_as_the_oldest_answer(asked):
    monitors, _, objects = asked
    assert monitors.reading().t == -inf
    for k, (entry, raw, code) in enumerate(
        zip(ENTRIES, (-7, 500, 30_000), (0x4B, 0x4B, 0x43), strict=True)
    ):
        monitors.ask()
        assert monitors.reading().t == -inf
        assert objects.take(answer(entry, raw, code), 1.0 + k)
    assert monitors.reading() == ((-70.0, 10_000.0, 15_000.0), 1.0)
    monitors.ask()
    objects.take(answer(ENTRIES[0], 9, 0x4B), 5.0)
    assert monitors.reading() == ((90.0, 10_000.0, 15_000.0), 2.0)


@pytest.mark.parametrize("raw", [LOW - 1, HIGH + 1])
def test_a_monitor_whose_wire_is_broken_tells_nothing(asked, raw):
    monitors, _, objects = asked
    monitors.ask()
    assert objects.take(answer(ENTRIES[0], raw, 0x4B), 1.0)
    assert monitors.reading().t == -inf
    assert monitors.reading().value[0] == 0.0


def test_what_is_forgotten_is_left_to_who_reads_it(asked):
    monitors, _, objects = asked
    monitors.forget()
    monitors.ask()
    monitors.forget()
    assert not objects.take(answer(ENTRIES[0], 5, 0x4B), 1.0)


def test_a_bus_that_is_gone_tells_nothing():
    def gone(*_):
        raise OSError("the bus is not open")

    monitors = AskedMonitors(AskedObjects(gone, 1), ENTRIES, [], lambda: None)
    monitors.ask()
    assert monitors.reading().t == -inf
    asleep = AskedMonitors(AskedObjects(lambda *_: None, 1), ENTRIES, [], gone)
    asleep.ask()
    assert not asleep.asking
