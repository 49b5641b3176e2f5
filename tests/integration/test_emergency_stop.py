"""The emergency stop latches from the first look on: what is pressed once is not energised."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from rig.assembly import Backend, build_rig
from rig.config.simulation_models import FaultSpec
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.hal import EmergencyStop, EmergencyStopInput, Reading
from rig.mechanisms.stop_contact import StopContact
from rig.run_folder import RunFolder

CONFIGS = Path(__file__).parents[2] / "configs"
RIGS = {
    "cylinder": ("cylinder-step",),
    "joint": ("joint-circle", "reference.tones=[{frequency: 0.5 Hz, laps: 1}]"),
    "arm": ("arm-elbow-turnback",),
    "legs-can": ("legs-squat",),
}
REGULATORS = "regulators (node 0x10) at bit 0 of its inputs [object 0x6000:01]"
DRIVES = "the drive of {} (node 0x01) at bit 16 of its inputs [object 0x60FD:00]"
PLACES = {
    ("cylinder", Backend.VIRTUAL): REGULATORS,
    ("joint", Backend.VIRTUAL): REGULATORS,
    ("arm", Backend.VIRTUAL): f"drives, {DRIVES.format('q1')}",
    ("legs-can", Backend.VIRTUAL): f"right-leg, {DRIVES.format('right_hip_yaw')}",
}
"""Who reads the contact, and where; on sim there are devices without nodes."""
READS = {"cylinder": "regulators", "joint": "regulators", "arm": "drives", "legs-can": "right-leg"}
GENERATOR = np.random.default_rng(10)
FIRST_LOOK = {"cylinder": 0.04, "joint": 0.06, "arm": 0.07, "legs-can": 0.07}
"""By when who reads the contact is configured, and was asked for it, s."""
SHORTEST = 0.03
"""A press of three looks: whoever waits for a device that is configured looks every 10 ms."""


@cache
def plan_of(rig):
    experiment, *options = RIGS[rig]
    return load_plan(experiment, [*options, "metrics={}"], rig=rig, configs=CONFIGS)


@cache
def energised_at(rig, backend):
    """Return when the loop would begin, s on the rig's clock."""
    with build_rig(plan_of(rig).profile, backend) as made:
        made.arm()
        return made.clock.now()


def run(out, rig, backend, presses):
    faults = tuple(
        FaultSpec(at, READS[rig], "emergency_stop", value)
        for start, end in presses
        for at, value in ((start, 1.0), (end, 0.0))
    )
    plan = plan_of(rig)
    simulation = replace(plan.profile.simulation, faults=faults)
    plan = plan._replace(profile=replace(plan.profile, simulation=simulation))
    return run_experiment(plan, backend, out, report=False)


CASES = [
    *[("cylinder", Backend.VIRTUAL, *drawn) for drawn in GENERATOR.uniform(size=(5, 2)).tolist()],
    *[("joint", Backend.VIRTUAL, *drawn) for drawn in GENERATOR.uniform(size=(3, 2)).tolist()],
    ("cylinder", Backend.SIM, *GENERATOR.uniform(size=2).tolist()),
    ("joint", Backend.SIM, *GENERATOR.uniform(size=2).tolist()),
    *[("arm", Backend.VIRTUAL, *drawn) for drawn in GENERATOR.uniform(size=(4, 2)).tolist()],
    *[("legs-can", Backend.VIRTUAL, *drawn) for drawn in GENERATOR.uniform(size=(3, 2)).tolist()],
    ("arm", Backend.SIM, *GENERATOR.uniform(size=2).tolist()),
]


