"""Figures drawn on two processors are those drawn on one, and what fails is said by either."""

import os
import subprocess
import sys

import pytest

DRAW = """
import os, sys
os.sched_setaffinity(0, set(map(int, sys.argv[2].split(","))))
import rig.report.figures as figures
from rig.report.figure import FigureKind
known = figures.known_figures
def broken(run):
    raise ZeroDivisionError(f"in {os.getpid()}")
figures.known_figures = lambda mechanism: {**known(mechanism), "broken": FigureKind(broken, "b")}
drawn = figures.draw_figures(sys.argv[1], ["tracking", "broken", "error", "pressures"])
print(*(file.name for file in drawn.files))
print(*drawn.failures, os.getpid())
"""


def draw(run, processors):
    for path in (run / "figures").glob("*"):
        path.unlink()
    ended = subprocess.run(
        [sys.executable, "-c", DRAW, str(run), ",".join(map(str, processors))],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    names, failures = ended.stdout.splitlines()
    return names, failures, {path.name: path.read_bytes() for path in (run / "figures").iterdir()}


def test_two_processors_draw_what_one_draws(make_run):
    processors = sorted(os.sched_getaffinity(0))[:2]
    if len(processors) < 2:
        pytest.skip("this machine has one processor")
    run = make_run(duration=1.0)
    names, failures, one = draw(run, processors[:1])
    assert "broken" in failures
    drawer, parent = (word for word in failures.split() if word.isdigit())
    assert drawer == parent
    names_of_two, failures, two = draw(run, processors)
    drawer, parent = (word for word in failures.split() if word.isdigit())
    assert drawer != parent  # else nothing was shared out
    assert names_of_two == names
    assert two == one
    assert set(names.split()) == set(two)
