"""File systems that are full or read-only: mounted for the test, in a namespace of its own."""

import functools
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

CONFIGS = Path(__file__).parents[2] / "configs"
_OWN = ("unshare", "--map-root-user", "--mount")


@functools.cache
def can_mount():
    if shutil.which("unshare") is None:
        return False
    tried = subprocess.run(
        [*_OWN, "mount", "-t", "tmpfs", "none", "/mnt"], capture_output=True, check=False
    )
    return tried.returncode == 0


pytestmark = pytest.mark.skipif(not can_mount(), reason="nothing may be mounted here")


def mounted(folder, options, words, after="true"):
    """Run rig where a small file system is mounted; return its code, stderr and `after`'s text."""
    script = (
        f'mount -t tmpfs -o {options} none "$1" || exit 99\ncd "$1"\nshift\n"$@"\ncode=$?\n'
        f"{after}\nexit $code"
    )
    command = [sys.executable, "-m", "rig", *words]
    done = subprocess.run(
        [*_OWN, "sh", "-c", script, "sh", str(folder), *command],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.returncode, done.stderr, done.stdout


MADE = [
    ["new", "rig", "ours", "--like", "cylinder"],
    ["new", "experiment", "ours", "--like", "cylinder-sine"],
    *(["new", kind, "ours"] for kind in ("controller", "driver", "mechanism")),
]


@pytest.mark.parametrize("words", MADE, ids=lambda words: words[1])
@pytest.mark.parametrize("inodes", [2, 100])
def test_a_full_disk_leaves_nothing_of_what_is_begun(tmp_path, words, inodes):
    # tmpfs gives room by pages of 4 kB, and the first of two inodes is its own folder.
    code, told, left = mounted(tmp_path, f"size=4k,nr_inodes={inodes}", words, "ls -A")
    if code == 0:
        assert words[1] == "experiment"  # which is short
        return
    assert code == 2, told
    assert "cannot write ours" in told and "No space left on device" in told
    assert left == ""


@pytest.mark.parametrize("words", MADE[::2], ids=lambda words: words[1])
def test_with_room_all_of_it_is_there(tmp_path, words):
    code, told, left = mounted(tmp_path, "size=4M", words, "ls -A")
    assert code == 0, told
    assert left.split() == ["ours.yaml" if words[1] == "rig" else "ours"]


ASKED = [
    MADE[0],
    ["commission", "cylinder", "--configs", str(CONFIGS), "--out", "runs"],
    ["doctor", "cylinder"],
]


@pytest.mark.parametrize("words", ASKED, ids=lambda words: words[0])
def test_nobody_is_told_to_own_what_is_read_only(tmp_path, words):
    code, told, shown = mounted(tmp_path, "ro", words)
    assert code != 0
    said = told + shown
    assert "chown" not in said
    assert "read-only" in said
    assert f"sudo mount -o remount,rw {tmp_path}" in said


def without_shared_memory(folder, options, words):
    """Run rig where nothing can be written to /dev/shm; return its code and what it said."""
    script = 'mount -t tmpfs -o "$1" none /dev/shm || exit 99\nshift\nexec "$@"'
    done = subprocess.run(
        [*_OWN, "sh", "-c", script, "sh", options, sys.executable, "-m", "rig", *words],
        capture_output=True, text=True, check=False, cwd=folder,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("options", ["ro", "size=4k,nr_inodes=1"])
def test_runs_and_reports_need_no_shared_memory(tmp_path, options):
    words = ["run", "cylinder-step", "--on", "sim", "--out", "."]
    code, _, told = without_shared_memory(tmp_path, options, words)
    assert code == 0 and "no report" not in told and "/dev/shm" not in told, told
    (run,) = tmp_path.iterdir()
    pages = {path.name: path.read_bytes() for path in (run / "figures").iterdir()}
    assert len(pages) > 4
    shutil.rmtree(run / "figures")
    code, shown, told = without_shared_memory(tmp_path, options, ["report", str(run)])
    assert (code, told, shown.strip()) == (0, "", str(run / "report.html"))
    assert {path.name: path.read_bytes() for path in (run / "figures").iterdir()} == pages


def test_without_shared_memory_a_comparison_goes_through_its_runs_in_turn(tmp_path):
    varied = ["--vary", "approach=1 s,2 s", "--set", "figures=[timing]", "--json"]
    words = ["compare", "cylinder-step", "--on", "sim", *varied]
    code, shown, told = without_shared_memory(tmp_path, "ro", words)
    assert code == 0, told
    assert told.count("one after the other: /dev/shm cannot be used: Read-only file system") == 1
    assert json.loads(shown)["labels"] == ["approach 1 s", "approach 2 s"]
