"""What breaks in a simulated rig's plant is called by its own name in the acceptance test."""

import dataclasses

import pytest
from test_commissioning import ENOUGH, perform, unit

from rig.assembly import REGISTRY, Backend, build_rig
from rig.commissioning.operator import SimulatedOperator
from rig.commissioning.session import CommissioningFacts, begin, commission, steps_of
from rig.commissioning.site import Site
from rig.config import find_configs, load_profile
from rig.config.simulation_models import FaultSpec

LATER = ("stop-reaction", "master", "cable", "sensors", "response", "ends", "load", "first-motion")


def with_fault(profile, fault, size, device="plant"):
    entry = FaultSpec(0.0, device, fault, size)
    simulation = dataclasses.replace(profile.simulation, faults=(entry,))
    return dataclasses.replace(profile, simulation=simulation)


def found(tmp_path, rig, fault, size, seed):
    stopped, _, seen = perform(
        tmp_path, with_fault(unit(rig, seed), fault, size), None, seed, LATER
    )
    assert stopped is not None, "nothing was found"
    return stopped, seen


OPEN = [
    ("cylinder", "regulator_open", 0.0, "agonist", "regulator is stuck open"),
    ("cylinder-uncalibrated", "regulator_open", 1.0, "antagonist", "regulator is stuck open"),
    ("joint", "regulator_open", 2.0, "ch3", "regulator is stuck open"),
    ("cylinder-valves", "valve_open", 1.0, "antagonist", "valve is stuck open"),
    ("cylinder-valves", "agonist.valve_stuck", 0.05, "agonist", "valve is stuck open"),
    ("cylinder", "agonist.regulator_offset", 60e3, "agonist", "wrong zero of its setpoint"),
]


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize(("rig", "fault", "size", "channel", "cause"), OPEN)
def test_a_chamber_that_is_fed_unasked_is_no_encoder(
    tmp_path, rig, fault, size, channel, cause, seed
):
    stopped, seen = found(tmp_path, rig, fault, size, seed)
    assert stopped.startswith(f"supply: {channel}: ")
    assert cause in stopped
    assert seen["way"] <= ENOUGH["way"]  # it is seen before the rod has gone anywhere


OFF = [
    ("cylinder", "agonist.leak", 1e-8, "agonist"),
    ("cylinder", "antagonist.leak", 5e-8, "antagonist"),
    ("joint", "ch1.leak", 5e-8, "ch1"),
]


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize(("rig", "fault", "size", "channel"), OFF)
def test_a_tube_that_is_off_is_not_swapped(tmp_path, rig, fault, size, channel, seed):
    stopped, _ = found(tmp_path, rig, fault, size, seed)
    assert stopped.startswith(f"actuators: {channel}: its tube is off")
    assert "swapped" not in stopped


UNANSWERED = [
    ("cylinder-valves", "agonist.leak", 3e-8, "agonist: its monitor shows", "its tube is off"),
    ("cylinder", "agonist.monitor_frozen", None, "agonist: its monitor shows", "frozen"),
    ("cylinder", "regulator_closed", 1.0, "antagonist: its monitor shows", "regulator is stuck"),
    ("cylinder", "supply_lost", 1e3, "agonist: no pressure rises", "has no pressure"),
    ("cylinder-valves", "agonist.monitor_frozen", None, "antagonist: its pressure goes",
     "the monitor of agonist shows nothing"),
    ("cylinder", "agonist.monitor_offset", 60e3, "agonist: its monitor shows 5", "zero"),
    ("cylinder", "agonist.monitor_offset", -22e3, "agonist: its monitor shows -2", "zero"),
]  # fmt: skip


@pytest.mark.parametrize(("rig", "fault", "size", "begins", "cause"), UNANSWERED)
def test_whoever_shows_nothing_or_shows_it_unasked_is_named(
    tmp_path, rig, fault, size, begins, cause
):
    stopped, _ = found(tmp_path, rig, fault, size, 1)
    assert stopped.startswith(f"supply: {begins}")
    assert cause in stopped
    assert "encoder" not in stopped


def test_a_poor_supply_is_named_beside_the_scale(tmp_path):
    stopped, _ = found(tmp_path, "cylinder", "supply_lost", 10e3, 1)
    assert stopped.startswith("actuators: agonist: ")
    assert "the supply gives no more" in stopped


SERVO = [
    ("plant", "brake_released", 1.0, "ranges: ", "its brake does not hold"),
    ("plant", "payload", 20.0, "hold: ", "needs more torque"),
    ("drives", "q4.safe_torque_off", None, "hold: drives joint q4: the drive does not enable",
     "no voltage: safe torque off is open"),
]  # fmt: skip


@pytest.mark.parametrize(("device", "fault", "size", "begins", "cause"), SERVO)
def test_a_joint_that_is_not_held_is_named_with_why(tmp_path, device, fault, size, begins, cause):
    profile = load_profile("arm", REGISTRY, (), find_configs(None))
    profile = with_fault(profile, fault, size, device)
    site = Site(profile, lambda its: build_rig(its, Backend.VIRTUAL), SimulatedOperator(), tmp_path)
    record = begin(profile, [tmp_path], CommissioningFacts("virtual"), anew=True)
    stopped = commission(site, record, steps_of(profile), tmp_path, lambda said: None)
    assert stopped.startswith(begins)
    assert cause in stopped


@pytest.mark.parametrize("size", [-10e3, -7e3, 10e3, 15e3])
def test_a_regulator_that_is_off_is_told_or_found(tmp_path, size):
    """By how much, beside what its maker states; what is off by more does not pass."""
    profile = with_fault(unit("cylinder", 2), "antagonist.regulator_offset", size)
    skip = [step.name for step in steps_of(profile) if step.name != "actuators"]
    stopped, record, _ = perform(tmp_path, profile, None, 2, skip)
    found = record["steps"]["actuators"]
    assert (stopped is None) is found["passed"]
    assert "antagonist" in found["said"]
    assert "agonist gives" not in found["said"].replace("antagonist", "")
    if found["passed"]:
        assert "of at most 11 kPa: `rig calibrate cylinder regulators` finds that" in found["said"]
        words = " ".join(found["measured_in_words"])
        assert "antagonist: gauge off its setpoint" in words
    else:
        assert "its setpoint" in found["said"]
