"""What a pair does for the loop besides reading, limiting and writing: words, stop, memory."""

import math
import random
from dataclasses import replace

import numpy as np
import pytest
from pneumatic_fakes import (
    BASE,
    HIGHEST,
    LOWEST,
    MISMATCH,
    PERIOD,
    REACH,
    TINY,
    PairBench,
    pair_settings,
)

from controllers.cylinder.pid import Pid, PidSettings
from controllers.cylinder.types import PairCommand, PairReference, PairState
from rig.hal import EmergencyStop, LimitExceeded, SafetyError
from rig.mechanisms.cylinder import hindsight
from rig.mechanisms.cylinder.mechanism import AntagonisticPair
from rig.mechanisms.pneumatic import hunting

STILL = PairReference(0.0, 0.0, 0.0)
EASY = PairCommand(BASE, BASE)


class Believing:
    """A controller of which only the estimate is asked."""

    estimate = (0.25, -3.0)


def swing(bench, times, amplitude=2e-3, half_period=64):
    """Let the pair swing about a reference that stands still; return the time."""
    now = 0.0
    for k in range(times * half_period):
        now = k * PERIOD
        bench.move_to(amplitude * math.cos(math.pi * k / half_period))
        bench.cycle(now)
        bench.pair.check_command(STILL, EASY)
    return now


def beyond(bench, now):
    """Put the pair beyond its limit; return the fault and the state."""
    bench.move_to(REACH + TINY)
    bench.refresh(now)
    state = bench.pair.read(now)
    with pytest.raises(LimitExceeded) as caught:
        bench.pair.check(state, now)
    return caught.value, state


def test_a_pair_that_moves_while_its_chambers_fill_is_a_fault():
    bench = PairBench()
    bench.cycle(0.0)
    bench.pair.check_still(STILL)
    bench.move_to(1.01 * pair_settings().limits.following)
    bench.cycle(PERIOD)
    with pytest.raises(LimitExceeded, match="way of the pair while nothing controls it"):
        bench.pair.check_still(STILL)


def test_a_pair_that_follows_nothing_may_move_by_a_tenth_of_its_range_while_they_fill():
    limits = pair_settings().limits
    low, high = limits.position
    bench = PairBench(pair_settings(replace(limits, following=high - low)))
    for k, share in enumerate((0.09, 0.11)):
        bench.cycle(2 * k * PERIOD)
        bench.move_to(share * (high - low))
        bench.cycle((2 * k + 1) * PERIOD)
        if share < 0.1:
            bench.pair.check_still(STILL)
            continue
        with pytest.raises(LimitExceeded, match="way of the pair while nothing controls it"):
            bench.pair.check_still(STILL)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_pair_that_is_released_strays_beyond_what_it_may_be_off(side):
    pair, most = PairBench().pair, pair_settings().limits.following
    ways = [pair.strays(PairState(0.0, 2e-3 + side * k * most, 0.0, 0.0)) for k in (0, 0.99, 1.01)]
    assert ways == [False, False, True]


@pytest.mark.parametrize(("k", "chamber"), [(0, "agonist"), (1, "antagonist")])
def test_a_chamber_whose_monitor_has_jumped_is_not_known_to_be_vented(k, chamber):
    bench = PairBench()
    for cycle in range(3):
        bench.cycle(cycle * PERIOD)
    assert bench.pair.unsafe(3 * PERIOD) == ""
    bench.pair._watch.pressures.jumps[k] = -500e3
    assert f": {chamber} still holds " in bench.pair.unsafe(4 * PERIOD)


# The cause of a fault --------------------------------------------------------------------------


def test_a_limit_that_is_exceeded_in_the_first_cycle_is_told_as_it_is():
    bench = PairBench()
    fault, state = beyond(bench, 0.0)
    assert bench.pair.explain(fault, state) is fault


@pytest.mark.usefixtures("moved_by_hand")
def test_a_limit_that_is_exceeded_by_a_swing_is_told_with_the_swing():
    bench = PairBench()
    now = swing(bench, 3)
    fault, state = beyond(bench, now + PERIOD)
    told = bench.pair.explain(fault, state)
    assert isinstance(told, SafetyError)
    assert str(told).startswith("the pair oscillates at 8.")
    assert str(told).endswith(f"({fault})")
    assert "; or regulators: the chamber of " in str(told)  # nothing pulls it to and fro here
    bench.pair._watch.restart()
    assert str(bench.pair.explain(fault, state)).endswith(f"and dead time ({fault})")
    # What else stops a swinging pair is not the swing's doing.
    stop = EmergencyStop("stop")
    assert bench.pair.explain(stop, state) is stop


