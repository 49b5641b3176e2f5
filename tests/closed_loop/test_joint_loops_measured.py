"""The loop of a joint's pair that is measured while the ring glides, on plants that differ."""

import math
import random

import pytest

from rig.assembly import REGISTRY, Backend, make_law
from rig.config import load_profile
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.hal import ConfigurationError
from rig.mechanisms.joint.measured_loop import loop_of_run
from rig.report.data import load_run
from rig.tuning.workbench import Request, Workbench

DRAWN = random.Random(3317)
SEEDS = [DRAWN.randrange(10_000) for _ in range(2)]


def recorded(folder, *options, rig="joint"):
    plan = load_plan("joint-margins", options, rig=rig)
    return run_experiment(plan, Backend.SIM, folder, report=False)


def loop_of(result, *options, law="cascade"):
    assert result.exit_code in (0, 1), result.message
    run = load_run(result.path)
    return loop_of_run(run, make_law(load_profile(run.folder.path / "profile.yaml", REGISTRY,
                                                  options), law))  # fmt: skip


@pytest.mark.parametrize("azimuth", ["0 deg", "90 deg"])
@pytest.mark.parametrize("seed", SEEDS)
def test_dead_time_that_nobody_told_is_taken_from_the_delay_margin(seed, azimuth, tmp_path):
    """Of either pair; of 10 ms at least 2: a ring whose air comes late is slower as well."""
    unit = (f"simulation.seed={seed}", f"reference.azimuth={azimuth}")
    was, late = (
        loop_of(recorded(tmp_path / f"{time}", *unit, f"plant.regulator.dead_time={time} ms"))
        for time in (5, 15)
    )
    assert was.margins.delay - late.margins.delay > 2e-3
    assert late.margins.sensitivity > 1.05 * was.margins.sensitivity
    assert was.margins.crossover == pytest.approx(28.0, rel=0.15)  # rad/s; linear model: 39
    assert 1.4 < was.margins.sensitivity < 3.0


STIFF = {
    "ball_friction": 1.24, "friction_distance": 33.96e-6, "pair.position_rate": 111.0,
    "pair.velocity_rate": 132.8, "pair.integral": 9627.0, "pair.hold_integral": 129.8,
    "pair.observer_bandwidth": 714.4, "pair.force_trust": 0.09887, "pair.lead_bandwidth": 204.6,
    "pair.disturbance_gain": 0.02879, "pair.disturbance_bandwidth": 41.06,
    "pair.anticipation": 0.281, "pair.feedforward.gain": 1.035,
    "pair.feedforward.distance": 2.003e-6, "pair.feedforward.learning_rate": 0.05122,
    "pair.feedforward.error_rate": 0.08454,
}  # fmt: skip
"""Gains that `joint` had before its own, with a sensitivity of 2.1 to 2.6, measured."""


@pytest.mark.parametrize("seed", SEEDS)
def test_gains_that_a_run_foretells_to_swing_do(seed, tmp_path):
    """With less of both rates the linear model has a longer delay margin, and the ring swings."""
    stiff = tuple(f"controllers.cascade.{name}={value}" for name, value in STIFF.items())
    soft = (
        f"controllers.cascade.pair.position_rate={0.7 * STIFF['pair.position_rate']}",
        f"controllers.cascade.pair.velocity_rate={0.8 * STIFF['pair.velocity_rate']}",
    )
    unit = (f"simulation.seed={seed}", *stiff)
    before = recorded(tmp_path / "before", *unit)
    foretold = loop_of(before, *soft).margins
    assert foretold.sensitivity > 1.5 * loop_of(before).margins.sensitivity
    assert recorded(tmp_path / "soft", *unit, *soft).exit_code != 0


def test_what_tells_no_loop_is_a_sentence(tmp_path):
    short = ("reference.tones=[{frequency: 0.5 Hz, laps: 1}]", "metrics={}", "figures=[]")
    plan = load_plan("joint-circle", short)
    run = load_run(run_experiment(plan, Backend.SIM, tmp_path / "circle", report=False).path)
    with pytest.raises(ConfigurationError, match="its reference is no joint-probe"):
        loop_of_run(run, object())
    probed = recorded(tmp_path / "few", "reference.repeats=2")
    with pytest.raises(ConfigurationError, match="4 whole glides, and 6 are needed"):
        loop_of(probed)
    with pytest.raises(ConfigurationError, match="what is linear of object is not known"):
        loop_of_run(load_run(probed.path), object())


def bench_of(rig="joint", *options):
    return Workbench(Request(rig, "cascade", None, options, None, 0))


@pytest.mark.parametrize("rig", ["joint", "joint-valves"])
def test_rig_tune_measures_what_rig_margins_measures(rig, tmp_path):
    """On a plant that is as told, and that a run has, too: by the bench as by the run's log."""
    bench = bench_of(rig)
    told = bench.ensemble.nominal
    settings = bench.profile.plant.settings.believed(told.numbers)
    unit = [f"simulation.seed={SEEDS[1]}"]
    if rig == "joint":
        unit.append(f"plant.regulator.dead_time={settings.regulator.dead_time} s")
    run = loop_of(recorded(tmp_path, *unit, rig=rig)).margins
    found = bench.measured({}, [told._replace(seed=seed) for seed in SEEDS])
    assert min(one.sensitivity for one in found) < 1.25 * run.sensitivity
    assert max(one.sensitivity for one in found) > 0.8 * run.sensitivity
    assert found[1].crossover == pytest.approx(run.crossover, rel=0.15)


def test_rig_tune_sees_dead_time_that_the_law_is_not_told():
    bench = bench_of()
    told = bench.ensemble.nominal._replace(seed=SEEDS[1])
    late = {**told.numbers, "regulator_dead_time": told.numbers["regulator_dead_time"] + 8e-3}
    on_time, too_late = bench.measured({}, [told, told._replace(numbers=late)])
    assert too_late.sensitivity > 1.05 * on_time.sensitivity
    assert on_time.delay - too_late.delay > 2e-3


def test_a_loop_that_cannot_be_told_has_no_margin():
    """A ring that swings out, one that is hardly led, and one whose limits leave no room."""
    bench = bench_of()
    wild = {"position_rate": 250.0, "velocity_rate": 700.0, "integral": 2e5}
    weak = {"position_rate": 60.0, "velocity_rate": 60.0}  # its gain is 1 below what is shaken
    for rates in (wild, weak):
        gains = {f"pair.{name}": value for name, value in rates.items()}
        (found,) = bench.measured(gains, [bench.ensemble.nominal])
        assert found.sensitivity == math.inf
    narrow = bench_of("joint", "joint.limits.tilt=40 deg")
    assert narrow.measured({}, [narrow.ensemble.nominal]) is None