@pytest.mark.parametrize(
    ("rig", "backend", "when", "how_long"), CASES, ids=[f"{c[0]}-{c[1]}-{c[2]:.2f}" for c in CASES]
)
def test_a_press_while_connecting_is_not_forgotten(tmp_path, rig, backend, when, how_long):
    begins = energised_at(rig, backend)
    first = FIRST_LOOK[rig] if backend is Backend.VIRTUAL else 0.0
    start = first + when * max(begins - SHORTEST - first, 0.0)
    end = start + SHORTEST + how_long * 0.1
    result = run(tmp_path, rig, backend, [(start, end)])
    assert (result.exit_code, result.status.value) == (3, "faulted")
    released = end < begins - 0.005
    assert ("was pressed while connecting" in result.message) >= released
    assert READS[rig] in result.message
    assert result.message.startswith("the emergency stop ")
    events = RunFolder.open(result.path).events()
    assert not any(event["kind"] == "state" and "running" in event["message"] for event in events)


@pytest.mark.parametrize("backend", [Backend.VIRTUAL, Backend.SIM])
@pytest.mark.parametrize("rig", RIGS)
def test_a_circuit_that_is_open_from_the_start_energises_nothing(tmp_path, rig, backend):
    result = run(tmp_path, rig, backend, [(0.0, 60.0)])
    assert (result.exit_code, result.status.value) == (3, "faulted")
    place = PLACES.get((rig, backend), READS[rig])
    assert result.message == (
        f"the emergency stop is pressed or its circuit is open; its contact is read by {place}"
    )


@pytest.mark.parametrize("backend", [Backend.VIRTUAL, Backend.SIM])
@pytest.mark.parametrize("rig", ["arm", "legs-can"])
@pytest.mark.parametrize("drawn", GENERATOR.uniform(size=(2, 2)).tolist())
def test_drives_stop_within_a_cycle_and_a_press_is_not_taken_back(tmp_path, rig, backend, drawn):
    """Pressed for a cycle or more while it runs: a fault, and a standstill under torque."""
    period = plan_of(rig).profile.loop.period
    start = energised_at(rig, backend) + 0.3 + drawn[0]
    end = start + period * (1.5 + 20.0 * drawn[1])
    result = run(tmp_path, rig, backend, [(start, end)])
    assert (result.exit_code, result.status.value) == (4, "faulted")
    assert result.message.startswith("the emergency stop ")
    (fault,) = [e for e in RunFolder.open(result.path).events() if e["kind"] == "fault"]
    begins = energised_at(rig, backend)
    assert 0.0 <= fault["t"] - (start - begins) <= 3.0 * period


def test_a_rig_is_reset_without_letting_its_joints_go():
    """Whoever presses and releases is seen, and the drives are not connected for it."""
    made = build_rig(plan_of("arm").profile, Backend.VIRTUAL)
    world, told, resets = made.clock.world, [], []
    (bus,) = world.buses
    bus.monitor = lambda t, can_id, data: resets.append(data) if can_id == 0 else None
    with made.watching_stop() as is_pressed:
        for value in (0.0, 1.0, 0.0):
            world.inject("drives", "emergency_stop", value)
            for _ in range(3):
                is_pressed()
                made.clock.sleep_until(made.clock.now() + 0.02)
            told.append(is_pressed())
        assert not [data for data in resets if data[0] in (0x81, 0x82)], "a reset takes the torque"
    assert told == [False, True, False]


def test_a_drive_that_a_bus_has_stopped_tells_of_its_contact():
    """A rig that was open before leaves its nodes stopped, where they answer no SDO."""
    made = build_rig(plan_of("arm").profile, Backend.VIRTUAL)
    stop_all = bytes((0x02, 0))
    for node in made.clock.world.buses[0].nodes:
        node.receive(0x000, stop_all, 0.0)
    with made.watching_stop() as is_pressed:
        for _ in range(4):
            is_pressed()
            made.clock.sleep_until(made.clock.now() + 0.02)
        assert is_pressed() is False


class Contact(EmergencyStopInput):
    """A contact of somebody's own, which remembers nothing."""

    name, pressed = "button", False

    def emergency_stop(self):
        return Reading(self.pressed, 0.0)


def test_a_contact_that_remembers_nothing_is_asked_for_what_it_is():
    contact = Contact()
    watch = StopContact(contact, 0.1)
    watch.check(0.05)
    contact.look()
    contact.pressed = True
    assert contact.was_pressed()
    with pytest.raises(EmergencyStop, match="read by button"):
        watch.check(0.05)
