"""Commands that need nothing heavy beside an empty Python: what a shell's user waits for.

A round has every command once, one after the other; processor time is compared.
"""

import resource
import subprocess
import sys

import pytest
from intervals import ratio_of

ROUNDS = 5
WANTED = {"--help": 2.0, "list": 2.0, "check cylinder": 2.0}

pytestmark = pytest.mark.benchmark


def test_quick_commands(table):
    commands = {name: [sys.executable, "-m", "rig", *name.split()] for name in WANTED}
    commands["pass"] = [sys.executable, "-c", "pass"]
    costs = {name: [] for name in commands}
    for number in range(ROUNDS + 1):  # the first compiles what is not compiled yet
        for name, command in commands.items():
            cost = spend(command)
            costs[name] += [cost] if number else []
    table(what="python -c pass", ms=1e3 * min(costs["pass"]))
    for name, wanted in WANTED.items():
        ratio, low, high = ratio_of(costs[name], costs["pass"])
        table(
            what=f"rig {name}", over_pass=ratio, low=low, high=high, wanted=wanted,
            reached=high <= wanted, ms=1e3 * min(costs[name]),
        )  # fmt: skip
    assert min(costs["--help"]) < min(costs["list"]) < min(costs["check cylinder"])


def spend(command):
    """Return the processor time of a command, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
