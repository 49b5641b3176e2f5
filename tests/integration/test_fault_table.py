"""What goes wrong on the bus, in a device or in the plant is named, and the rig ends safe."""

from pathlib import Path

import pytest

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

CONFIGS = Path(__file__).parents[2] / "configs"
AT = 2.0
"""When the fault happens, s of virtual time: about half a period after the reference's start."""
LATER = {"regulator_stuck": 3.0}
"""What shows only when the sine has ended happens nearer to its end, s."""

STOPS = [
    # device, fault, value, within s, words of the message
    ("regulators", "silent", None, 0.02, ("regulators", "0x10", "does not answer SYNC")),
    ("regulators", "reboot", None, 0.01, ("regulators", "rebooted while running")),
    ("regulators", "wrong_state", None, 0.01, ("regulators", "left OPERATIONAL")),
    ("regulators", "emergency", None, 0.01, ("regulators", "EMCY 0x1000", "generic error")),
    ("regulators", "heartbeat_silent", None, 0.2, ("regulators", "heartbeat is lost")),
    ("regulators", "wire_break", 0, 0.01, ("monitor of agonist", "broken wire", "0x6401:01", "V")),
    ("regulators", "output_stuck", 0, 0.6, ("regulators", "agonist is stuck", "kPa")),
    ("regulators", "emergency_stop", 1, 0.01, ("emergency stop is pressed",)),
    ("regulators", "drop_frames", 2000, 0.02, ("regulators", "missed in a row")),
    ("encoder-agonist", "silent", None, 0.02, ("encoder-agonist", "does not answer SYNC")),
    ("encoder-agonist", "frozen", None, 0.3, ("encoder-agonist is frozen", "mismatch")),
    ("encoder-agonist", "jump", None, 0.01, ("encoder-agonist", "jumped", "0x6004:00")),
    ("encoder-agonist", "corrupt_frames", 3, 0.01, ("encoder-agonist", "jumped")),
    ("encoder-antagonist", "alarm", None, 0.01, ("encoder-antagonist", "EMCY 0x7300")),
    ("can0", "frame_loss", 1, 0.02, ("missed in a row",)),
    ("plant", "wire_cut", 0, 0.01, ("the wire of agonist is slack or cut", "mismatch")),
    ("plant", "supply_lost", None, 0.2, ("regulators", "supply pressure is lost")),
    ("plant", "regulator_stuck", 0, 0.6, ("regulators", "agonist is stuck", "kPa")),
    ("plant", "regulator_open", 0, 0.02, ("regulators", "agonist is stuck open")),
]
TOLERATED = [
    ("encoder-agonist", "truncate_frames", 4),
    ("encoder-agonist", "duplicate_frames", None),
    ("regulators", "delay_frames", 0.02),
    ("can0", "foreign_frame", None),
    ("can0", "frame_loss", 0.01),
]
REFUSED = [
    ("regulators", "wrong_device_type", None, ("regulators", "0x1000")),
    ("regulators", "sdo_abort", 0x6443 * 256 + 1, ("regulators", "0x6443:01")),
    ("encoder-agonist", "silent", None, ("encoder-agonist",)),
]


def run(tmp_path, device, fault, value, at=AT, periods=3):
    given = "" if value is None else f", value: {value}"
    plan = load_plan(
        "cylinder-sine",
        [
            f"reference.tones=[{{frequency: 1 Hz, periods: {periods}}}]",
            "approach=0.5 s",
            "metrics={}",
            f"simulation.faults=[{{at: {at}, device: {device}, fault: {fault}{given}}}]",
        ],
        configs=CONFIGS,
    )
    return run_experiment(plan, Backend.VIRTUAL, tmp_path, report=False)


@pytest.mark.parametrize(
    ("device", "fault", "value", "within", "words"), STOPS, ids=[f"{d}-{f}" for d, f, *_ in STOPS]
)
def test_fault_while_running_is_named_and_ends_safe(tmp_path, device, fault, value, within, words):
    at = LATER.get(fault, AT)
    result = run(tmp_path, device, fault, value, at)
    assert (result.exit_code, result.status.value) == (4, "faulted")
    for word in words:
        assert word in result.message
    folder = RunFolder.open(result.path)
    kinds = [event["kind"] for event in folder.events()]
    assert "fault" in kinds
    assert folder.events()[-1]["message"] == result.message or "limit" in kinds
    log = read_log(folder.log_path)
    # Complete up to the cycle that saw it, which was recorded with what was sent then: vent.
    assert at - 0.2 < log.t[-1] < at + within
    assert log.cycle[-1] == len(log.cycle) - 1
    assert log.column("applied.agonist")[-1] == 0.0
    assert log.column("applied.antagonist")[-1] == 0.0


@pytest.mark.parametrize(
    ("device", "fault", "value"), TOLERATED, ids=[f"{d}-{f}" for d, f, _ in TOLERATED]
)
def test_what_a_bus_does_now_and_then_stops_nothing(tmp_path, device, fault, value):
    assert run(tmp_path, device, fault, value, periods=2).exit_code == 0


@pytest.mark.parametrize(
    ("device", "fault", "value", "words"), REFUSED, ids=[f"{d}-{f}" for d, f, *_ in REFUSED]
)
def test_device_that_is_not_as_it_should_be_is_never_energised(
    tmp_path, device, fault, value, words
):
    result = run(tmp_path, device, fault, value, at=0)
    assert (result.exit_code, result.status.value) == (3, "faulted")
    for word in words:
        assert word in result.message
    log = RunFolder.open(result.path).log_path
    assert not log.exists() or len(read_log(log).cycle) == 0


def test_fault_that_cannot_happen_is_a_configuration_error(tmp_path):
    from rig.hal import ConfigurationError

    with pytest.raises(ConfigurationError, match="explode"):
        run(tmp_path, "regulators", "explode", None)
