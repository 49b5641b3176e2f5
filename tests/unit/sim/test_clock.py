"""Virtual time and faults on a schedule."""

import math
from typing import NamedTuple

import pytest

from drivers.sim.clock import SimClock
from drivers.sim.faults import FaultSchedule, FaultyWorld
from rig.hal import ConfigurationError


class Line(NamedTuple):
    at: float
    device: str
    fault: str
    size: float | None = None


class Diary:
    """A world and a device that write down what happens to them."""

    known_faults = ("break", "repair")

    def __init__(self):
        self.entries = []

    def advance(self, t):
        self.entries.append(t)

    def inject(self, fault, value=None):
        self.entries.append((fault, value))


def test_time_passes_only_while_sleeping():
    world = Diary()
    clock = SimClock(world)
    assert clock.now() == 0.0
    clock.sleep_until(0.002)
    clock.sleep_until(0.002)
    clock.sleep_until(0.001)
    assert clock.now() == 0.002
    assert world.entries == [0.002]


@pytest.mark.parametrize("t", [math.inf, math.nan])
def test_never_sleeps_for_ever(t):
    clock = SimClock(Diary())
    with pytest.raises(ValueError, match="cannot sleep until"):
        clock.sleep_until(t)
    assert clock.now() == 0.0


def test_faults_happen_at_their_time_and_in_their_order():
    diary = Diary()
    schedule = FaultSchedule(
        [
            Line(0.5, "diary", "repair"),
            Line(0.1, "diary", "break", 1.0),
            Line(0.1, "diary", "break", 2.0),
        ],
        {"diary": diary},
    )
    clock = SimClock(FaultyWorld(diary, schedule))
    clock.sleep_until(0.05)
    clock.sleep_until(0.2)
    clock.sleep_until(1.0)
    expected = [0.05, 0.1, ("break", 1.0), ("break", 2.0), 0.2, 0.5, ("repair", None), 1.0]
    assert diary.entries == expected
    assert schedule.next_time == math.inf


def test_a_fault_at_the_start_is_there_from_the_start():
    diary = Diary()
    schedule = FaultSchedule([Line(0.0, "diary", "break")], {"diary": diary})
    FaultyWorld(diary, schedule)
    assert diary.entries == [("break", None)]


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (Line(0.0, "dairy", "break"), "no device 'dairy' to fail; there are diary"),
        (
            Line(0.0, "diary", "brake"),
            "diary: no fault 'brake' \\(did you mean break\\?\\); known are break, repair",
        ),
    ],
)
def test_an_unknown_fault_is_refused_before_anything_runs(entry, message):
    with pytest.raises(ValueError, match=message):
        FaultSchedule([entry], {"diary": Diary()})


def test_a_value_that_does_not_fit_is_an_error_of_the_profile():
    class Picky(Diary):
        def inject(self, fault, value=None):
            raise ValueError("diary: break takes a page")

    schedule = FaultSchedule([Line(0.5, "diary", "break", -1.0)], {"diary": Picky()})
    with pytest.raises(ConfigurationError, match=r"simulation\.faults: diary: break takes a page"):
        schedule.due(1.0)
