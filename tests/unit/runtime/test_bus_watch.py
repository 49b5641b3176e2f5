"""Counters of a bus: told once per rise, by bus and kind, however often somebody looks."""

import pytest
from loop_fakes import FakeBus

from rig.runtime.bus_watch import BusWatch

WORDS = {
    "lost": "error frames say that the controller has lost frames",
    "dropped": "frames were lost, since nobody took them in time",
    "unknown": "frames have come that the profile knows nothing of",
    "strange_answers": "nodes answer questions that somebody else asks",
}


def watched(*buses):
    told = []
    return told, BusWatch(buses, lambda *event: told.append(event))


@pytest.mark.parametrize(("kind", "what"), WORDS.items())
def test_a_count_is_told_when_it_begins_to_rise(kind, what):
    bus = FakeBus()
    told, watch = watched(bus)
    counts = (0, 0, 1, 2, 5, 5, 5, 6, 7, 7, 9)
    for t, count in enumerate(counts):
        bus.counts[kind] = count
        watch.look(float(t))
    message = f"can0: {what}"
    assert told == [
        (2.0, "bus", message, {kind: 1}),
        (7.0, "bus", message, {kind: 6}),
        (10.0, "bus", message, {kind: 9}),
    ]


def test_a_count_that_a_bus_does_not_have_or_that_began_anew_is_no_rise():
    bus = FakeBus()
    told, watch = watched(bus)
    for t, counts in enumerate(({}, {"frames_in": 9}, {"lost": 3}, {"lost": 1}, {"lost": 2})):
        bus.counts = counts
        watch.look(float(t))
    assert [(t, data) for t, _, _, data in told] == [(2.0, {"lost": 3}), (4.0, {"lost": 2})]


def test_each_bus_and_each_kind_has_its_own_rise():
    one, other = FakeBus("one"), FakeBus("other")
    told, watch = watched(one, other)
    one.counts = {"lost": 1}
    watch.look(0.0)
    one.counts, other.counts = {"lost": 2, "unknown": 4}, {"lost": 1}
    watch.look(1.0)
    assert [(t, message.split(":")[0], data) for t, _, message, data in told] == [
        (0.0, "one", {"lost": 1}),
        (1.0, "one", {"unknown": 4}),
        (1.0, "other", {"lost": 1}),
    ]
