"""The file that keeps a fault: written, read, mistrusted, and what a run's end makes of it."""

import json
import os
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import pytest

from rig.experiment.ending import EXIT_FAULT, EXIT_INTERRUPTED, EXIT_OK, EXIT_PREFLIGHT, Ending
from rig.experiment.fault_latch import FaultLatch, FaultLatched
from rig.hal import DeviceError
from rig.hal.driver import Endpoint
from rig.run_facts import RunStatus

RUN = Path("runs/one")


@pytest.fixture
def latch(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return FaultLatch("joint")


def test_nothing_is_latched_at_first(latch):
    assert latch.reason() is None
    latch.check()
    latch.clear()


def test_without_a_state_folder_it_is_the_homes(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    for value in (None, ""):
        monkeypatch.delenv("XDG_STATE_HOME", raising=False)
        if value is not None:
            monkeypatch.setenv("XDG_STATE_HOME", value)
        assert FaultLatch("joint").path == tmp_path / ".local/state/rig/joint.fault"


def test_a_fault_holds_for_other_processes_of_this_rig_alone_until_it_is_cleared(latch):
    before = datetime.now(UTC).replace(microsecond=0)
    latch.set(RUN, "der Schlauch ist ab: 40 kPa über allem")
    text = latch.path.read_text(encoding="utf-8")
    assert "40 kPa über allem" in text  # for people who look into it
    kept = json.loads(text)
    assert before <= datetime.fromisoformat(kept["since"]) <= datetime.now(UTC)
    assert [path.name for path in latch.path.parent.iterdir()] == ["joint.fault"]
    again = FaultLatch("joint")
    with pytest.raises(FaultLatched, match=r"kPa über allem \(.*, runs/one\).* rig reset joint$"):
        again.check()
    FaultLatch("arm").check()
    again.clear()
    latch.check()


def test_a_program_that_died_says_so_and_the_last_fault_is_kept(latch):
    latch.set(RUN)
    assert "ended while the rig was energised, and did not say why" in str(latch.reason())
    latch.set(RUN, "it broke")
    assert str(latch.reason()).startswith("it broke (")


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "7", "null", '{"fault": "x"}', '{"fault": "x", "since": 1}', "\udcff"]
)
def test_a_file_that_cannot_be_understood_latches_too(latch, text):
    latch.path.parent.mkdir(parents=True)
    latch.path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(FaultLatched, match="cannot be read"):
        latch.check()


def test_a_file_of_64_kib_is_read_and_a_longer_one_latches_unread(latch):
    latch.set(RUN, "it broke")
    text = latch.path.read_text(encoding="utf-8")
    latch.path.write_text(text.ljust(65536))
    assert str(latch.reason()).startswith("it broke (")
    latch.path.write_text(text.ljust(65537))
    assert "it has more than 65536 bytes" in str(latch.reason())


def test_a_file_that_cannot_be_opened_or_removed_latches_too(latch):
    latch.path.mkdir(parents=True)
    assert "cannot be read" in str(latch.reason())
    with pytest.raises(DeviceError, match=r"joint\.fault cannot be removed: [A-Z]"):
        latch.clear()


def test_a_fault_is_on_the_disk_before_it_takes_the_place_of_the_last_one(latch, monkeypatch):
    sizes = []
    monkeypatch.setattr(os, "fsync", lambda file: sizes.append(os.fstat(file).st_size))
    latch.set(RUN, "it broke")
    assert sizes == [latch.path.stat().st_size]


def blocked(latch):
    latch.path.parent.parent.mkdir()
    latch.path.parent.write_text("in the way")


def test_a_fault_that_cannot_be_kept_is_an_error_before_anything_is_energised(latch):
    blocked(latch)
    with pytest.raises(DeviceError, match=r"a fault could not be latched in .*joint\.fault: [A-Z]"):
        latch.set(RUN)


