"""A stop in mid-walk that stays on the path: both legs come to rest as one system."""

import math

import numpy as np

from controllers.gait.plan import GaitPlan
from rig.hal import Vector


class Halt:
    """Lets the time of a plan run out evenly.

    Joints that brake one by one leave the path, each by as much as it was fast, and tear the waist
    between the feet: by 12 mm in the fastest walk. Here the joints stay on the plan's curve, so
    the feet stay where they stand; and a plan is in balance at every instant.

    Parameters
    ----------
    plan : GaitPlan
        That is being followed.
    sample : int
        That was commanded last.
    acceleration : float
        With which the fastest joint is slowed down, rad/s².
    """

    def __init__(self, plan: GaitPlan, sample: int, acceleration: float) -> None:
        fastest = float(np.max(np.abs(plan.q_dot[sample])))
        self._cycles = max(math.ceil(fastest / (acceleration * plan.period)), 1)
        self._plan = plan
        self._sample = sample
        self._cycle = 0

    @property
    def end(self) -> Vector:
        """Where the joints come to rest, rad."""
        return self._at(self._cycles)

    def advance(self) -> Vector:
        """Return where the joints go in this period, rad."""
        self._cycle += 1
        return self._at(self._cycle)

    def _at(self, cycle: int) -> Vector:
        left = max(self._cycles - cycle, 0)
        # The speed goes down by the same in every period, to nothing in the last.
        done = 0.5 * (self._cycles * (self._cycles - 1) - left * (left - 1)) / self._cycles
        last = len(self._plan.t) - 1
        place = min(self._sample + done, float(last))
        before = int(place)
        share = place - before
        q = self._plan.q
        here, there = q[before], q[min(before + 1, last)]
        return tuple((here + share * (there - here)).tolist())
