"""The same legs and the same step of the walk in general inverse-kinematics libraries.

All get what makes them fast: a model of the twelve joints alone (the waist is fixed and the feet
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

    def start(self, q):
        self.configuration.update(q=q.copy())

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

    def start(self, q):
        self.configuration.update(q=q.copy())

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


class DampedStep:
    """One step of damped least squares with Pinocchio's Jacobians, rates cut to their limits."""

    damping = 1e-4

    def __init__(self, plan, period):
        import pinocchio as pin

        self._pin, self._model = pin, _pinocchio_legs(pin)
        self._data = self._model.createData()
        self._soles = [self._model.getFrameId(f"{leg}_sole") for leg in LEGS]
        self._period, self._plan = period, plan
        self._q = plan.q[0].copy()

    def start(self, q):
        self._q = q.copy()

    def step(self, sample):
        pin, model, data = self._pin, self._model, self._data
        pin.computeJointJacobians(model, data, self._q)
        pin.updateFramePlacements(model, data)
        jacobian, way = np.empty((12, 12)), np.empty(12)
        for leg, sole in enumerate(self._soles):
            target = pin.SE3(np.eye(3), sole_in_waist(self._plan, sample, leg))
            rows = slice(6 * leg, 6 * leg + 6)
            way[rows] = pin.log6(data.oMf[sole].actInv(target)).vector / self._period
            jacobian[rows] = pin.getFrameJacobian(model, data, sole, pin.ReferenceFrame.LOCAL)
        square = jacobian @ jacobian.T
        square.flat[::13] += self.damping**2
        rates = jacobian.T @ np.linalg.solve(square, way)
        np.clip(rates, -GEOMETRY.max_rate, GEOMETRY.max_rate, out=rates)
        self._q = pin.integrate(model, self._q, rates * self._period)

    @property
    def angles(self):
        return self._q


class PlacoStep:
    """One step of placo."""

    def __init__(self, plan, period, folder):
        import placo

        (folder / "robot.urdf").write_text(_urdf())
        self._robot = placo.RobotWrapper(str(folder), placo.Flags.ignore_collisions)
        self._plan = plan
        self.start(plan.q[0])
        solver = self._solver = placo.KinematicsSolver(self._robot)
        solver.mask_fbase(True)
        solver.dt = period
        solver.enable_velocity_limits(True)
        self._tasks = []
        for leg in LEGS:
            task = solver.add_frame_task(f"{leg}_sole", np.eye(4))
            task.configure(leg, "soft", 1.0, 0.2)
            self._tasks.append(task)

    def start(self, q):
        for name, angle in zip(AXIS_NAMES, q, strict=True):
            self._robot.set_joint(name, angle)
        self._robot.update_kinematics()

    def step(self, sample):
        for leg, task in enumerate(self._tasks):
            pose = np.eye(4)
            pose[:3, 3] = sole_in_waist(self._plan, sample, leg)
            task.T_world_frame = pose
        self._solver.solve(True)
        self._robot.update_kinematics()

    @property
    def angles(self):
        return np.array([self._robot.get_joint(name) for name in AXIS_NAMES])


def _urdf():
    """Return the legs under a waist that stands still; a body per joint."""
    inertial = (
        '<inertial><mass value="0.1"/>'
        '<inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    axes = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
    text = f'<link name="waist">{inertial}</link>'
    for number, leg in enumerate(LEGS):
        parent, hip = "waist", (0.0, GEOMETRY.side(number), 0.0)
        for k, (axis, at) in enumerate(zip(GEOMETRY.axes, _places(hip), strict=True)):
            low, high = GEOMETRY.limits[6 * number + k]
            name = AXIS_NAMES[6 * number + k]
            text += (
                f'<link name="{name}_link">{inertial}</link><joint name="{name}" type="revolute">'
                f'<parent link="{parent}"/><child link="{name}_link"/>'
                f'<origin xyz="{" ".join(map(str, at))}"/><axis xyz="{axes[axis]}"/>'
                f'<limit lower="{low}" upper="{high}" effort="100" '
                f'velocity="{GEOMETRY.max_rate}"/></joint>'
            )
            parent = f"{name}_link"
        text += (
            f'<link name="{leg}_sole"/><joint name="{leg}_mount" type="fixed">'
            f'<parent link="{parent}"/><child link="{leg}_sole"/>'
            f'<origin xyz="0 0 {-GEOMETRY.ankle_height}"/></joint>'
        )
    return f'<robot name="legs">{text}</robot>'


def _places(hip):
    """Return where each joint of a leg is, seen from the one before it, m."""
    down = (0.0, 0.0, -GEOMETRY.thigh), (0.0, 0.0, -GEOMETRY.shank)
    return (hip, (0.0,) * 3, (0.0,) * 3, *down, (0.0,) * 3)


def _pinocchio_legs(pin):
    model = pin.Model()
    joints = {"x": pin.JointModelRX, "y": pin.JointModelRY, "z": pin.JointModelRZ}
    for number, leg in enumerate(LEGS):
        parent = 0
        hip = (0.0, GEOMETRY.side(number), 0.0)
        for k, (axis, at) in enumerate(zip(GEOMETRY.axes, _places(hip), strict=True)):
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
