"""What may be left in chambers whose monitors were seen to lie."""

import pytest
from joint_fakes import CHANNELS
from pressure_bench import NEVER, START, STEP, pressure_bounds

from rig.hal import SafetyError
from rig.hal.devices import HARMLESS, VENTED
from rig.mechanisms.pneumatic.alarms.pressures import PressureWatch
from rig.mechanisms.pneumatic.alarms.vented import explain_left
from rig.mechanisms.pneumatic.settings import RegulatorModel

SAFE = (0.0,) * 4
JUMP = 60e3


class Rig:
    """Four chambers, and monitors that may say less than there is."""

    def __init__(self):
        bounds = pressure_bounds(deviation=NEVER, slow=NEVER, offset=8e3, time=NEVER)
        self.watch = PressureWatch(bounds, RegulatorModel(), CHANNELS, "valves")
        self.now, self.cycle = 0.0, 0
        self.there, self.off = [START, 70e3, 65e3, 240e3], [0.0] * 4

    def read(self):
        """Return what the monitors say now; the last digit is never still."""
        self.now += STEP
        self.cycle += 1
        return tuple(p + o + self.cycle % 3 for p, o in zip(self.there, self.off, strict=True))

    def run(self, cycles):
        """Return the first thing that is raised in so many cycles of the run."""
        for _ in range(cycles):
            self.watch.send(self.there)
            try:
                self.watch.check(self.read(), self.now)
            except SafetyError as error:
                return str(error)
        return ""

    def stop(self, cycles, stuck=()):
        """Vent all chambers but those that are stuck; return what is said in the end."""
        said = ""
        for _ in range(cycles):
            for k in range(4):
                self.there[k] *= 1.0 if k in stuck else 0.97
            said = explain_left(self.watch, self.read(), SAFE, self.now)
        return said


@pytest.fixture
def rig():
    """Return a rig that has run for a while."""
    found = Rig()
    assert found.run(20) == ""
    return found


def test_healthy_chambers_are_empty(rig):
    assert rig.stop(400) == ""


def test_a_monitor_that_jumped_in_the_run_hides_what_is_stuck_behind_it(rig):
    rig.off[2] = -JUMP
    assert "monitor of ch3 has jumped" in rig.run(10)
    said = rig.stop(400, stuck=[2])
    assert said.startswith("valves: ch3 still holds 65.0 kPa: its monitor says ")
    assert said.endswith("but has jumped by -60 kPa")


@pytest.mark.parametrize(
    ("there", "jump", "said"),
    [
        (HARMLESS - 200.0, -0.99 * (HARMLESS - VENTED), ""),
        (HARMLESS + 500.0, -1.1 * (HARMLESS - VENTED), "ch3 still holds 20.5 kPa: its monitor "),
    ],
)
def test_a_small_jump_stops_nobody_and_hides_no_more_than_is_harmless(there, jump, said):
    rig = Rig()
    rig.there[2] = there
    assert rig.run(20) == ""
    rig.off[2] = jump
    assert rig.run(10) == ""
    left = rig.stop(400, stuck=[2])
    assert said in left and bool(left) is bool(said)


def test_what_jumps_back_in_the_run_hides_nothing(rig):
    small = 1.5 * (HARMLESS - VENTED)
    for off in (small, 0.0):
        rig.off[2] = off
        assert rig.run(10) == ""
    assert rig.watch.jumps[2] == pytest.approx(0.0, abs=10.0)
    assert rig.stop(400) == ""


def test_a_monitor_that_jumped_and_a_chamber_that_is_vented_are_safe(rig):
    rig.off[2] = -JUMP
    rig.run(10)
    assert rig.stop(400) == ""


@pytest.mark.parametrize("cycles", [0, 1, 3, 30])
def test_a_monitor_that_jumps_in_the_stop_hides_it_as_well(rig, cycles):
    rig.stop(cycles, stuck=[1])
    rig.off[1] = -JUMP
    assert "ch2 still holds 70.0 kPa: its monitor says 10.0 kPa" in rig.stop(400, stuck=[1])


def test_two_that_jumped_are_both_named(rig):
    rig.stop(3, stuck=[0, 3])
    rig.off[0] = -150e3
    rig.stop(5, stuck=[0, 3])
    rig.off[3] = -230e3
    said = rig.stop(400, stuck=[0, 3])
    assert "ch1 still holds 200.0 kPa" in said
    assert "ch4 still holds 240.0 kPa" in said


@pytest.mark.parametrize("cycles", [3, 10])
def test_what_jumped_up_again_hides_nothing(rig, cycles):
    rig.off[2] = -JUMP
    rig.run(10)
    rig.stop(cycles)
    rig.off[2] = 0.0
    assert rig.stop(400) == ""


def test_what_says_less_than_nothing_knows_nothing(rig):
    rig.stop(400)
    for slowly in range(40):
        rig.off[3] = -500.0 * slowly
        said = rig.stop(1)
    assert said == (
        "valves: ch4 still holds nobody knows what: its monitor says -19.5 kPa, as no chamber can"
    )


def test_nothing_was_ever_read():
    watch = PressureWatch(pressure_bounds(), RegulatorModel(), CHANNELS, "valves")
    assert explain_left(watch, SAFE, SAFE, 0.0) == ""


class Told:
    """A watch whose monitors have jumped by so much."""

    device, names = "valves", ("ch1", "ch2")

    def __init__(self, *jumps):
        self.jumps = jumps

    def follow_stop(self, pressures, setpoints, now):
        """Nothing jumps meanwhile."""


@pytest.mark.parametrize(
    ("jump", "shown", "safe", "named"),
    [
        (0.0, 50e3, 0.0, False),  # its regulators say that themselves
        (-40e3, VENTED - 40e3, 0.0, False),
        (-40e3, VENTED - 40e3 + 1.0, 0.0, True),
        (-40e3, VENTED + 60e3, 100e3, False),  # it is to hold as much
        (-40e3, VENTED + 61e3, 100e3, True),
        (0.0, -VENTED, 0.0, False),
        (0.0, -VENTED - 1.0, 0.0, True),
        (-40e3, -VENTED - 40e3 - 1.0, 0.0, True),
    ],
)
def test_more_than_a_vented_chamber_may_hold_is_told_and_no_less(jump, shown, safe, named):
    said = explain_left(Told(0.0, jump), (0.0, shown), (0.0, safe), 1.0)
    assert ("ch2 still holds" in said) == named
    assert "ch1" not in said
