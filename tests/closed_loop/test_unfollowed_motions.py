"""A motion that the simulated rig does not follow is told by `rig check`, and no hardware runs it.

The judge is a whole run on the same simulated rig: where it ends in a fault, the check has to say
so beforehand, and nowhere else.
"""

import json

import numpy as np
import pytest
from stop_bench import CONFIGS

from rig.assembly import Backend
from rig.cli import invoke
from rig.experiment.frozen import Unfollowed, longest_freeze, refuse_slow_devices
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.hal import DeviceError, Freeze
from rig.run_facts import RunStatus

BARE = ("metrics={}", "figures=[]")


def drawn_sine(seed):
    """Return a sine on valves that ends within the time in which all of a motion is looked at."""
    rng = np.random.default_rng([1735, seed])
    frequency, amplitude = rng.uniform(0.8, 4.0), rng.uniform(5.0, 19.5)
    periods = max(2, int(4.0 * frequency))
    return (
        f"reference.amplitude={amplitude:.3f} mm",
        f"reference.tones=[{{frequency: {frequency:.3f} Hz, periods: {periods}}}]",
    )


def is_foreseen(folder, sine):
    """Judge one motion: return whether the check foresees the fault in which it ends."""
    options = (*sine, *BARE)
    try:
        plan = load_plan("cylinder-sine", options, rig="cylinder-valves", configs=CONFIGS)
    except ValueError:
        return None  # refused before anything moves
    foreseen = isinstance(longest_freeze(plan), Unfollowed)
    ran = load_plan("cylinder-sine", options, rig="cylinder-valves", configs=CONFIGS)
    result = run_experiment(ran, Backend.SIM, folder, report=False)
    assert foreseen == (result.status is RunStatus.FAULTED), (sine, foreseen, result.message)
    return foreseen


def test_what_a_check_foresees_is_what_a_run_ends_in(tmp_path):
    found = [is_foreseen(tmp_path, drawn_sine(seed)) for seed in range(12)]
    assert {True, False} <= set(found)


@pytest.mark.slow
@pytest.mark.parametrize("block", range(4))
def test_what_a_check_foresees_is_what_a_run_ends_in_often(tmp_path, block):
    for seed in range(100 + 20 * block, 120 + 20 * block):
        is_foreseen(tmp_path, drawn_sine(seed))


@pytest.mark.parametrize("rise", ["", ", rise: 0.08 s"])
def test_steps_of_a_long_motion_are_looked_at_where_they_are(rise):
    """Their references hardly move: a jump has no speed."""
    step = f"reference={{kind: step, size: 18 mm, dwell: 3 s, repeats: 4{rise}}}"
    plan = load_plan("cylinder-step", (step, *BARE), rig="cylinder-valves", configs=CONFIGS)
    assert isinstance(longest_freeze(plan), Unfollowed)


def test_a_law_that_is_too_rough_only_between_stretches_of_a_long_motion_is_not_refused():
    plan = load_plan("cylinder-sine", ("controller=pid", *BARE), configs=CONFIGS)
    assert isinstance(longest_freeze(plan), Freeze)


def test_a_circle_that_swings_a_joint_out_is_refused(capsys):
    circle = ("reference.tilt=40 deg", "reference.tones=[{frequency: 1.4 Hz, laps: 4}]", *BARE)
    plan = load_plan("joint-circle", circle, configs=CONFIGS)
    with pytest.raises(DeviceError, match=r"ends after .* oscillates at .*nothing breaks there"):
        refuse_slow_devices(plan, lambda _: None)
    words = [word for option in circle for word in ("--set", option)]
    assert invoke(["check", "joint-circle", "--configs", str(CONFIGS), "--json", *words]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["experiment"]["frozen"]["longest"] is None
    assert "oscillates" in said["experiment"]["frozen"]["unknown"]
    assert any("make the motion smaller or slower" in one for one in said["refused_on_hardware"])
