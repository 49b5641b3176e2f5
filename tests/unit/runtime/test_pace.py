"""The ticks of a loop on their bounds, in times that floating point holds exactly."""

from types import SimpleNamespace

import pytest

from rig.hal import DeviceFault, LimitExceeded, LoopStalled, StaleReading
from rig.runtime.pace import Pace

P = 2.0**-7
MOST = 5
BROKEN = DeviceFault("drive", "it broke")


class Ticks(Pace):
    """A pace that remembers what it tells."""

    def __init__(self, most=MOST):
        self.told = []
        self.run = SimpleNamespace(missed=0)
        super().__init__(self.run, P, most, lambda *event: self.told.append(event))

    def cycle(self, work, late=0.0, busiest="control"):
        """Let a cycle begin so late and take so long, both in periods; return when the next is."""
        t = (self.tick + late) * P
        self.wake(t)
        return self.advance(t, t + work * P, lambda: busiest)


def at(tick, most=MOST):
    """Return a pace that has come to a tick in time."""
    pace = Ticks(most)
    for k in range(tick):
        assert pace.cycle(0.5) == (k + 1) * P
    return pace


def test_nothing_is_lost_and_nobody_excused_at_first():
    pace = Ticks()
    pace.wake(0.0)
    assert (pace.tick, pace.lost, pace.stall) == (0, 0.0, None)
    assert pace.blame(BROKEN) is BROKEN
    pace.wake(6 * P)  # five missed, as many as are allowed
    assert pace.stall is None
    assert (pace.told, pace.run.missed) == ([], 0)


@pytest.mark.parametrize(
    ("late", "lost"), [(0.0, 0.0), (0.5, 0.0), (1.0, 1.0), (1.5, 1.5), (2.0, 2.0)]
)
def test_a_cycle_less_than_a_period_late_has_lost_nothing(late, lost):
    pace = at(3)
    pace.wake((3 + late) * P)
    assert pace.lost == lost * P
    assert pace.stall is None and pace.told == []


@pytest.mark.parametrize(("late", "missed"), [(6.0, None), (6.125, 6), (7.0, 6), (7.125, 7)])
def test_who_wakes_more_ticks_late_than_are_allowed_has_stalled(late, missed):
    pace = at(4)
    pace.wake((4 + late) * P)
    if missed is None:
        assert (pace.stall, pace.told) == (None, [])
        return
    assert str(pace.stall) == (
        f"the program was paused for {late * P * 1e3:.1f} ms: {missed} ticks of 7.8125 ms missed "
        "in a row, at most 5 are allowed"
    )
    assert pace.told == [((4 + late) * P, "overrun", f"{missed} ticks missed", {"late": late * P})]
    assert pace.run.missed == missed


@pytest.mark.parametrize(("late", "stalls"), [(4.0, False), (4.125, True)])
def test_ticks_that_were_missed_right_before_count_as_well(late, stalls):
    pace = at(2)
    pace.cycle(2.5)  # two missed: 5 = 2 + 3 are allowed
    assert pace.lost == 0.0
    pace.wake((pace.tick + late) * P)
    assert pace.lost == (2 + late) * P
    assert (pace.stall is not None) is stalls


@pytest.mark.parametrize(
    ("work", "skipped"), [(0.0, 0), (0.5, 0), (1.0, 0), (1.125, 1), (2.0, 1), (2.125, 2), (6.0, 5)]
)
def test_ticks_are_skipped_that_are_over_when_the_work_is_done(work, skipped):
    pace = at(3)
    assert pace.cycle(work) == (4 + skipped) * P
    assert pace.tick == 4 + skipped
    assert pace.run.missed == skipped
    late = {"late": (work - 1.0) * P}
    event = (3 * P, "overrun", f"{skipped} ticks missed", late)
    assert pace.told == ([event] if skipped else [])
    pace.wake(pace.tick * P)
    assert pace.lost == skipped * P


