"""How much a law does in a cycle, counted and not timed: run as a program, it says so in JSON.

Every process is a new one, because what is imported, compiled or worked out for the first time is
so once in a process.
"""

import json
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple
from unittest import mock

SECONDS = 2.5
"""Of which the first one is the approach."""


class Work(NamedTuple):
    """Calls of functions, Python's and C's.

    Parameters
    ----------
    reset : int
        When the law takes over.
    first : int
        In the first cycle.
    following : int
        In the first cycle of the motion.
    worst : int
        In any other cycle.
    followed : int
        So many cycles of the motion there were.
    """

    reset: int
    first: int
    following: int
    worst: int
    followed: int


def work_of(experiment: str) -> Work:
    """Return what an experiment's law does as the loop runs it, in a process of its own."""
    done = subprocess.run(
        [sys.executable, __file__, experiment],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        cwd=Path(__file__).parents[2],
    )
    assert done.returncode == 0, done.stderr
    return Work(*json.loads(done.stdout.splitlines()[-1]))


def _counted(experiment: str) -> Work:
    from rig.testing import rehearsal

    calls: list[int] = []

    class Counting(rehearsal.Noting):
        """Counts what the law calls."""

        def reset(self, state: object) -> None:
            with _Counting(calls):
                super().reset(state)

        def update(self, state: object, reference: object) -> object:
            with _Counting(calls):
                return super().update(state, reference)

    with mock.patch.object(rehearsal, "Noting", Counting):
        done = rehearsal.rehearse(None, experiment, seconds=SECONDS)
    period = done.plan.profile.loop.period
    begins = 1 + round(1.0 / period)
    reset, first, *others = calls
    return Work(reset, first, others[begins - 2], max(others), len(calls) - begins)


class _Counting:
    """Appends to `calls` how many there were."""

    def __init__(self, calls: list[int]) -> None:
        self._calls = calls
        self._number = 0

    def __enter__(self) -> None:
        sys.setprofile(self._count)

    def __exit__(self, *_: object) -> None:
        sys.setprofile(None)
        self._calls.append(self._number)

    def _count(self, _: object, event: str, __: object) -> None:
        self._number += event in ("call", "c_call")


if __name__ == "__main__":
    sys.stdout.write(json.dumps(_counted(sys.argv[1])) + "\n")
