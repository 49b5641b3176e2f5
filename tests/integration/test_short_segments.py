"""A motion with nothing to be measured in is refused by check and run; others are measured."""

import json
import random

import numpy as np
import pytest
import warm_start

from rig.export import export_run

CYCLE = 1e-3
"""Of `cylinder`, s."""


def asked(dwell, rise, approach=1e-3):
    settings = (
        "reference.levels=[0 mm, 0 mm, 0 mm]", f"reference.dwell={dwell!r} s",
        f"reference.rise={rise!r} s", f"approach={approach!r} s", "metrics={}", "figures=[timing]",
    )  # fmt: skip
    return ["cylinder-staircase", *(word for one in settings for word in ("--set", one))]


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize("seed", range(2))
def test_a_segment_of_less_than_three_cycles_is_refused_in_one_sentence(command, seed, tmp_path):
    drawn = random.Random(seed)
    dwell = drawn.uniform(1.0, 5.9) * CYCLE  # half of it is judged
    words = asked(dwell, drawn.choice([1e-3, 7.3e-3]))
    more = [] if command == "check" else ["--on", "sim"]
    ended = warm_start.run([command, *words, *more], folder=tmp_path)
    assert ended.returncode == 2
    told = ended.stdout + ended.stderr
    assert (
        "segment 'hold +0 mm #1' lasts" in told and "3 of the loop's cycles at least, 3 ms" in told
    )
    assert "Traceback" not in told and not (tmp_path / "runs").exists()


@pytest.mark.parametrize("seed", range(3))
def test_a_segment_of_three_cycles_is_measured(seed, tmp_path):
    drawn = random.Random(seed)
    dwell = drawn.choice([6.0, drawn.uniform(6.0, 9.0)]) * CYCLE
    rise = drawn.uniform(1.0, 5.0) * CYCLE
    words = ["run", *asked(dwell, rise, drawn.uniform(1e-3, 5e-3)), "--on", "sim", "--no-report"]
    ended = warm_start.run([*words, "--out", tmp_path], folder=tmp_path)
    assert ended.returncode == 0, ended.stderr
    (run,) = tmp_path.glob("*-sim")
    rows = {row["name"]: row for row in json.loads((run / "metrics.json").read_text())["metrics"]}
    log = np.load(export_run(run, "npz").path)
    t, phase = log["reference.time"], log["phase"]
    ways, spans = [], 0.0
    for number in (1, 2):
        end = number * (dwell + rise) + dwell
        held = (phase == 1) & (t >= end - 0.5 * dwell - 1e-9) & (t < end - 1e-9)
        assert held.sum() >= 2
        spans += np.ptp(t[held])
        ways.append(
            [
                np.abs(np.diff(log[f"applied.{who}"][held])).sum()
                for who in ("agonist", "antagonist")
            ]
        )
    assert rows["setpoint_rate"]["value"] == pytest.approx(np.sum(ways, axis=0).max() / spans)
