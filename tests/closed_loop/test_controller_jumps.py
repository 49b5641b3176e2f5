"""A controller that jumps or loses its numbers: named in the same cycle, and the rig rests.

On production drivers, judged by the plant until well after the end. Axis, instant and size are
drawn; the sizes go from what an axis does in a fifth of a second to what no axis has.
"""

import math
import random

import numpy as np
import pytest
from stop_bench import Stopped

from controllers.arm.geometry import AXIS_NAMES as ARM
from controllers.gait.geometry import AXIS_NAMES as LEGS
from rig.assembly import Backend
from rig.hal import SafetyError

DRAWN = random.Random(1708)
RATES = np.array((1.0, 1.0, 1.0, 2.0, 2.0, 2.0))
"""Of the arm's axes, rad/s."""
CIRCLE = ("reference.rate=0.5 rad/s",)
WALK = ("reference.landings=1", "reference.speed=5")


class Spoilt:
    """A controller that commands something else of one axis from an instant on, s."""

    def __init__(self, inner, at, axis, value, *, adds):
        self.inner, self.period = inner, inner.period
        self.at, self.axis, self.value, self.adds = at, axis, value, adds
        self.cycles, self.spoilt = 0, 0

    def reset(self, state):
        self.inner.reset(state)

    def update(self, state, reference):
        command = self.inner.update(state, reference)
        self.cycles += 1
        if self.cycles * self.period < self.at:
            return command
        self.spoilt += 1
        positions = list(command.positions)
        positions[self.axis] = self.value + (positions[self.axis] if self.adds else 0.0)
        return command._replace(positions=tuple(positions))


def draw(count, rigs, last):
    cases = []
    for k in range(count):
        rig, names = rigs[k % len(rigs)]
        size = math.exp(DRAWN.uniform(math.log(0.2), math.log(10.0)))
        value, adds = DRAWN.choice(
            ((math.nan, False), (1e9, False), (-1e9, False), (size, True), (-size, True))
        )
        cases.append((rig, DRAWN.uniform(0.0, last), names, DRAWN.randrange(len(names)),
                      value, adds))  # fmt: skip
    return cases


def run(experiment, options, case):
    rig, at, names, axis, value, adds = case
    made = []

    def spoil(controller):
        made.append(Spoilt(controller, at, axis, value, adds=adds))
        return made[0]

    stopped = Stopped(experiment, (*options, f"rig={rig}"), Backend.VIRTUAL, None, spoil)
    fault = stopped.outcome.fault
    assert isinstance(fault, SafetyError)
    assert f"the controller's command of {names[axis]} " in str(fault)
    assert made[0].spoilt == 1, "in the same cycle"
    return stopped


@pytest.mark.parametrize("case", draw(6, [("arm", ARM), ("arm-odrive", ARM)], 4.0))
def test_an_arm_comes_to_rest_within_its_rates(case):
    stopped = run("arm-elbow-circle", CIRCLE, case)
    speeds = np.column_stack([stopped.column(f"q{k}_velocity") for k in range(1, 7)])
    assert (np.abs(speeds).max(axis=0) < 1.3 * RATES).all()
    after = np.column_stack([stopped.during_stop(f"q{k}_velocity") for k in range(1, 7)])
    assert np.abs(after[-1]).max() < 1e-2, "at rest"


@pytest.mark.parametrize("case", draw(6, [("legs", LEGS), ("legs-can", LEGS)], 4.0))
def test_legs_stand(case):
    assert run("legs-walk", WALK, case).column("fell")[-1] == 0.0
