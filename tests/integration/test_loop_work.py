"""Nothing is planned, compiled or imported in the loop: that would stop a rig for many periods.

Virtual time waits for whatever a cycle takes, so that only a real rig would notice. What a law
does is counted in calls, which are the same on every computer.
"""

from pathlib import Path

import pytest
from loop_work import work_of

EXPERIMENTS = sorted(
    path.stem for path in (Path(__file__).parents[2] / "configs" / "experiments").glob("*.yaml")
)
SAMPLE = ("arm-path", "arm-tour", "cylinder-valves-sine", "joint-circle", "legs-push")
"""One of each kind of rig, and of the arm two that look ahead."""
MOST = 1000
"""Calls in a cycle. A plan takes some 200 000, a kernel that is loaded 30 000."""


def check(experiment):
    work = work_of(experiment)
    assert work.followed > 0
    assert max(work.reset, work.first, work.following, work.worst) <= MOST, work


@pytest.mark.parametrize("experiment", SAMPLE)
def test_a_law_plans_nothing_in_the_loop(experiment):
    check(experiment)


@pytest.mark.slow
@pytest.mark.sampled(8)
@pytest.mark.parametrize("experiment", [e for e in EXPERIMENTS if e not in SAMPLE])
def test_no_law_of_what_ships_plans_anything_in_the_loop(experiment):
    check(experiment)
