"""The shipped experiments of the legs: every number that the lab was promised, as a bound.

The bounds are those of the experiments' own files; what depends on the law is given here.
"""

import math

import numpy as np
import pytest
from legs_bench import CONFIGS

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment

RATES = {"inverse": 7.2, "sc": 0.347, "sc-trapezoid": 0.248, "sc-smooth": 0.226}
"""Greatest knee rate of the base case, rad/s, as a plan at 1 kHz has it."""


def measure(tmp_path, name, *options, backend=Backend.SIM):
    """Return an experiment's metrics by name; every bound has held."""
    plan = load_plan(name, list(options), configs=CONFIGS)
    result = run_experiment(plan, backend, tmp_path, report=False)
    missed = [metric for metric in result.metrics if metric.passed is False]
    assert (missed, result.message, result.exit_code) == ([], None, 0)
    return {metric.name: metric.value for metric in result.metrics}


def test_legs_walk_within_its_bounds(tmp_path):
    found = measure(tmp_path, "legs-walk")
    assert found["peak_knee_rate"] == pytest.approx(RATES["sc-smooth"], rel=0.02)
    assert found["advance"] == pytest.approx(0.120, abs=1e-5)
    assert found["near_singular_windows"] == 6
    assert found["static_margin"] == pytest.approx(22.1e-3, abs=0.2e-3)
    assert found["leg_mismatch"] < 1e-9
    assert found["knee_torque_max"] < 1.2
    assert found["advance_measured"] >= 0.110


@pytest.mark.slow
@pytest.mark.parametrize("law", ["inverse", "sc", "sc-trapezoid"])
def test_rates_of_the_other_laws(tmp_path, law):
    found = measure(
        tmp_path,
        "legs-walk",
        f"law={law}",
        f"metrics.peak_knee_rate={{min: {0.98 * RATES[law]}, max: {1.02 * RATES[law]}}}",
        "metrics.rate_jump={}",
        "metrics.knee_torque_max={max: 4.5, segments: all}",
    )
    assert found["advance"] == pytest.approx(0.120, abs=1e-5)
    assert found["near_singular_windows"] == 6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "rig"),
    [
        ("legs-walk", "legs"),
        ("legs-walk", "legs-can"),
        ("legs-walk-fast", "legs"),
        ("legs-walk-fast", "legs-can"),
        ("legs-walk-trapezoid", "legs"),
        ("legs-walk-bob", "legs"),
        ("legs-squat", "legs"),
        ("legs-squat", "legs-can"),
        ("legs-footsteps", "legs"),
        ("legs-footsteps", "legs-can"),
        ("legs-stairs", "legs-stairs"),
    ],
)
def test_experiments_over_bytes_and_frames(tmp_path, name, rig):
    measure(tmp_path, name, f"rig={rig}", backend=Backend.VIRTUAL)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("name", ["legs-walk", "legs-footsteps", "legs-stairs"])
def test_walks_of_other_robots(tmp_path, name, seed):
    measure(tmp_path, name, f"simulation.seed={seed}")


def test_robot_ends_on_its_footprints_round_a_bend_and_aside(tmp_path):
    found = measure(tmp_path, "legs-footsteps", "reference.speed=1.5", "metrics.rate_jump={}")
    assert found["fell"] == 0.0
    assert 0.0 < found["feet_astray_end"] < 5e-3


@pytest.mark.slow
def test_a_plan_for_stairs_fails_where_there_are_none(tmp_path):
    """The plant judges: on level ground the same plan steps into nothing, and the loop stops it."""
    plan = load_plan("legs-stairs", ["rig=legs"], configs=CONFIGS)
    result = run_experiment(plan, Backend.SIM, tmp_path, report=False)
    assert result.exit_code == 4
    assert "from where it was sent" in result.message


@pytest.mark.slow
def test_slope_is_climbed(tmp_path):
    slope, far = 0.1, 0.1
    block = "plant.terrain=[{start: 60 mm, length: 1 m, slope: 0.1 rad}]"
    steps = ", ".join(
        f"{{foot: {foot}, x: {far}, y: {side}, height: {slope_height(far - 0.06, slope)}, "
        f"pitch: {-slope}}}"
        for foot, side in (("right", -0.039), ("left", 0.039))
    )
    found = measure(
        tmp_path, "legs-footsteps", block, f"reference.steps=[{steps}]", "reference.lift=25 mm",
        "reference.follow=25 mm", "metrics.peak_norm_rate={}",
    )  # fmt: skip
    assert found["feet_astray_end"] < 5e-3


def on_slope(tmp_path, pitch, roll, numbers):
    sets = [f"{key}_pitch={pitch}" for key in ("reference.start", "plant.floor")]
    sets += [f"{key}_roll={roll}" for key in ("reference.start", "plant.floor")]
    return measure(
        tmp_path, "legs-footsteps", "reference.steps=[]", f"reference.numbers={numbers}", *sets,
        "metrics.feet_astray_end={segments: all, max: 8 mm}",
    )  # fmt: skip


def test_a_walk_that_begins_on_a_slope_ends_on_its_prints(tmp_path):
    found = on_slope(tmp_path, -0.07, 0.04, "{count: 2, length: 20 mm}")
    assert found["fell"] == 0.0
    assert found["feet_astray_end"] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_drawn_walks_on_drawn_slopes_end_on_their_prints(tmp_path, seed):
    rng = np.random.default_rng((17, seed))
    pitch, roll = rng.uniform(-0.09, 0.09), rng.uniform(-0.07, 0.07)
    turn, length = rng.uniform(-0.1, 0.1), rng.uniform(0.005, 0.03)
    numbers = f"{{count: 4, length: {length}, turn: {turn}}}"
    found = on_slope(tmp_path, pitch, roll, numbers)
    assert found["fell"] == 0.0
    assert found["feet_astray_end"] < 8e-3


def slope_height(ahead, slope):
    """Return the height of a slope so far ahead of its edge, m."""
    return ahead * math.tan(slope)


@pytest.mark.slow
def test_six_landings(tmp_path):
    found = measure(tmp_path, "legs-walk", "reference.landings=6")
    assert found["advance"] == pytest.approx(0.240, abs=1e-5)
    assert found["near_singular_windows"] == 12
    assert found["advance_measured"] > 0.220


@pytest.mark.slow
def test_at_five_times_the_speed_the_plain_law_saturates_and_the_trapezoid_does_not(tmp_path):
    shares = {}
    for law in ("inverse", "sc-trapezoid"):
        found = measure(
            tmp_path,
            "legs-walk",
            f"law={law}",
            "reference.speed=5",
            "metrics={peak_knee_rate: {}, fell: {segments: all}, saturated_share: {segments: all}}",
        )
        shares[law] = found["saturated_share"]
        assert (found["peak_knee_rate"] > 4.76) == (law == "inverse")
    assert shares["inverse"] > 0.005
    assert shares["sc-trapezoid"] == 0.0


@pytest.mark.slow
def test_bob_saves_torque_on_the_robot_too(tmp_path):
    flat, bob = (
        measure(tmp_path, name)["knee_torque_mean"] for name in ("legs-walk", "legs-walk-bob")
    )
    assert bob < 0.8 * flat


def test_plan_below_the_margin_is_refused_with_its_instant():
    with pytest.raises(Exception, match=r"at 2\d\.\d+ s \(swing left 2\) the centre of mass .* 30"):
        load_plan("legs-walk", ["legs.balance.min_margin=30 mm"], configs=CONFIGS)
