"""``rig --help`` beside an empty Python: what a shell's user waits for, in CPU time."""

import resource
import subprocess
import sys
from pathlib import Path
from statistics import median

import pytest

ROUNDS = 15
BOUND = 3.0

pytestmark = pytest.mark.benchmark


def test_help_cost(table):
    commands = {
        "rig --help": [str(Path(sys.executable).with_name("rig")), "--help"],
        "python -c pass": [sys.executable, "-c", "pass"],
    }
    costs = {name: [] for name in commands}
    for command in commands.values():  # compiles what is not compiled yet
        spend(command)
    for _ in range(ROUNDS):
        for name, command in commands.items():
            costs[name].append(spend(command))
    ours, theirs = (median(costs[name]) for name in commands)
    for name in commands:
        table(what=name, ms=1e3 * median(costs[name]), worst_ms=1e3 * max(costs[name]))
    table(what="ratio", ratio=ours / theirs, bound=BOUND)
    assert ours <= BOUND * theirs


def spend(command):
    """Return the CPU time of a command, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