def test_a_cycle_in_time_ends_a_row_of_missed_ticks():
    pace = at(1)
    for _ in range(4):
        pace.cycle(3.5)  # three of five
        pace.cycle(0.5)
    pace.wake(pace.tick * P)
    assert (pace.lost, pace.run.missed) == (0.0, 12)


@pytest.mark.parametrize(
    ("late", "work", "pause", "place"),
    [
        (0.0, 7.0, 7.0, " in its own work, mostly in control"),
        (3.0, 4.0, 4.0, " in its own work, mostly in control"),
        (3.5, 3.5, 3.5, " in its own work, mostly in control"),
        (4.0, 3.0, 4.0, ""),
    ],
)
def test_a_stall_is_blamed_on_the_work_unless_the_program_slept_longer(late, work, pause, place):
    pace = at(3)
    with pytest.raises(LoopStalled) as caught:
        pace.cycle(work, late)
    assert str(caught.value).startswith(
        f"the program was paused for {pause * P * 1e3:.1f} ms{place}: 6 ticks of"
    )


@pytest.mark.parametrize(("work", "skipped"), [(2.0, 1), (2.125, 2), (3.5, 3)])
@pytest.mark.parametrize("cycles", [0, MOST, MOST + 1])
def test_a_device_is_excused_for_some_cycles_after_two_missed_ticks(work, skipped, cycles):
    pace = at(3)
    pace.cycle(work)
    for _ in range(cycles):
        pace.cycle(0.5)
    pace.wake(pace.tick * P)
    blamed = pace.blame(BROKEN)
    if skipped < 2 or cycles > MOST:
        assert blamed is BROKEN
        return
    pause = skipped if cycles == 0 else work - 1.0  # until the next tick, or until it was done
    assert isinstance(blamed, LoopStalled)
    assert str(blamed) == (
        f"the program was paused for {pause * P * 1e3:.1f} ms, and then {BROKEN}"
    )
    assert len(pace.told) == 1  # nothing more was missed


@pytest.mark.parametrize(("late", "missed"), [(1.875, None), (2.0, 2), (2.875, 2), (3.0, 3)])
def test_a_device_is_excused_right_after_the_program_overslept(late, missed):
    pace = at(3)
    pace.wake((3 + late) * P)
    blamed = pace.blame(BROKEN)
    if missed is None:
        assert blamed is BROKEN and pace.told == []
        return
    assert str(blamed) == (f"the program was paused for {late * P * 1e3:.1f} ms, and then {BROKEN}")
    assert pace.told == [((3 + late) * P, "overrun", f"{missed} ticks missed", {"late": late * P})]


@pytest.mark.parametrize(("late", "missed"), [(0.5, 0), (1.0, 1), (1.5, 1)])
def test_ticks_missed_by_the_cycle_that_is_blamed_are_told(late, missed):
    pace = at(3)
    pace.cycle(2.125)
    pace.wake((pace.tick + late) * P)
    assert isinstance(pace.blame(BROKEN), LoopStalled)
    assert [event[2] for event in pace.told[1:]] == ["1 ticks missed"] * missed
    assert pace.run.missed == 2 + missed


def test_a_short_pause_does_not_lengthen_the_one_that_excuses():
    pace = at(3)
    pace.cycle(2.125)  # two ticks skipped by 1.125 periods
    pace.cycle(0.5)
    pace.wake((pace.tick + 1.75) * P)
    told = len(pace.told)
    assert f"paused for {1.125 * P * 1e3:.1f} ms" in str(pace.blame(BROKEN))
    assert len(pace.told) == told


@pytest.mark.parametrize(
    ("error", "excused"),
    [
        (StaleReading("encoder", 0.05, 0.03), True),
        (LimitExceeded("position", 2.0, -1.0, 1.0, "m"), False),
        (ZeroDivisionError(), False),
    ],
)
def test_only_what_a_device_does_is_excused(error, excused):
    pace = at(3)
    pace.wake(6 * P)
    assert (pace.blame(error) is not error) is excused
