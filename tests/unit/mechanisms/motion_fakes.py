"""Plans written by hand, and an arm and legs on drives that stand where a test says."""

from typing import NamedTuple

import numpy as np
from servo_fakes import ACCELERATION, AGE, FOLLOWING, PERIOD, FakeServo

from controllers.arm.geometry import AXIS_NAMES as ARM_NAMES
from controllers.arm.paths import DwellLine
from controllers.arm.plan import ArmPlan
from controllers.gait.geometry import AXIS_NAMES as LEG_NAMES
from controllers.gait.laws import MinimumJerkLaw, NoSettings
from controllers.gait.motions import SquatSettings
from controllers.gait.types import GaitModel
from rig.mechanisms.arm.mechanism import Arm, PlannedArmMotion
from rig.mechanisms.arm.settings import ArmSettings
from rig.mechanisms.legs.mechanism import Legs, PlannedGait
from rig.mechanisms.legs.settings import LegsSettings
from rig.mechanisms.servo.settings import ServoLimits

LIMITS = ServoLimits(FOLLOWING, AGE, ACCELERATION)
LEFT_MID = (0.5, 0.1, 0.0, 1.0, 0.0, 0.0)
MID = (-0.5, -0.1, *LEFT_MID[2:], *LEFT_MID)
"""A posture of the legs that is far from every limit."""


def arm_plan(count=5, period=PERIOD, **changes):
    """Return a plan of some cycles in which every number of a row says which row it is."""
    rows = np.arange(count, dtype=float)

    def filled(width):
        return np.repeat(rows[:, None], width, axis=1)

    values = {
        "law": "by hand",
        "outcome": "done",
        "period": period,
        "duration": (count - 1) * period,
        "t": period * rows,
        "positions": filled(6) / 64,
        "velocities": np.ones((count, 6)),
        "scale": filled(2),
        "command": filled(6),
        "hand": filled(3),
        "twist": filled(6),
        "indices": 0.5 + filled(3) / 64,
        "inside": 0.25 + rows,
        "path": filled(3),
    }
    return ArmPlan(**(values | changes))


def arm_motion(**changes):
    return PlannedArmMotion(arm_plan(**changes), ArmSettings(("servo",), LIMITS).geometry, PATH)


PATH = DwellLine()


class ArmBench:
    """An arm on one device."""

    def __init__(self):
        self.servo = FakeServo("servo", ARM_NAMES)
        self.arm = Arm.assemble(ArmSettings(("servo",), LIMITS), {"servo": self.servo}, PERIOD)


class CurvePlan(NamedTuple):
    """What a halt needs of a walk's plan."""

    period: float
    t: np.ndarray
    q: np.ndarray
    q_dot: np.ndarray


def straight_plan(count=20, speeds=(1.0, -0.5)):
    """Return a plan in which each joint turns at one speed."""
    t = PERIOD * np.arange(count)
    return CurvePlan(PERIOD, t, np.outer(t, speeds), np.tile(speeds, (count, 1)))


def squat(period=PERIOD, **settings):
    """Return a knee bend that stands for any motion of the legs."""
    values = {"knee_min": 0.5, "time": 1.0, "repeats": 1}
    return MinimumJerkLaw(NoSettings(), GaitModel(), period).prepare(
        SquatSettings(**(values | settings))
    )


class LegsBench:
    """Two legs on one device, and a knee bend that they follow."""

    def __init__(self):
        self.servo = FakeServo("servo", LEG_NAMES)
        self.legs = Legs.assemble(LegsSettings(("servo",), LIMITS), {"servo": self.servo}, PERIOD)
        self.plan = squat()
        self.motion = PlannedGait(self.plan, self.plan)

    def start(self, positions):
        self.servo.angles = tuple(positions)
        state = self.legs.read(0.0)
        self.legs.start_limiting(state)
        return state

    def follow(self, cycles):
        """Follow the plan from its start and return the state of the last cycle."""
        self.legs.motion = self.motion
        state = self.start(self.plan.q[0].tolist())
        for cycle in range(cycles):
            reference = self.motion.at(cycle * PERIOD)
            applied = self.legs.limit(reference)
            self.servo.angles = applied.positions
            self.legs.row(state, reference, applied, applied)
        return state
