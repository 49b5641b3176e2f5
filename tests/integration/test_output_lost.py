"""Output that cannot be written: on a full disk, and where the shell has closed it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rig.hal import Column
from rig.run_facts import RunStatus
from rig.run_folder import RunFolder
from rig.runtime.recorder import LogRecorder


@pytest.mark.parametrize(
    "words",
    [["--help"], ["--version"], ["sweep", "--help"], ["list", "rigs"], ["list", "rigs", "--json"],
     ["check", "cylinder"]],
    ids=" ".join,
)  # fmt: skip
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_output_that_cannot_be_written_is_a_sentence(words, unbuffered):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "rig", *words], stdout=full, stderr=subprocess.PIPE, text=True,
            env={**os.environ, "PYTHONUNBUFFERED": unbuffered}, check=False,
        )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.startswith("error: cannot write the output: No space left on device\n")
    assert "Traceback" not in done.stderr and done.stderr.count("cannot write") == 1


def a_run(out, position):
    """Make a run folder with a log of one cycle."""
    inputs = {"profile.yaml": "name: x\n", "experiment.yaml": "name: y\n"}
    folder = RunFolder.create(out, "sine", "sim", inputs=inputs)
    with LogRecorder(folder.log_path, [Column("reading.position", "m", "position")]) as recorder:
        recorder.write(0, 0.0, (position,))
    folder.finish(RunStatus.OK, 0)
    return str(folder.path)


def test_output_that_cannot_be_written_hides_no_other_end(tmp_path):
    runs = [a_run(tmp_path, position) for position in (0.0, 1.0)]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "rig", "diff", *runs], stdout=full, stderr=subprocess.PIPE,
            text=True, check=False,
        )  # fmt: skip
    assert done.returncode == 1 and "cannot write the output" in done.stderr


def test_output_that_nobody_wants_is_no_error():
    words = f"{sys.executable} -m rig list rigs >&-"
    assert subprocess.run(["sh", "-c", words], stderr=subprocess.PIPE, check=False).returncode == 0
