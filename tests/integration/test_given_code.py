"""Code that was given in Python and raises: it is named, with its line and the time."""

import re

import pytest

import rig
from controllers.cylinder.pid import Pid
from rig.assembly.contract_check import note_given, whose_bug
from rig.mechanisms.arm.references import ArmTwists


class Divides(Pid):
    """Fails after a while, in a function of its file."""

    cycles = 0

    def update(self, state, reference, load=0.0):
        self.cycles += 1
        if self.cycles > 600:
            divided()
        return super().update(state, reference, load)


class Leaves(Pid):
    """Wants to end the program."""

    def update(self, state, reference, load=0.0):
        raise SystemExit(3)


class Unmade(Pid):
    """Cannot be made."""

    def __init__(self, *given):
        raise LookupError("no gains")


class Drops(ArmTwists):
    """A stick that goes dead."""

    def twist(self, t):
        return (0.05, 0.0, 0.0, 0.0, 0.0, 0.0) if t < 1.0 else divided()


def divided():
    return 1 / 0


@pytest.mark.parametrize(
    ("experiment", "given", "said"),
    [
        (
            "cylinder-step",
            {"controller": Divides},
            r"Divides\.update \(.*\) at \d\.\d{3} s of .*: Zero",
        ),
        (
            "cylinder-step",
            {"controller": Leaves},
            r"Leaves\.update \(.*\) at .* s of .*: SystemExit: 3",
        ),
        (
            "arm-twist",
            {"reference": Drops(duration=3.0)},
            r"Drops\.twist \(.*\) at .* s of .*: Zero",
        ),
    ],
)
def test_code_that_raises_while_it_runs_is_named(tmp_path, experiment, given, said):
    with pytest.raises(rig.ConfigurationError, match=said) as failed:
        rig.run(experiment, on="sim", out=tmp_path, **given)
    assert isinstance(failed.value, rig.CodeFailed) and isinstance(failed.value, rig.RunError)
    assert f"({__file__}, line " in str(failed.value)
    run = failed.value.run
    assert (run.status, run.manifest["exit_code"]) == ("crashed", 2)
    assert run.manifest["ended"] is not None
    assert re.match(said, run.message)
    assert run.message in [event["message"] for event in run.events if event["kind"] == "fault"]


def test_code_that_raises_before_there_is_a_run_is_named(tmp_path):
    said = r"Unmade\.__init__ \(.*, line \d+\): LookupError: no gains"
    with pytest.raises(rig.ConfigurationError, match=said):
        rig.run("cylinder-step", on="sim", out=tmp_path, controller=Unmade)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("kind", "is_theirs"), [(ValueError, True), (KeyboardInterrupt, False)])
def test_a_signal_that_came_while_given_code_ran_is_no_bug_of_it(kind, is_theirs):
    note_given(Divides)
    with pytest.raises(kind) as raised:
        raise kind
    assert (whose_bug(raised.value) is not None) is is_theirs
