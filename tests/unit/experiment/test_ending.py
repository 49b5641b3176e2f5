"""How a run ends: its status, the code of the process, and what its folder says."""

from pathlib import Path

import pytest

from rig.experiment import ending as module
from rig.experiment.ending import (
    ClosedBooks,
    Ending,
    bug_of,
    ending_of,
    fault_of,
)
from rig.hal import (
    ConfigurationError,
    ConnectionFailed,
    ContractBroken,
    DeviceError,
    EmergencyStop,
    LoopStalled,
    RigError,
)
from rig.run_facts import RunStatus
from rig.runtime.recorder import RecorderError
from rig.runtime.stop import StopRequests

NO_LOG = RecorderError(Path("log.mcap"), OSError(28, "No space left"))


def test_the_codes_of_a_process_are_those_of_the_manual():
    names = ("OK", "MISSED", "USAGE", "PREFLIGHT", "FAULT", "BUG", "INTERRUPTED")
    assert [getattr(module, f"EXIT_{name}") for name in names] == [0, 1, 2, 3, 4, 70, 130]


@pytest.mark.parametrize(
    ("error", "status", "code", "message"),
    [
        (KeyboardInterrupt(), RunStatus.ABORTED, 130, "interrupted outside of the loop"),
        (DeviceError("valves", "gone"), RunStatus.FAULTED, 3, "valves: gone"),
        (ConnectionFailed("valves", "gone"), RunStatus.FAULTED, 3, "valves: gone"),
        (ConfigurationError("no such key"), RunStatus.FAULTED, 2, "no such key"),
        (EmergencyStop("pressed"), RunStatus.FAULTED, 4, "pressed"),
        (RigError("it broke"), RunStatus.FAULTED, 4, "it broke"),
        (ZeroDivisionError("by zero"), RunStatus.CRASHED, 70, "ZeroDivisionError: by zero"),
        (OSError("disk full"), RunStatus.CRASHED, 70, "OSError: disk full"),
    ],
)
def test_an_error_outside_of_the_loop(error, status, code, message):
    end = ending_of(error)
    assert end[:3] == (status, code, message)
    assert end.bug is (error if status is RunStatus.CRASHED else None)


@pytest.mark.parametrize(
    ("fault", "t", "status", "code", "message"),
    [
        (NO_LOG, None, RunStatus.FAULTED, 4, str(NO_LOG)),
        (
            NO_LOG, 1.5, RunStatus.FAULTED, 4,
            f"{NO_LOG}; it ends before 1.500 s, what came then is lost",
        ),
        (LoopStalled("paused"), 1.5, RunStatus.FAULTED, 4, "paused"),
        (OSError("queue full"), 1.5, RunStatus.FAULTED, 4, "queue full"),
        (KeyError("x"), 1.5, RunStatus.CRASHED, 70, "KeyError: 'x'"),
    ],
)  # fmt: skip
def test_a_fault_of_the_loop(fault, t, status, code, message):
    end = fault_of(fault, t)
    assert end[:3] == (status, code, message)
    assert end.bug is (fault if status is RunStatus.CRASHED else None)


def test_a_bug_of_another_package_is_the_users_to_mend(monkeypatch):
    monkeypatch.setattr(module, "whose_bug", lambda error: "stranger")
    error = ValueError("x")
    assert bug_of(error)[:4] == (RunStatus.CRASHED, 2, "stranger: ValueError: x", error)
    told = (RunStatus.CRASHED, 2, "stranger at 1.500 s of the log: ValueError: x", error)
    assert bug_of(error, 1.5)[:4] == fault_of(error, 1.5)[:4] == told


@pytest.mark.parametrize("error", [KeyboardInterrupt("x"), SystemExit("x")])
def test_another_package_does_not_end_the_program(monkeypatch, error):
    monkeypatch.setattr(module, "whose_bug", lambda error: "stranger")
    try:
        raise error
    except BaseException as raised:
        traceback = raised.__traceback__
    status, code, message, bug, *_ = ending_of(error)
    assert (status, code) == (RunStatus.CRASHED, 2)
    assert message == f"stranger: {type(error).__name__}: x"
    assert str(bug) == f"stranger wants to end the program: {type(error).__name__}: x"
    assert isinstance(bug, ContractBroken)
    assert bug.__traceback__ is traceback


