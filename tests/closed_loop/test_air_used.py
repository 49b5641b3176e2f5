"""The air that a run says it took is what the plant's main valves let in.

The plant's own flows are the truth. A measure that is told the chambers' volumes is off by 2 %; the
monitor of the real plant does not see what ripples at its outlet, so setpoints that chatter take a
tenth more than is told.
"""

from pathlib import Path

import numpy as np
import pytest

from drivers.sim.plants.pneumatic_plant import PneumaticPlant
from drivers.sim.plants.pneumatics import ATMOSPHERE, GAS_CONSTANT, TEMPERATURE
from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.mechanisms.pneumatic.reported import REPORTED
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

CONFIGS = Path(__file__).parents[2] / "configs"
CIRCLE = ("reference.tones=[{frequency: 0.2 Hz, laps: 2}]",)
QUIET = "{proportional: 3e7, integral: 1e8, derivative: 2e6}"
"""Gains of a PID that bear the dead time of the real plants."""


def unwatched(mechanism):
    return (
        f"{mechanism}.alarms.pressure={{deviation: 499 kPa, offset: 499 kPa, slow: 99}}",
        f"{mechanism}.limits.following=20 mm",
        f"{mechanism}.alarms.oscillation={{amplitude: 40 mm}}",
    )


REAL = ("plant={model: antagonistic-pair, seals: standard}", *unwatched("cylinder"))
REAL_JOINT = ("plant={model: spherical-joint, seals: standard}", *unwatched("joint"))
QUIET_PAIR = ("controller=pid", f"controllers.pid={QUIET}")
QUIET_JOINT = ("controller=pid", f"controllers.pid.pair={QUIET}")


def dead_volume(mechanism, volume):
    return f"{mechanism}.dead_volume={volume} cm^3"


@pytest.fixture
def fed(monkeypatch):
    """Return rows of the plant's time and of what all chambers have been fed until then, kg."""
    rows = []

    def run(plant, steps):
        amount = rows[-1][1] if rows else 0.0
        for _ in range(steps):
            plant._integrate(1)
            plant._steps += 1
            amount += plant._dt * float(np.maximum(plant.channels["drawn"], 0.0).sum())
        rows.append((plant.time, amount))

    monkeypatch.setattr(PneumaticPlant, "_run", run)
    return rows


def told_over_true(folder, fed, experiment, options):
    plan = load_plan(experiment, ["metrics={}", "figures=[]", *options], configs=CONFIGS)
    result = run_experiment(plan, Backend.SIM, folder, report=False)
    assert result.message is None
    told = {metric.name: metric.value for metric in result.metrics}
    assert tuple(told) == REPORTED
    log = read_log(RunFolder.open(result.path).log_path)
    times, amounts = np.array(fed).T
    since = log.column("reference.time")
    segments = plan.motion.segments
    spans = [(s.start, s.end) for s in segments if s.name == "all"] or [s[1:] for s in segments]
    true = lasted = 0.0
    for start, end in spans:
        part = (log.column("phase") == 1.0) & (since >= start) & (since < end)
        at = log.column("clock")[part][[0, -1]]
        true += float(np.diff(np.interp(at, times, amounts))[0])
        lasted += float(np.ptp(since[part]))
    return told["air_used"] * lasted * ATMOSPHERE / (GAS_CONSTANT * TEMPERATURE) / true


def sine(rng, tones=1):
    drawn = sorted(rng.choice(np.arange(20, 80), tones, replace=False) / 100)
    listed = ", ".join(f"{{frequency: {frequency} Hz, periods: 2}}" for frequency in drawn)
    return f"reference.tones=[{listed}]"


@pytest.mark.parametrize(
    ("what", "least", "most"),
    [
        (("controller=cascade",), 0.98, 1.02),
        (("controller=pid",), 0.98, 1.02),
        ((*REAL, *QUIET_PAIR, dead_volume("cylinder", 7.9)), 0.97, 1.03),
        ((*REAL, dead_volume("cylinder", 7.9)), 0.85, 1.0),
    ],
    ids=("cascade", "pid", "real, quiet", "real, chattering"),
)
@pytest.mark.parametrize("seed", [0])
def test_a_pair_says_what_air_it_takes(tmp_path, fed, what, least, most, seed):
    rng = np.random.default_rng([10, seed])
    options = (sine(rng, 2), f"simulation.seed={rng.integers(1000)}", *what)
    assert least < told_over_true(tmp_path, fed, "cylinder-ideal-sine", options) < most


def test_a_pair_of_other_cylinders_says_what_air_it_takes(tmp_path, fed):
    rng = np.random.default_rng(11)
    bore, rod, stroke = rng.uniform(18.0, 25.0), rng.uniform(6.0, 9.0), rng.uniform(50.0, 59.0)
    dead = rng.uniform(3.0, 12.0)
    options = (
        sine(rng),
        *(f"cylinder.{k}={v} mm" for k, v in (("bore", bore), ("rod", rod), ("stroke", stroke))),
        f"plant.cylinder={{bore: {bore} mm, rod: {rod} mm, stroke: {stroke} mm, "
        f"dead_volume: {dead} cm^3}}",
        dead_volume("cylinder", dead),
    )
    assert 0.98 < told_over_true(tmp_path, fed, "cylinder-ideal-sine", options) < 1.02


@pytest.mark.slow
@pytest.mark.parametrize(
    ("what", "least", "most"),
    [
        ((), 0.98, 1.02),
        ((*REAL_JOINT, *QUIET_JOINT, dead_volume("joint", 7.9)), 0.96, 1.04),
        ((*REAL_JOINT, "controllers.cascade.dither.amplitude=0", dead_volume("joint", 7.9)),
         0.85, 1.0),
    ],
    ids=("dither", "real, quiet", "real, chattering"),
)  # fmt: skip
def test_a_joint_says_what_air_it_takes(tmp_path, fed, what, least, most):
    assert least < told_over_true(tmp_path, fed, "joint-ideal-circle", (*CIRCLE, *what)) < most
