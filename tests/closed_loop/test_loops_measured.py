"""A loop that is measured while it runs, on plants that are not as the profile says."""

import math
import random

import pytest

from rig.assembly import REGISTRY, Backend, make_law
from rig.config import load_profile
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.hal import ConfigurationError
from rig.hal.measured_loop import margins_of
from rig.mechanisms.cylinder.measured_loop import loop_of_run
from rig.report.data import load_run
from rig.tuning.workbench import Request, Workbench

DRAWN = random.Random(5517)
DEAD_TIME = 5  # ms, of the air; tube and monitor are late beside it
SEEDS = [DRAWN.randrange(10_000) for _ in range(3)]


def recorded(folder, *options):
    plan = load_plan("cylinder-margins", options)
    result = run_experiment(plan, Backend.SIM, folder, report=False)
    assert result.exit_code == 0, result.message
    return load_run(result.path)


def loop_of(run, *options):
    law = make_law(load_profile(run.folder.path / "profile.yaml", REGISTRY, options), "cascade")
    return loop_of_run(run, law)


@pytest.mark.parametrize("seed", SEEDS)
def test_dead_time_that_nobody_told_is_taken_from_the_delay_margin(seed, tmp_path):
    """At least what was added is lost; the linear model, which is told nothing, stays as it is.

    More of it, as a pair that swings more is slower at times, and sticks.
    """
    unit = f"simulation.seed={seed}"
    was, late = (
        loop_of(recorded(tmp_path, unit, f"plant.regulator.dead_time={time} ms"))
        for time in (DEAD_TIME, DEAD_TIME + 5)
    )
    assert was.margins.delay - late.margins.delay > 3e-3
    told = margins_of(was.frequencies, was.model)
    assert was.margins.delay == pytest.approx(told.delay, abs=8e-3)
    assert margins_of(late.frequencies, late.model).delay == pytest.approx(told.delay, rel=1e-2)
    assert late.margins.sensitivity > told.sensitivity


@pytest.mark.parametrize("seed", SEEDS)
def test_one_run_tells_what_other_gains_would_do(seed, tmp_path):
    """Predicted from a run with the gains in force, and measured in a run of those others."""
    others = ("controllers.cascade.position_rate=130", "controllers.cascade.velocity_rate=120")
    unit = f"simulation.seed={seed}"
    before = recorded(tmp_path, unit)
    foretold, found = loop_of(before, *others), loop_of(recorded(tmp_path, unit, *others))
    assert found.margins.sensitivity > loop_of(before).margins.sensitivity
    assert foretold.margins.sensitivity == pytest.approx(found.margins.sensitivity, rel=0.15)
    assert foretold.margins.crossover == pytest.approx(found.margins.crossover, rel=0.15)
    assert foretold.margins.delay == pytest.approx(found.margins.delay, rel=0.25)


def bench_of(*options):
    return Workbench(Request("cylinder", "cascade", None, options, None, 0))


@pytest.mark.parametrize("seed", SEEDS[:2])
def test_rig_tune_measures_what_rig_margins_measures(seed, tmp_path):
    """On a plant that is as told, and that a run has, too: by the bench as by the run's log."""
    bench = bench_of()
    told = bench.ensemble.nominal.numbers
    plant = bench.profile.plant.settings.believed(told)
    air = f"plant.regulator.dead_time={plant.regulator.dead_time} s"
    run = loop_of(recorded(tmp_path, f"simulation.seed={seed}", air)).margins
    (found,) = bench.measured({}, [bench.ensemble.nominal._replace(seed=seed)])
    assert found.sensitivity == pytest.approx(run.sensitivity, rel=0.08)
    assert found.crossover == pytest.approx(run.crossover, rel=0.1)


@pytest.mark.parametrize("seed", SEEDS[:2])
def test_rig_tune_sees_dead_time_that_the_law_is_not_told(seed):
    bench = bench_of()
    told = bench.ensemble.nominal._replace(seed=seed)
    late = {**told.numbers, "regulator_dead_time": told.numbers["regulator_dead_time"] + 6e-3}
    on_time, too_late = bench.measured({}, [told, told._replace(numbers=late)])
    assert too_late.sensitivity > 1.1 * on_time.sensitivity
    assert on_time.delay - too_late.delay > 4e-3


def test_a_loop_that_cannot_be_told_has_no_margin():
    """A pair that swings out while it glides, and one whose limits leave no room for glides."""
    bench = bench_of()
    wild = {"position_rate": 250.0, "velocity_rate": 700.0, "integral": 2e5}
    (found,) = bench.measured(wild, [bench.ensemble.nominal])
    assert found.sensitivity == math.inf
    narrow = bench_of("cylinder.limits.position=[-8 mm, 8 mm]")
    assert narrow.measured({}, [narrow.ensemble.nominal]) is None


def test_a_run_of_another_reference_tells_no_loop(tmp_path):
    plan = load_plan("cylinder-step", ("reference.dwell=1 s", "reference.rise=0.2 s"))
    run = load_run(run_experiment(plan, Backend.SIM, tmp_path, report=False).path)
    with pytest.raises(ConfigurationError, match="its reference is no probe"):
        loop_of(run)
