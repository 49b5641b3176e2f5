"""What is said of a regulator: whether it jumped, is alone, is slow, and who is told of."""

import pytest
from joint_fakes import CHANNELS
from pressure_bench import (
    CALM,
    CYCLES,
    DEVIATION,
    NEVER,
    START,
    Bench,
    pressure_bounds,
)  # fmt: skip

from rig.hal import SafetyError
from rig.mechanisms.pneumatic.alarms.bounds import PressureBounds
from rig.mechanisms.pneumatic.alarms.pressures import PressureWatch
from rig.mechanisms.pneumatic.settings import RegulatorModel

OFFSET = 12e3
JUMPED = ", or the monitor of ch2 has jumped"
SUPPLY = ", or the supply pressure is lost"


def ramp(bench, way, cycles):
    """Move channel 2 to `way` (Pa) off its setpoint in even steps, then wait until it is told."""
    for k in range(cycles):
        bench.pass_by(1, ch2=way * (k + 1) / cycles)
    with pytest.raises(SafetyError) as caught:
        bench.pass_by(2 * CYCLES, ch2=way)
    return str(caught.value)


@pytest.mark.parametrize("way", [50e3, -50e3])
def test_a_monitor_jumps_in_one_cycle_and_air_takes_a_few(way):
    calm = {"offset": OFFSET}
    assert JUMPED in ramp(Bench(**calm), way, 1)
    assert JUMPED not in ramp(Bench(**calm), way, 2)
    # By 0.7 of what it is off: what comes to it later, slowly, may be as much as the rest.
    for first, jumped in ((0.71, True), (0.69, False)):
        bench = Bench(**calm)
        bench.pass_by(1, ch2=first * way)
        assert (JUMPED in ramp(bench, way, 1)) is jumped


def test_the_greatest_jump_counts_and_not_the_last():
    bench = Bench(offset=OFFSET)
    bench.pass_by(1, ch2=-45e3)
    assert JUMPED in ramp(bench, -50e3, 1)
    bench = Bench(offset=OFFSET)
    bench.pass_by(1, ch2=-20e3)  # back by half of that, and on in small steps
    bench.pass_by(1, ch2=-30e3)
    assert JUMPED not in ramp(bench, -45e3, 2)


def test_a_jump_is_forgotten_when_the_pressure_is_back():
    bench = Bench(offset=OFFSET)
    bench.pass_by(1, ch2=-50e3)
    bench.pass_by(2)
    assert JUMPED not in ramp(bench, -45e3, 8)


def test_a_jump_is_no_news_where_it_is_usual():
    """A regulator that was off from the start has not jumped: it goes on from there slowly."""
    bench = Bench(offset=OFFSET)
    bench.pass_by(600, ch2=20e3)
    for k in range(8):
        bench.pass_by(1, ch2=20e3 + 150.0 * k)
    said = bench.watch.suspicion()
    assert "ch2" in said
    assert JUMPED not in said


def test_who_falls_below_the_others_may_have_lost_its_supply():
    alike = 0.5 * DEVIATION
    for over, alone in ((alike, True), (alike + 1.0, False)):
        # Where the worst one is after its fall, and who has most of the others.
        starts = (START, START + 90e3, START + 40e3 + over, START)
        bench = Bench(starts=starts)
        assert (SUPPLY in bench.what(ch2=-50e3)) is alone
    # One that has more is enough: it has it from the supply.
    assert SUPPLY not in Bench(starts=(START, START, START - 80e3, START - 80e3)).what(ch2=-50e3)


def test_a_tiny_rise_is_open_too():
    bench = Bench(deviation=0.5)
    bench.pass_by(3, ch2=0.8)
    said = bench.watch.suspicion()
    assert "the regulator of ch2 is stuck open" in said
    assert "jumped" not in said


def test_a_suspicion_gives_the_number_of_the_worst():
    bench = Bench()
    bench.pass_by(2, ch1=10e3, ch3=-30e3)
    assert "[ch3: -30 kPa off a healthy regulator" in bench.watch.suspicion()


@pytest.mark.parametrize("way", [50e3, -50e3])
def test_a_valve_is_called_a_valve(way):
    """Where an inner loop makes a regulator of it, nobody has a regulator to look at."""
    for calm in ({"offset": OFFSET}, {**CALM}):
        said = []
        for part in ("regulator", "valve"):
            bench = Bench(**calm)
            bench.watch = PressureWatch(
                pressure_bounds(**calm), RegulatorModel(dead_time=0.0), CHANNELS,
                "feed", part,
            )  # fmt: skip
            bench.watch.send(bench.starts)
            bench.pass_by(2000)
            with pytest.raises(SafetyError) as caught:
                bench.pass_by(4000, ch2=way)
            said.append(str(caught.value))
        assert "valve" in said[1]
        assert said[0].replace("regulator", "valve") == said[1]


@pytest.mark.parametrize("way", [0.02, -0.02])
def test_a_pressure_that_creeps_away_from_its_setpoint_may_be_of_what_is_stuck(way):
    """A spool that stays just off its middle: 20 Pa a cycle are 20 kPa in a second."""
    bench = Bench(**CALM)
    bench.pass_by(2000)
    with pytest.raises(SafetyError) as caught:
        for k in range(2000):
            bench.pass_by(1, ch2=1e3 * way * k)
    assert "valves: the regulator of ch2 is stuck or off, or its monitor is off" in str(
        caught.value
    )


def test_no_channels_are_no_suspicion():
    bounds = PressureBounds(0.5, 1.0, 0.5, 1.0, NEVER, NEVER, 0.0)
    assert PressureWatch(bounds, RegulatorModel(), CHANNELS, "valves").suspicion() is None
