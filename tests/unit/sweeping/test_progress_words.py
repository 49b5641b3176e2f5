"""A line of progress says what is left and for how long, and nothing that is always nought."""

import pytest

from rig.cli.judge_progress import JudgeProgress
from rig.sweeping import progress as of_sweeps
from rig.sweeping.progress import SweepProgress


@pytest.fixture
def clock(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(of_sweeps, "monotonic", lambda: now[0])
    return now


def test_a_sweep_names_what_runs_only_if_something_does(clock):
    shown = SweepProgress(10)
    shown.done, clock[0] = 4, 8.0
    assert shown.text(2) == "4/10 done, 0 failed, 6 left, 2 running, 0.5 points/s, 12 s left"
    assert shown.text(0) == "4/10 done, 0 failed, 6 left, 0.5 points/s, 12 s left"
    shown.done = 10
    assert shown.text(0) == "10/10 done, 0 failed"


def test_the_last_look_of_a_tune_has_its_progress(clock, capsys):
    with JudgeProgress(20) as shown:
        for _ in range(20):
            clock[0] += 30.0
            shown.tell(1)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "on every plant of the ensemble, before and now …"
    assert lines[1] == "2/20 plants, 9 min left"
    assert lines[-1] == "20/20 plants"
