"""What the machine around a run may lack: an interface, a place to write, room on the disk."""

import json
import time
from pathlib import Path

import pytest
import warm_start

from rig.cli import invoke
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

CONFIGS = Path(__file__).parents[2] / "configs"
SHORT = [
    "--set",
    "reference.tones=[{frequency: 1 Hz, periods: 3}]",
    "--set",
    "metrics={}",
    "--set",
    "approach=0.5 s",
]
BASE = ["run", "cylinder-sine", "--configs", str(CONFIGS), "--no-report", *SHORT]
LIMIT = 300_000
"""Largest file that the run may write, bytes: full in mid-run."""


def test_missing_interface_is_named_with_what_would_mend_it(tmp_path, capsys):
    code = invoke(
        [*BASE, "--on", "hardware", "--yes", "cylinder", "--out", str(tmp_path),
         "--set", "buses.can0.channel=nocan7", "--set", "loop.priority=0",
         "--set", "cylinder.limits.stop_energy=1 J", "--set", "loop.small_margin=a test"]
    )  # fmt: skip
    said = capsys.readouterr().err
    assert code == 3
    assert "nocan7" in said
    assert "ip link" in said or "modprobe" in said
    (folder,) = tmp_path.iterdir()
    assert RunFolder.open(folder).status.value == "faulted"


@pytest.mark.parametrize(
    ("experiment", "declared", "words"),
    [
        ("cylinder-sine", [], ("limits.stop_energy is not declared", "with up to 0.182 J")),
        ("cylinder-sine", ["cylinder.limits.stop_energy=0.1 J"], ("limits.stop_energy is 0.1 J",)),
        ("joint-ideal-circle", [], ("limits.stop_energy is not declared", "1.5 J", "496 kPa")),
        (
            "joint-ideal-circle",
            ["joint.limits.stop_energy=1.4 J"],
            ("limits.stop_energy is 1.4 J",),
        ),
    ],
)
def test_hardware_without_a_stop_that_bears_a_cut_wire_is_refused(
    tmp_path, capsys, experiment, declared, words
):
    options = [part for option in declared for part in ("--set", option)]
    base = ["run", experiment, "--configs", str(CONFIGS), "--out", str(tmp_path)]
    rig = experiment.partition("-")[0]
    assert invoke([*base, "--on", "hardware", "--yes", rig, *options]) == 3
    said = " ".join(capsys.readouterr().err.split())
    for word in (*words, "cut", "mechanical stop"):
        assert word in said
    assert list(tmp_path.iterdir()) == []


def test_place_that_cannot_be_written_is_refused_before_anything_opens(capsys):
    assert invoke([*BASE, "--out", "/proc/runs"]) == 2
    assert "--out" in capsys.readouterr().err


def test_full_disk_ends_the_run_safe_with_everything_that_fitted(tmp_path):
    limited = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({LIMIT}, {LIMIT}))"
    done = warm_start.run([*BASE, "--out", tmp_path], f"{limited}\n{warm_start.RIG}")
    assert done.returncode == 4, done.stderr
    assert "log.mcap" in done.stderr
    assert "Traceback" not in done.stderr
    (path,) = tmp_path.iterdir()
    folder = RunFolder.open(path)
    assert folder.status.value == "faulted"
    log = read_log(folder.log_path)
    assert len(log.cycle) > 500
    assert list(log.cycle) == list(range(len(log.cycle)))


def test_output_is_plain_where_there_is_no_terminal(tmp_path, capfd):
    assert invoke([*BASE, "--out", str(tmp_path)]) == 0
    said = capfd.readouterr()
    assert "\x1b" not in said.err + said.out
    assert "run …" in said.err


def test_run_tells_how_fast_the_machine_was(tmp_path, capsys):
    before = time.perf_counter()
    assert invoke([*BASE, "--out", str(tmp_path)]) == 0
    whole = time.perf_counter() - before
    (path,) = tmp_path.iterdir()
    timing = json.loads((path / "timing.json").read_text(encoding="utf-8"))
    log = read_log(path / "log.mcap")
    assert 0.0 < timing["took"] < whole
    covered = timing["speed"] * timing["took"]
    assert 0.0 < covered - (log.t[-1] - log.t[0]) < 0.3  # in the end the chambers are waited for
    assert f"{covered:.1f} s took {timing['took']:.1f} s" in capsys.readouterr().err
