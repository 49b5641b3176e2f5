"""Who may run where: a latched fault, and calibrations that do not hold."""

from typing import NamedTuple

import pytest

from rig.assembly import Backend
from rig.config.models import Calibration, Provenance
from rig.experiment.fault_latch import FaultLatch, FaultLatched
from rig.experiment.permission import check_permitted
from rig.hal import DeviceError

SIMULATED = [backend for backend in Backend if backend is not Backend.HARDWARE]


class Profile(NamedTuple):
    """What a permission asks of a profile."""

    calibrations: dict
    name: str = "joint"
    argument: str = "joint"
    devices: dict = {}  # noqa: RUF012 - never written
    buses: dict = {}  # noqa: RUF012
    foreign: dict = {}  # noqa: RUF012


class Plan(NamedTuple):
    profile: Profile


def plan(**provenances):
    found = {
        name: Calibration(f"{name}.yaml", Provenance("2026-01-01", "somebody", **of), {})
        for name, of in provenances.items()
    }
    return Plan(Profile(found))


GOOD = {"backend": "hardware", "valid_until": "9999-12-31"}
EXPIRED = {"backend": "hardware", "valid_until": "2020-01-01"}
SIMULATION = {"backend": "virtual", "seed": 7}


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))


@pytest.mark.parametrize("backend", Backend)
def test_what_holds_is_permitted_everywhere(backend):
    assert check_permitted(plan(), backend) == []
    assert check_permitted(plan(valves=GOOD, rods=GOOD), backend) == []


@pytest.mark.parametrize("heed", [True, False])
def test_a_latched_fault_keeps_hardware_alone_from_running(tmp_path, heed):
    FaultLatch("joint").set(tmp_path, "it broke")
    with pytest.raises(FaultLatched, match="it broke"):
        check_permitted(plan(), Backend.HARDWARE, heed_calibrations=heed)
    for backend in SIMULATED:
        assert check_permitted(plan(), backend, heed_calibrations=heed) == []


def test_a_calibration_that_does_not_hold_is_refused_on_hardware_and_told_elsewhere():
    found = plan(rods=GOOD, valves=EXPIRED, camera=EXPIRED)
    with pytest.raises(DeviceError, match=r"^valves: its calibration expired on 2020-01-01"):
        check_permitted(found, Backend.HARDWARE)
    for backend in SIMULATED:
        doubts = check_permitted(found, backend)
        assert [doubt.partition(":")[0] for doubt in doubts] == ["valves", "camera"]


def test_what_was_measured_in_simulation_is_good_enough_for_simulation_only():
    found = plan(valves=SIMULATION)
    with pytest.raises(DeviceError, match=r"measured in simulation \(virtual, seed 7\)"):
        check_permitted(found, Backend.HARDWARE)
    for backend in SIMULATED:
        assert check_permitted(found, backend) == []


@pytest.mark.parametrize("backend", Backend)
def test_who_calibrates_needs_no_calibration(backend):
    assert check_permitted(plan(valves=EXPIRED), backend, heed_calibrations=False) == []