@pytest.mark.parametrize(
    "ending",
    [
        Ending(RunStatus.OK, EXIT_OK),
        Ending(RunStatus.FAILED, 1),
        Ending(RunStatus.ABORTED, EXIT_INTERRUPTED),
        Ending(RunStatus.FAULTED, EXIT_PREFLIGHT, "never energised"),
    ],
)
def test_a_run_without_a_fault_leaves_nothing(latch, ending):
    latch.set(RUN)
    assert latch.settle(RUN, ending) is None
    assert latch.reason() is None


@pytest.mark.parametrize("status", [RunStatus.FAULTED, RunStatus.CRASHED])
def test_a_runs_fault_is_kept_and_the_operator_told(latch, status):
    told = latch.settle(RUN, Ending(status, EXIT_FAULT, "valves: it broke"))
    assert told == "joint is latched: find the cause and mend it, then: rig reset joint"
    assert str(latch.reason()).startswith("valves: it broke (")


def test_a_fault_that_cannot_be_written_any_more_is_told(latch):
    blocked(latch)
    told = latch.settle(RUN, Ending(RunStatus.FAULTED, EXIT_FAULT, "it broke"))
    assert told.startswith("joint: a fault could not be latched")


class Wire(NamedTuple):
    """Settings of a CAN bus, as far as a latch looks at them."""

    @dataclass(frozen=True)
    class Settings:
        interface: str
        channel: str

        def endpoint(self):
            return Endpoint(self.interface, self.channel, 1_000_000)

    settings: Settings
    driver: str = "can"


class Profile(NamedTuple):
    """A rig on some wires, as far as a latch looks at it."""

    name: str
    argument: str
    buses: dict


def on_wires(name, *channels, interface="socketcan"):
    buses = {f"b{k}": Wire(Wire.Settings(interface, c)) for k, c in enumerate(channels)}
    return Profile(name, f"configs/{name}.yaml", buses)


def test_another_profile_of_the_same_wires_meets_the_fault(latch):
    mine = FaultLatch.of(on_wires("joint", "can0", "can1"))
    mine.set(RUN, "a wire was cut")
    told = (
        r"^copy: joint is on socketcan can1 as well, and its last fault is latched: a wire was cut "
        r"\(.*, runs/one\); find the cause and mend it, then: rig reset configs/joint.yaml$"
    )
    copy = FaultLatch.of(on_wires("copy", "can1", "can2"))
    with pytest.raises(FaultLatched, match=told) as caught:
        copy.check()
    assert caught.value.told in str(caught.value)
    assert caught.value.told.startswith("joint is on socketcan can1 as well, and its last fault")
    assert caught.value.remedy == "rig reset configs/joint.yaml"
    assert copy.reason() is None
    for other in (on_wires("arm", "can2"), on_wires("arm", "can1", interface="kvaser")):
        FaultLatch.of(other).check()
    mine.clear()
    copy.check()


def test_the_wires_are_those_that_it_was_put_on(latch, monkeypatch):
    monkeypatch.setattr("rig.experiment.fault_latch.parse_interfaces", told_interfaces)
    FaultLatch.of(on_wires("joint", "can0"), "can7").set(RUN, "it broke")
    FaultLatch.of(on_wires("arm", "can0"), "hardware").check()
    with pytest.raises(FaultLatched, match="joint is on socketcan can7 as well"):
        FaultLatch.of(on_wires("arm", "can7")).check()


def told_interfaces(on, profile):
    return {"b0": {"interface": "socketcan", "channel": on}}


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"wires": 5}', '{"wires": ["socketcan can0"]}'])
def test_a_file_beside_it_that_nobody_understands_latches_its_own_rig_alone(latch, text):
    latch.path.parent.mkdir(parents=True)
    latch.path.write_text(text)
    FaultLatch.of(on_wires("arm", "can0")).check()
    with pytest.raises(FaultLatched):
        latch.check()
