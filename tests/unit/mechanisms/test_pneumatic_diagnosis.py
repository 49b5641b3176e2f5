"""Causes that are drawn into made-up signals are found again, with their figures.

The signals come from scipy's solution of a second order, and not from what fits them.
"""

import math

import numpy as np
import pytest
from pneumatic_fakes import pair_settings
from scipy.signal import lsim

from rig.mechanisms.pneumatic.diagnosis.evidence import Signals, gather
from rig.mechanisms.pneumatic.diagnosis.ranking import likeliest, rank
from rig.mechanisms.pneumatic.diagnosis.words import suspect_of

SEEDS = range(3)
NAMES, PAIRS = ("one", "two"), ((0, 1),)
STEP, LASTS = 1e-3, 2.0
T = STEP * np.arange(round(LASTS / STEP))
BANDWIDTH, DEAD_TIME = 40.0, 5e-3


def drawn_setpoints(rng):
    """Return setpoints of two chambers that pull against each other, with jumps, Pa."""
    waves = sum(
        rng.uniform(5e3, 20e3) * np.sin(math.tau * (f * T + rng.uniform())) for f in (0.5, 1.3, 3.1)
    )
    jumps = 15e3 * np.sign(np.sin(math.tau * (7.0 * T + rng.uniform())))
    return 150e3 + np.column_stack([waves + jumps, -waves - jumps])


def answered(setpoints, bandwidth=BANDWIDTH, dead_time=DEAD_TIME):
    late = np.interp(T - dead_time, T, setpoints)
    system = ([bandwidth**2], [1.0, 2.0 * bandwidth, bandwidth**2])
    _, found, _ = lsim(system, late - late[0], T)
    return late[0] + found


class Bench:
    """A pair at rest whose regulators are as the profile says, until a test spoils one."""

    def __init__(self, seed):
        self.rng = np.random.default_rng([20, seed])
        self.setpoints = drawn_setpoints(self.rng)
        self.pressures = np.column_stack([answered(row) for row in self.setpoints.T])
        self.extensions = np.full((len(T), 2), 30e-3)
        self.channel = int(self.rng.integers(2))
        self.since = LASTS - self.rng.uniform(0.3, 0.7)
        self.after = self.since <= T

    def spoil(self, pressure):
        self.pressures[:, self.channel] = np.where(
            self.after, pressure, self.pressures[:, self.channel]
        )

    def found(self):
        noise = 250.0 * self.rng.standard_normal(self.pressures.shape)
        signals = Signals(
            T, self.setpoints, self.pressures + noise, self.extensions, *np.zeros((2, len(T), 1))
        )
        evidence = gather(signals, NAMES, PAIRS, pair_settings())
        return [suspect_of(trial, evidence) for trial in likeliest(rank(evidence))]


@pytest.mark.parametrize("seed", SEEDS)
def test_regulators_that_are_well_are_suspected_of_nothing(seed):
    assert Bench(seed).found() == []


@pytest.mark.parametrize("seed", SEEDS)
def test_a_slow_regulator_is_found_with_its_bandwidth(seed):
    bench = Bench(seed)
    slow = BANDWIDTH * bench.rng.uniform(0.3, 0.6)
    bench.after[:] = True
    bench.spoil(answered(bench.setpoints[:, bench.channel], bandwidth=slow))
    (found,) = bench.found()
    assert (found.cause, found.of, found.unit) == ("slow", NAMES[bench.channel], "rad/s")
    assert found.value == pytest.approx(slow, rel=0.05)
    assert found.sentence == (
        f"regulator of {found.of}: the profile says 40 rad/s, I see {found.value:.3g} rad/s"
    )


@pytest.mark.parametrize("seed", SEEDS)
def test_regulators_that_are_all_slow_or_all_late_are_said_to_be(seed):
    slow, late = Bench(seed), Bench(seed)
    bandwidth = BANDWIDTH * slow.rng.uniform(0.3, 0.6)
    slow.pressures = np.column_stack([answered(row, bandwidth) for row in slow.setpoints.T])
    dead_time = DEAD_TIME + late.rng.uniform(5e-3, 25e-3)
    late.pressures = np.column_stack(
        [answered(row, dead_time=dead_time) for row in late.setpoints.T]
    )
    for bench, cause, figure in ((slow, "slow", bandwidth), (late, "late", dead_time)):
        first, *_ = bench.found()
        assert (first.cause, first.of) == (cause, "")
        assert first.value == pytest.approx(figure, rel=0.1)
    assert first.sentence.startswith("all regulators: the profile says 5 ms of dead time, I see ")