@pytest.mark.usefixtures("moved_by_hand")
def test_what_swung_before_a_new_start_is_forgotten():
    bench = PairBench()
    now = swing(bench, 3)
    bench.pair.start_limiting(PairState(now, 0.0, BASE, BASE))
    fault, state = beyond(bench, now + PERIOD)
    assert bench.pair.explain(fault, state) is fault


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_pair_that_does_not_follow_is_a_fault_after_its_time(way):
    bench = PairBench()
    settings = pair_settings()
    off, lost = settings.limits.following, settings.alarms.oscillation.lost
    bench.cycle(0.0)
    bench.pair.check_command(STILL, EASY)
    away = PairReference(way * (off + 1e-6), 0.0, 0.0)
    for k in range(1, int(lost / PERIOD) + 1):
        bench.cycle(k * PERIOD)
        bench.pair.check_command(away, EASY)
    bench.cycle(lost + 2.0 * PERIOD)
    with pytest.raises(LimitExceeded, match="following error of the pair"):
        bench.pair.check_command(away, EASY)


@pytest.mark.parametrize("k", [0, 1])
def test_a_pressure_that_no_controller_may_ask_for_names_the_chamber(k):
    bench = PairBench()
    bench.cycle(0.0)
    asked = [BASE, BASE]
    asked[k] = 11.0 * HIGHEST
    with pytest.raises(SafetyError, match=f"command of {('agonist', 'antagonist')[k]} is"):
        bench.pair.check_command(STILL, PairCommand(*asked))


def test_a_chamber_that_does_not_follow_its_setpoint_names_the_regulators():
    """The watch has to be told what was sent: what is asked for is not what is applied."""
    bench = PairBench()
    bench.pair.start_limiting(PairState(0.0, 0.0, BASE, BASE))
    with pytest.raises(SafetyError, match="agonist"):
        for k in range(1024):
            bench.cycle(k * PERIOD)
            bench.pair.write(PairCommand(HIGHEST, BASE))


def test_the_log_is_asked_for_a_cause_only_where_pneumatics_may_have_one(monkeypatch):
    bench = PairBench()
    asked = []
    monkeypatch.setattr(hindsight, "pair_suspects", lambda *given: asked.append(given) or ("a",))
    assert bench.pair.diagnose(EmergencyStop("stop"), np.zeros) == ()
    assert bench.pair.diagnose(LimitExceeded("x", 1.0, 0.0, 0.5, "m"), np.zeros) == ("a",)
    assert asked == [(np.zeros, bench.pair.settings)]


def test_a_log_is_asked_whether_the_pair_came_to_rest(monkeypatch):
    asked = []
    monkeypatch.setattr(
        hunting, "remarks_on_hunting", lambda *given: asked.append(given) or ("hunts",)
    )
    assert PairBench().pair.remarks(np.zeros) == ("hunts",)
    assert asked == [(np.zeros, {"the pair": ("reference.position", "reading.position")})]


# Stop ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("measured", "mean"),
    [
        ((200e3, 300e3), 250e3),
        ((300e3, 200e3), 250e3),
        ((0.0, LOWEST), LOWEST),
        ((HIGHEST, HIGHEST + 2.0), HIGHEST),
    ],
)
def test_balanced_both_chambers_hold_the_mean_within_what_is_permitted(measured, mean):
    assert PairBench().pair.balanced_command(PairState(0.0, 0.0, *measured)) == (mean, mean)


@pytest.mark.parametrize("seed", range(10))
def test_a_slowed_reference_is_the_same_way_at_another_pace(seed):
    """Differences of x(s(t)) with s' = rate, s'' = change are the oracle."""
    chance = random.Random(seed)
    x, v, a, rate, change = (chance.uniform(-2.0, 2.0) for _ in range(5))
    slowed = AntagonisticPair.slow_down(PairReference(x, v, a), rate, change)

    def way(t):
        s = rate * t + 0.5 * change * t * t
        return x + v * s + 0.5 * a * s * s

    step = 1e-4
    speed = (way(step) - way(-step)) / (2.0 * step)
    bend = (way(step) - 2.0 * way(0.0) + way(-step)) / step**2
    assert slowed == pytest.approx((x, speed, bend), abs=1e-5)
    two = (PairReference(way(t), 0.0, 0.0) for t in (-step, step))
    assert AntagonisticPair.pace_between(*two, 2.0 * step) == pytest.approx(abs(speed), abs=1e-6)


