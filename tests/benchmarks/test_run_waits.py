"""What somebody waits for beside the simulated motion: `rig run` with a report, without, and cold.

A round has each way once, one after the other. Beyond the motion is the time on the clock less what
the loop says that it took; so other work on the machine counts, and a quiet one is to be had. A
first run after an installation compiles what runs in the cycle: processor time is compared.
"""

import os
import re
import resource
import subprocess
import sys
import time

import numpy as np
import pytest
from intervals import ratio_of

ROUNDS = 5
EXPERIMENTS = ("cylinder-step", "arm-wrist-hit", "legs-walk")
COLD = ("cylinder-sine", "joint-circle", "legs-walk")
WANTED, WANTED_WITHOUT, WANTED_COLD = 1.5, 0.7, 1.5
"""Beyond the motion, s, with and without a report; a first run over a warm one."""
_TOOK = re.compile(r"s took ([\d.]+) s")

pytestmark = pytest.mark.benchmark


@pytest.mark.parametrize("experiment", EXPERIMENTS)
def test_beyond_the_motion(tmp_path, table, experiment):
    ways = {"with a report": ((), WANTED), "without": (("--no-report",), WANTED_WITHOUT)}
    waited = {way: [] for way in ways}
    for number in range(ROUNDS + 1):  # the first compiles what is not compiled yet
        for way, (words, _) in ways.items():
            beyond, _ = run(experiment, *words, "--out", str(tmp_path))
            waited[way] += [beyond] if number else []
    for way, (_, wanted) in ways.items():
        median, low, high = ratio_of(waited[way], np.ones(ROUNDS))
        table(
            what=f"{experiment}, {way}", s=median, low=low, high=high, wanted=wanted,
            reached=high <= wanted,
        )  # fmt: skip
    assert min(waited["without"]) < min(waited["with a report"])


@pytest.mark.parametrize("experiment", COLD)
def test_first_run(tmp_path, table, experiment):
    costs = {"first": [], "warm": []}
    for number in range(ROUNDS):
        for way, cost in costs.items():
            cache = tmp_path / f"kernels-{number}"
            _, spent = run(experiment, "--no-report", "--out", str(tmp_path), NUMBA_CACHE_DIR=cache)
            cost.append(spent)
            assert way == "warm" or cache.is_dir()
    ratio, low, high = ratio_of(costs["first"], costs["warm"])
    table(
        what=f"a first {experiment}", over_warm=ratio, low=low, high=high, wanted=WANTED_COLD,
        reached=high <= WANTED_COLD, s=min(costs["first"]),
    )  # fmt: skip


def run(experiment, *words, **surroundings):
    """Run an experiment; return the time beyond its motion and the processor time, s."""
    command = [sys.executable, "-m", "rig", "run", experiment, "--on", "sim", *words]
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    done = subprocess.run(
        command, check=False, capture_output=True, text=True,
        env=os.environ | {name: str(value) for name, value in surroundings.items()},
    )  # fmt: skip
    waited = time.monotonic() - began
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    found = _TOOK.search(done.stderr)
    assert found is not None, done.stderr
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return waited - float(found[1]), spent
