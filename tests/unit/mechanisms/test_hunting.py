"""A rod that swings about a reference which rests is told of, and one that comes to rest is not."""

import json
from pathlib import Path

import numpy as np
import pytest

import rig
from rig.cli.commands import invoke
from rig.experiment.ending import EXIT_MISSED, EXIT_OK
from rig.mechanisms.pneumatic.hunting import hunts_of

CONFIGS = str(Path(rig.__file__).parents[1] / "configs")
T = np.arange(0.0, 8.0, 0.005)
"""s; the reference rises from 1 to 2 s, and rests else."""
GOAL = 0.01 * np.clip(T - 1.0, 0.0, 1.0)


@pytest.mark.parametrize("seed", range(20))
def test_a_swing_that_goes_on_is_found_with_its_size_and_frequency(seed):
    rng = np.random.default_rng((81, seed))
    frequency, size = rng.uniform(1.5, 12.0), rng.uniform(0.5e-3, 5e-3)
    swing = 0.5 * size * np.sin(2.0 * np.pi * frequency * T + rng.uniform(0.0, 6.0))
    error = swing * (T > 3.0) + rng.normal(0.0, 2e-6, len(T))
    found = hunts_of(T, GOAL, error)
    assert len(found) == 1
    (hunt,) = found
    assert hunt.frequency == pytest.approx(frequency, rel=0.05)
    assert hunt.size == pytest.approx(size, rel=0.1)
    assert 3.0 <= hunt.start < 3.0 + 1.5 / frequency
    assert hunt.end > 8.0 - 1.5 / frequency


@pytest.mark.parametrize("seed", range(20))
def test_what_dies_away_or_follows_a_moving_reference_is_none(seed):
    rng = np.random.default_rng((82, seed))
    frequency = rng.uniform(1.5, 8.0)
    phase = 2.0 * np.pi * frequency * T
    small = 0.14e-3 * np.sin(phase)
    dying = 3e-3 * np.exp(-rng.uniform(1.5, 3.0) * frequency * np.clip(T - 2.0, 0.0, None))
    dying = dying * np.sin(phase) * (T > 2.0)
    assert hunts_of(T, GOAL, small + dying) == []
    moving = 0.01 * np.sin(2.0 * np.pi * rng.uniform(0.1, 0.5) * T)
    assert hunts_of(T, moving, 2e-3 * np.sin(phase)) == []


def run(tmp_path, capsys, law, code):
    words = ["cylinder-step", "--controller", law, "--on", "sim", "--no-report", "--json"]
    if law == "super-twisting":  # no profile on regulators that are late has it
        words += ["--set", "controllers.super-twisting={}"]
    assert invoke(["run", *words, "--configs", CONFIGS, "--out", str(tmp_path / law)]) == code
    capsys.readouterr()
    (folder,) = (tmp_path / law).iterdir()
    events = [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]
    assert invoke(["explain", "--runs", str(tmp_path / law)]) == 0
    told = capsys.readouterr().out
    return [event["message"] for event in events if event["kind"] == "hunts"], told


def test_a_run_that_hunts_has_not_gone_well_though_no_bound_was_missed(tmp_path, capsys):
    (said,), told = run(tmp_path, capsys, "super-twisting", EXIT_MISSED)
    assert "the pair hunts about a reference that rests" in said
    assert "kind: oscillation" in told and "rig tune cylinder" in told
    said, told = run(tmp_path, capsys, "cascade", EXIT_OK)
    assert not said
    assert "It went well" in told