@pytest.mark.parametrize("seed", range(8))
def test_regulators_that_answer_sooner_than_told_are_no_cause(seed):
    """A profile says the dead time of the worst channel: the others are sooner, and healthy."""
    bench = Bench(seed)
    sooner = bench.rng.uniform(0.0, 1e-3)
    bench.pressures = np.column_stack(
        [answered(row, dead_time=sooner) for row in bench.setpoints.T]
    )
    assert not [one for one in bench.found() if one.cause == "late"]


def is_suspected(found, cause, of):
    return any((suspect.cause, suspect.of) == (cause, of) for suspect in found)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_regulator_that_is_stuck_is_told_from_one_that_leaks_and_one_that_is_open(seed):
    for cause, change in (("stuck", 0.0), ("leak", -120e3), ("open", 200e3)):
        bench = Bench(seed)
        held = bench.pressures[np.argmax(bench.after), bench.channel]
        gone = -np.expm1(-np.maximum(T - bench.since, 0.0) / 10e-3)
        bench.spoil(held + change * gone)
        assert is_suspected(bench.found(), cause, NAMES[bench.channel]), cause


@pytest.mark.parametrize("seed", SEEDS)
def test_a_chamber_that_is_shut_is_stuck_though_its_piston_changes_its_pressure(seed):
    bench = Bench(seed)
    bench.extensions[:, bench.channel] += 4e-3 * np.sin(math.tau * 1.5 * T)
    settings = pair_settings()
    volume = settings.dead_volume + settings.area * (
        settings.stroke - bench.extensions[:, bench.channel]
    )
    start = np.argmax(bench.after)
    begun = bench.pressures[start, bench.channel] + 101_325.0
    bench.spoil(begun * (volume[start] / volume) ** 1.2 - 101_325.0)
    assert is_suspected(bench.found(), "stuck", NAMES[bench.channel])


@pytest.mark.parametrize("seed", SEEDS)
def test_a_supply_that_is_low_bounds_all_chambers(seed):
    bench = Bench(seed)
    level = bench.rng.uniform(80e3, 130e3)
    bench.pressures = np.where(
        bench.after[:, None], np.minimum(bench.pressures, level), bench.pressures
    )
    (found,) = bench.found()
    assert (found.cause, found.of) == ("supply", "")
    assert found.value == pytest.approx(level, abs=6e3)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_monitor_that_jumps_is_found_with_its_offset(seed):
    bench = Bench(seed)
    jump = bench.rng.uniform(22e3, 60e3) * bench.rng.choice([-1.0, 1.0])
    bench.spoil(bench.pressures[:, bench.channel] + jump)
    found = bench.found()
    assert is_suspected(found, "monitor", NAMES[bench.channel])
    (monitor,) = [suspect for suspect in found if suspect.cause == "monitor"]
    assert monitor.value == pytest.approx(jump, rel=0.15)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_pair_that_moves_against_its_pull_has_a_chamber_that_pulls_less(seed):
    """The pair goes to one side at 100 mm/s though its pressures hold it where it is."""
    bench = Bench(seed)
    bench.setpoints = 150e3 + 0.3 * (bench.setpoints - 150e3)
    bench.pressures = np.column_stack([answered(row) for row in bench.setpoints.T])
    way = 100e-3 * np.maximum(T - bench.since, 0.0)
    sign = 1.0 if bench.channel == 0 else -1.0
    bench.extensions += np.column_stack([sign * way, -sign * way])
    found = bench.found()
    assert is_suspected(found, "pull", NAMES[bench.channel]), found


@pytest.mark.parametrize("seed", SEEDS)
def test_more_friction_is_told_from_slow_regulators(seed):
    """The pressures do what they should, and the pair slides as if its seals held more."""
    bench = Bench(seed)
    scale = bench.rng.uniform(2.0, 3.0)
    friction, area = pair_settings().friction, pair_settings().area
    wave = 110e3 * np.sin(math.tau * (0.9 * T + bench.rng.uniform()))
    bench.setpoints = 200e3 + np.column_stack([wave, -wave])
    bench.pressures = np.column_stack([answered(row) for row in bench.setpoints.T])
    force = area * (bench.pressures[:, 0] - bench.pressures[:, 1])
    beyond = np.maximum(np.abs(force) - scale * friction.coulomb, 0.0)
    position = STEP * np.cumsum(np.sign(force) * beyond / (scale * friction.viscous))
    bench.extensions += np.column_stack([-position, position])
    found = bench.found()
    assert [suspect.cause for suspect in found] == ["friction"]
    assert found[0].value == pytest.approx(scale, rel=0.15)


def test_a_log_of_a_moment_says_nothing():
    bench = Bench(0)
    few = slice(0, 50)
    signals = Signals(
        T[few], bench.setpoints[few], bench.pressures[few], bench.extensions[few],
        np.zeros((50, 1)), np.zeros((50, 1)),
    )  # fmt: skip
    assert gather(signals, NAMES, PAIRS, pair_settings()) is None
