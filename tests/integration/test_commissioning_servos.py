"""The acceptance test of servo axes: healthy rigs pass, planted defects are found in time."""

import math

import pytest
from planted_servos import RIGS, prepared, torque_cap_not_kept
from planted_truth import rig_with

from rig.assembly import REGISTRY
from rig.commissioning.operator import SimulatedOperator
from rig.commissioning.session import CommissioningFacts, begin, commission, steps_of
from rig.commissioning.site import Site
from rig.config import find_configs, load_profile

ENOUGH = 1.0
"""Degrees that any joint may turn before a defect is found."""

PAIRS = [(rig, plant) for rig, planted in RIGS.items() for plant in planted]
SOON = {
    "joint_stops_short",
    "foreign_node", "other_serial", "torque_cap_not_kept", "normally_open", "zero_off",
    "encoder_mirrored", "stop_ignored",
}  # fmt: skip


def perform(out, rig, plant=None, seed=0):
    profile = load_profile(rig, REGISTRY, (), find_configs(None))
    if plant is not None:
        profile = prepared(profile, torque=plant is torque_cap_not_kept)
    seen = {"angle": 0.0}
    site = Site(profile, rig_with(seen, plant, seed), SimulatedOperator(), out)
    record = begin(profile, [out], CommissioningFacts("virtual"), anew=True)
    stopped = commission(site, record, steps_of(profile), out, lambda text: None)
    return stopped, record, math.degrees(seen["angle"])


def find(out, rig, plant, seed):
    stopped, record, turned = perform(out, rig, plant, seed)
    assert stopped is not None, "nothing was found"
    wanted = RIGS[rig][plant]
    assert any(stopped.startswith(f"{step}: ") and words in stopped for step, words in wanted), (
        stopped
    )
    assert record["digest"] == ""
    if wanted[0][0] != "ends":  # there hands turn the joints
        assert turned <= ENOUGH, f"{turned:.2f} degrees before: {stopped}"


def named(pair):
    return f"{pair[0]}-{pair[1].__name__}"


@pytest.mark.parametrize(
    "pair",
    [
        p
        for p in PAIRS
        if (p[0] == "arm" and p[1].__name__ in SOON) or p[1].__name__ == "foreign_servo"
    ],
    ids=named,
)
def test_a_planted_defect_is_found_before_a_joint_turns_by_a_degree(tmp_path, pair):
    find(tmp_path, *pair, seed=1)


@pytest.mark.slow
@pytest.mark.sampled(12)
@pytest.mark.parametrize("seed", [2, 3])
@pytest.mark.parametrize("pair", PAIRS, ids=named)
def test_every_planted_defect_is_found_however_it_is_drawn(tmp_path, pair, seed):
    find(tmp_path, *pair, seed)


@pytest.mark.slow
@pytest.mark.sampled(2)
@pytest.mark.parametrize("rig", RIGS)
def test_a_healthy_rig_passes_every_step(tmp_path, rig):
    stopped, record, _ = perform(tmp_path, rig)
    assert stopped is None
    assert all(step["passed"] for step in record["steps"].values())
    assert len(record["digest"]) == 8
