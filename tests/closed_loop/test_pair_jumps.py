"""Sudden steps of a pair: made, or refused beforehand with what would do instead."""

import random

import pytest

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.hal import ConfigurationError


def plan(rig, size, *options):
    sudden = (f"rig={rig}", f"reference.size={size}", "reference.rise=0 s", "figures=[]")
    return load_plan("cylinder-step", (*sudden, *options))


@pytest.mark.parametrize("size", ["4.1 mm", "5 mm", "8 mm", "10 mm", "-5 mm"])
def test_a_jump_that_seals_hold_is_refused_with_a_rise_that_would_do(size):
    with pytest.raises(ConfigurationError) as refused:
        plan("cylinder", size)
    said = str(refused.value)
    assert f"after 3 s the reference jumps by {size}, farther than limits.following, 4 mm" in said
    assert "Give the step a rise of 0.3 s or more" in said
    assert plan("cylinder", size, "reference.rise=0.3 s").motion.rise == 0.3


def test_what_the_alarm_waits_for_and_what_the_pair_may_be_off_decide():
    assert plan("cylinder", "10 mm", "cylinder.alarms.oscillation.lost=0.6 s")
    assert plan("cylinder", "5 mm", "cylinder.limits.following=6 mm")
    with pytest.raises(ConfigurationError, match=r"breakaway 22 N"):
        plan("cylinder", "12 mm", "cylinder.friction.breakaway=22 N")
    with pytest.raises(ConfigurationError, match=r"jumps by 20 mm"):
        plan("cylinder", "20 mm", "cylinder.limits.pair_force=18 N")


def test_what_a_speed_comes_to_in_a_cycle_is_no_jump():
    assert load_plan("cylinder-sine", ("cylinder.limits.following=0.005 mm",))


def drawn(count):
    chance = random.Random("jumps")
    for rig, size in (("cylinder", 12), ("cylinder-low-speed", 6), ("cylinder-ideal", 5)):
        for k in range(count):
            marks = [pytest.mark.slow] if k else []
            yield pytest.param(rig, size, chance.randrange(1000), marks=marks)


@pytest.mark.parametrize(("rig", "size", "seed"), list(drawn(4)))
def test_a_jump_that_is_permitted_stops_no_healthy_rig(tmp_path, rig, size, seed):
    allowed = plan(rig, f"{size} mm", f"simulation.seed={seed}", "metrics={}")
    assert run_experiment(allowed, Backend.SIM, tmp_path, report=False).message is None
