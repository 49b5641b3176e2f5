"""Arms and legs that nobody commissioned are passed a quarter of the speed, on the same path."""

import numpy as np
import pytest

from rig.cli import invoke
from rig.runtime.log import read_log
from rig.runtime.phases import Phase

COMMISSIONS = True


@pytest.fixture
def run(tmp_path, pretended_hardware):
    """Return what runs an experiment on hardware that is none, and returns its log."""

    def run(experiment, rig, name, *words):
        out = tmp_path / name
        settings = ("metrics={}", "loop.small_margin=a test")
        code = invoke([
            "run", experiment, "--rig", rig, "--no-report", "--on", "hardware", "--yes", rig,
            "--configs", str(pretended_hardware), "--out", str(out), *words,
            *(word for option in settings for word in ("--set", option)),
        ])  # fmt: skip
        folders = list(out.iterdir()) if out.exists() else []
        return code, read_log(folders[0] / "log.mcap") if folders else None

    return run


def motion(log, kind):
    runs = log.column("phase") == Phase.RUN
    names = [
        n for n in (column.name for column in log.columns) if n.startswith(f"{kind}.position_")
    ]
    return np.column_stack([log.column(name)[runs] for name in names])


CASES = [
    pytest.param("arm-wrist-hit", "arm", (), id="arm", marks=pytest.mark.slow),
    pytest.param(
        "legs-squat", "legs-can", ("--set", "reference.repeats=1"), id="legs-can",
        marks=pytest.mark.slow,
    ),
]  # fmt: skip


@pytest.mark.parametrize(("experiment", "rig", "words"), CASES)
def test_it_goes_the_same_way_at_a_quarter_of_the_speed(run, experiment, rig, words):
    code, whole = run(experiment, rig, "whole", "--uncommissioned", "a test", *words)
    assert code == 0
    code, slow = run(experiment, rig, "slow", *words)
    assert code == 0
    fast_way, slow_way = motion(whole, "applied"), motion(slow, "applied")
    settled = 50 if rig == "arm" else 0  # cycles, however long the motion takes
    assert len(slow_way) - settled == pytest.approx(4 * (len(fast_way) - settled), rel=0.01)
    peak = [np.abs(np.diff(way, axis=0)).max() for way in (fast_way, slow_way)]
    assert 0.2 < peak[1] / peak[0] < 0.27
    # Every posture of the one is one of the other.
    apart = [np.abs(slow_way - posture).max(axis=1).min() for posture in fast_way[::40]]
    assert max(apart) < 2e-3
    followed = np.abs(motion(slow, "reading") - slow_way).max()
    assert followed <= np.abs(motion(whole, "reading") - fast_way).max() + 1e-3


def test_a_motion_that_needs_its_speed_is_refused(run, capsys):
    code, log = run("arm-twist", "arm", "slow")
    assert (code, log) == (3, None)
    assert "no more slowly" in " ".join(capsys.readouterr().err.split())