def test_a_package_that_is_not_installed_is_no_bug_and_a_module_of_ours_is():
    missing = ModuleNotFoundError("No module named 'mujoco'", name="mujoco")
    ending = module.bug_of(missing, 0.5)
    assert (ending.status, ending.code) == (RunStatus.CRASHED, 2)
    assert "pip install mujoco" in ending.message
    assert ending.bug is missing
    for name in ("rig.nowhere", "mujoco.parts", None):
        ours = ModuleNotFoundError(f"No module named {name!r}", name=name)
        assert module.bug_of(ours, 0.5).code == 70


def test_a_broken_contract_of_the_loop_is_the_users_to_mend():
    status, code, message, bug, *_ = fault_of(ContractBroken("no number"), 1.5)
    assert (status, code, message) == (RunStatus.CRASHED, 2, "no number")
    assert isinstance(bug, ContractBroken)
    assert str(bug) == "no number"


@pytest.mark.parametrize("status", list(RunStatus))
def test_results_that_cannot_be_kept_make_a_good_run_a_fault_and_say_so(status):
    plain = Ending(status, 17).losing("no figures")
    told = Ending(status, 17, "it broke", ValueError()).losing("no figures")
    good = status in (RunStatus.OK, RunStatus.FAILED)
    assert plain[:3] == ((RunStatus.FAULTED, 4) if good else (status, 17)) + ("no figures",)
    assert told.message == "it broke; besides, no figures"
    assert (told.bug is None) is good


class Folder:
    """A run's folder on a disk that may be full."""

    def __init__(self, fails=()):
        self.fails = fails
        self.calls = []

    def record_event(self, *event, **data):
        self._note("event", *event, data)

    def finish(self, *end):
        self._note("finish", *end)

    def _note(self, what, *rest):
        self.calls.append((what, *rest))
        if what in self.fails:
            raise RigError("disk full")


@pytest.mark.parametrize("fails", [(), ("event",), ("finish",), ("event", "finish")])
def test_books_are_closed_whatever_of_them_cannot_be_written(fails):
    folder, stop = Folder(fails), StopRequests()
    with pytest.raises(DeviceError), ClosedBooks(folder, stop):
        raise DeviceError("valves", "gone")
    assert folder.calls == [
        ("event", None, "fault", "valves: gone", {"type": "DeviceError"}),
        ("finish", RunStatus.FAULTED, 3, "valves: gone"),
    ]
    assert stop.shielded


def test_books_of_a_run_that_goes_on_stay_open():
    folder, stop = Folder(), StopRequests()
    with ClosedBooks(folder, stop):
        pass
    assert folder.calls == [] and not stop.shielded


def test_a_command_of_a_message_is_given_the_name_of_its_rig():
    told = "it sticks: `rig calibrate RIG friction` measures that, then `rig tune RIG`; no RIG else"
    ending = Ending(RunStatus.FAULTED, 4, told).for_rig("'our lab.yaml'")
    assert ending == Ending(
        RunStatus.FAULTED, 4,
        "it sticks: `rig calibrate 'our lab.yaml' friction` measures that, then "
        "`rig tune 'our lab.yaml'`; no RIG else",
    )  # fmt: skip
    assert Ending(RunStatus.OK, 0).for_rig("ours") == Ending(RunStatus.OK, 0)


@pytest.mark.parametrize("status", list(RunStatus))
@pytest.mark.parametrize("passed", [False, True])
@pytest.mark.parametrize("flaw", ["", "the pair hunts"])
def test_a_run_ends_well_that_kept_its_bounds_and_has_no_flaw(status, passed, flaw):
    ended = Ending(status, 7, "so", flaw=flaw)
    judged = ended.judged(passed=passed)
    if status is RunStatus.OK and (flaw or not passed):
        assert judged[:3] == (RunStatus.FAILED, 1, flaw or None)
    else:
        assert judged is ended