# What others ask -------------------------------------------------------------------------------


def test_before_a_run_it_says_what_a_cut_wire_and_an_alarm_come_to():
    told = {expected.name: expected for expected in AntagonisticPair.expected_of(pair_settings())}
    assert told["alarm: a pressure off a healthy regulator by"].unit == "Pa"
    assert any("wire" in what for what in told)


def test_the_chambers_are_those_of_rods_that_read_nought():
    settings = pair_settings()
    empty = settings.dead_volume + settings.area * settings.stroke
    assert AntagonisticPair.constants_of(settings) == {
        "area": settings.area,
        "volume_agonist": empty,
        "volume_antagonist": empty,
    }


def test_margins_are_known_of_laws_of_ours_alone():
    settings = pair_settings()
    law = Pid(PidSettings(), AntagonisticPair.model_of(settings), PERIOD)
    loop = AntagonisticPair.closed_loop(settings, law)
    assert loop is not None
    assert loop.crossover > 0.0
    assert AntagonisticPair.closed_loop(settings, Believing()) is None


def test_it_may_be_sent_within_its_limits():
    targets = AntagonisticPair.targets(pair_settings(), None)
    targets.check(targets.rest([REACH]))
    with pytest.raises(ValueError, match=r"outside limits\.position"):
        targets.check(targets.rest([REACH + TINY]))


def test_the_log_has_what_the_controller_believes():
    bench = PairBench()
    bench.pair.attach(Believing(), None)
    row = bench.pair.row(bench.cycle(0.0), STILL, EASY, EASY)
    named = dict(zip([column.name for column in bench.pair.columns], row, strict=True))
    assert (named["estimate.velocity"], named["estimate.disturbance"]) == Believing.estimate


@pytest.mark.parametrize("seed", range(5))
def test_what_was_logged_is_recalled_as_it_was(seed):
    chance = random.Random(seed)
    bench, again = PairBench(), PairBench()
    position = chance.uniform(-REACH, REACH)
    bench.place(-position, position + chance.uniform(-0.5, 0.5) * MISMATCH)
    bench.regulators.reads = (chance.uniform(LOWEST, HIGHEST), chance.uniform(LOWEST, HIGHEST))
    bench.refresh(7.0 - 0.25 * PERIOD)
    state = bench.pair.read(7.0)
    row = bench.pair.row(state, STILL, EASY, EASY)
    logged = dict(zip([column.name for column in bench.pair.columns], row, strict=True))
    again.stop.pressed = True  # of another day: it is not asked
    recalled = again.pair.recall({**logged, "clock": 7.0})
    assert recalled == state
    again.pair.check(recalled, 7.0)
    assert again.pair.row(recalled, STILL, EASY, EASY) == row


@pytest.mark.parametrize("seed", range(4))
def test_chambers_are_vented_no_faster_than_seals_hold_what_regulators_differ_by(seed):
    """By an integration of our own, of a regulator as the profile has it beside its setpoint."""
    drawn = random.Random(seed)
    base = pair_settings()
    friction = replace(base.friction, coulomb=drawn.uniform(4.0, 12.5))
    response = replace(base.regulator_response, bandwidth=drawn.uniform(20.0, 60.0), damping=1.0)
    settings = replace(base, friction=friction, regulator_response=response)
    bench = PairBench(settings)
    start = drawn.uniform(100e3, 0.9 * HIGHEST)
    time = bench.pair.releasing_time(PairCommand(0.5 * start, start))
    assert bench.pair.releasing_time(PairCommand(start, 0.5 * start)) == time
    rate, held = start / time, friction.coulomb / settings.area
    pressure, slope, step = start, 0.0, 1e-4
    for k in range(round(time / step)):
        acting = start - rate * max(k * step - response.dead_time, 0.0)
        pull = response.bandwidth**2 * (acting - pressure) - 2.0 * response.bandwidth * slope
        slope += step * pull
        pressure += step * slope
        assert pressure - (start - rate * k * step) < 0.51 * held


def test_nobody_waits_for_a_release_for_long():
    base = pair_settings()
    for coulomb in (1e-3, 0.0):
        settings = replace(base, friction=replace(base.friction, coulomb=coulomb))
        assert PairBench(settings).pair.releasing_time(EASY) == 3.0
