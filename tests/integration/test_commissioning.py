"""The acceptance test: healthy rigs pass, and each planted defect is found where it has to be."""

import pytest
from planted import PLANTED, drawn_unit, rig_with

from rig.assembly import REGISTRY
from rig.commissioning.operator import SimulatedOperator
from rig.commissioning.session import Circumstances, begin, commission, steps_of
from rig.commissioning.site import Site
from rig.config import find_configs, load_profile

ENOUGH = {"pressure": 20e3, "way": 1e-3}


def perform(out, profile, plant=None, seed=0, skip=()):
    seen = dict.fromkeys(ENOUGH, 0.0)
    site = Site(profile, rig_with(profile, seen, plant, seed), SimulatedOperator(), out)
    steps = [step for step in steps_of(profile) if step.name not in skip]
    record = begin(profile, [out], Circumstances("virtual"), anew=True)
    said = []
    return commission(site, record, steps, out, said.append), record, seen


def unit(rig, seed):
    return drawn_unit(load_profile(rig, REGISTRY, (), find_configs(None)), seed)


def find(tmp_path, rig, plant, seed):
    step, words = PLANTED[plant]
    stopped, record, seen = perform(tmp_path, unit(rig, seed), plant, seed)
    assert stopped is not None, "nothing was found"
    assert stopped.startswith(f"{step}: "), stopped
    assert words in stopped
    assert record["digest"] == ""
    for what, most in ENOUGH.items():
        assert seen[what] <= most, f"{plant.__name__}: {what} {seen[what]}"


@pytest.mark.parametrize("plant", PLANTED, ids=lambda plant: plant.__name__)
def test_a_planted_defect_is_found_at_its_step_before_anything_moves(tmp_path, plant):
    find(tmp_path, "cylinder", plant, 1)


@pytest.mark.parametrize("seed", range(3))
def test_a_healthy_rig_is_not_refused(tmp_path, seed):
    stopped, record, _ = perform(tmp_path, unit("cylinder", seed), skip=("first-motion",))
    assert stopped is None
    assert all(step["passed"] for step in record["steps"].values())
