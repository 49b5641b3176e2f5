"""The same legs and the same step of the walk in general inverse-kinematics libraries.

Both get what makes them fast: a model of the twelve joints alone (the waist is fixed and the feet
move under it), one task per foot, the velocity limit, and the quickest solver that they share.
"""

import numpy as np

from controllers.gait.geometry import AXIS_NAMES, LEGS, LegGeometry
from drivers.sim.plants.legs_model import describe
from drivers.sim.plants.legs_settings import LegServoSettings

GEOMETRY = LegGeometry()
SOLVER = "daqp"


def sole_in_waist(plan, sample, leg):
    """Return where a sole should be under the waist, m."""
    return plan.feet[sample, leg] - plan.waist[sample]


class MinkStep:
    """One step of mink."""

    def __init__(self, plan, period):
        import mink
        import mujoco

        text = describe(GEOMETRY, LegServoSettings(), 0.8, period)
        model = mujoco.MjModel.from_xml_string(text.replace('<freejoint name="waist" />', ""))
        self._mink = mink
        self._period = period
        self._plan = plan
        self.configuration = mink.Configuration(model, q=plan.q[0].copy())
        self._tasks = [
            mink.FrameTask(f"{leg}_sole", "site", position_cost=1.0, orientation_cost=0.2)
            for leg in LEGS
        ]
        rates = dict.fromkeys(AXIS_NAMES, GEOMETRY.max_rate)
        self._limits = [mink.VelocityLimit(model, rates)]

    def step(self, sample):
        mink = self._mink
        for leg, task in enumerate(self._tasks):
            at = sole_in_waist(self._plan, sample, leg)
            task.set_target(mink.SE3.from_translation(at))
        rates = mink.solve_ik(
            self.configuration, self._tasks, self._period, SOLVER, 1e-9, limits=self._limits
        )
        self.configuration.integrate_inplace(rates, self._period)

    @property
    def angles(self):
        return self.configuration.q


class PinkStep:
    """One step of Pink."""

    def __init__(self, plan, period):
        import pink
        import pinocchio as pin
        from pink.limits import VelocityLimit

        model = _pinocchio_legs(pin)
        self._pink, self._pin = pink, pin
        self._period = period
        self._plan = plan
        self.configuration = pink.Configuration(model, model.createData(), plan.q[0].copy())
        self._tasks = [
            pink.FrameTask(f"{leg}_sole", position_cost=1.0, orientation_cost=0.2) for leg in LEGS
        ]
        self._limits = [VelocityLimit(model)]

    def step(self, sample):
        pin = self._pin
        for leg, task in enumerate(self._tasks):
            at = sole_in_waist(self._plan, sample, leg)
            task.set_target(pin.SE3(np.eye(3), at))
        rates = self._pink.solve_ik(
            self.configuration,
            self._tasks,
            self._period,
            solver=SOLVER,
            damping=1e-9,
            limits=self._limits,
        )
        self.configuration.integrate_inplace(rates, self._period)

    @property
    def angles(self):
        return self.configuration.q


def _pinocchio_legs(pin):
    model = pin.Model()
    joints = {"x": pin.JointModelRX, "y": pin.JointModelRY, "z": pin.JointModelRZ}
    down = (0.0, 0.0, -GEOMETRY.thigh), (0.0, 0.0, -GEOMETRY.shank)
    for number, leg in enumerate(LEGS):
        parent = 0
        hip = (0.0, GEOMETRY.side(number), 0.0)
        places = (hip, (0.0,) * 3, (0.0,) * 3, *down, (0.0,) * 3)
        for k, (axis, at) in enumerate(zip(GEOMETRY.axes, places, strict=True)):
            low, high = GEOMETRY.limits[6 * number + k]
            parent = model.addJoint(
                parent,
                joints[axis](),
                pin.SE3(np.eye(3), np.array(at)),
                AXIS_NAMES[6 * number + k],
                np.array([100.0]),
                np.array([GEOMETRY.max_rate]),
                np.array([low]),
                np.array([high]),
            )
        sole = pin.SE3(np.eye(3), np.array((0.0, 0.0, -GEOMETRY.ankle_height)))
        model.addFrame(pin.Frame(f"{leg}_sole", parent, sole, pin.FrameType.OP_FRAME))
    return model
