"""A general inverse-kinematics library as a rival: mink, with its velocity limit."""

import importlib
from dataclasses import dataclass
from typing import Annotated, Any
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
from annotated_types import Gt

from controllers.gait.clamped_and_damped import RivalLaw
from controllers.gait.geometry import AXIS_NAMES, JOINTS, LEGS, LegGeometry
from controllers.gait.phase_curve import PhaseCurve
from controllers.gait.turning import rotation_of
from controllers.gait.types import GaitModel, Joints
from controllers.motion import InfeasibleMotion

_AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}


@dataclass(frozen=True, slots=True)
class MinkSettings:
    """Of mink's quadratic programme.

    Parameters
    ----------
    orientation_cost : float
        Of a sole's rotation (rad), beside 1 for its position (m).
    damping : float
        Of all joints.
    solver : str
        Any that is installed beside mink.
    """

    orientation_cost: Annotated[float, Gt(0)] = 0.2
    damping: Annotated[float, Gt(0)] = 1e-9
    solver: str = "daqp"


class MinkLaw(RivalLaw[MinkSettings]):
    """Both soles as tasks under a fixed waist, every joint's rate bounded, one step per period.

    Raises
    ------
    InfeasibleMotion
        mink or its solver is not installed.

    References
    ----------
    K. Zakka, "mink: Python inverse kinematics based on MuJoCo".
    """

    Settings = MinkSettings
    name = "mink"

    def __init__(self, settings: MinkSettings, model: GaitModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._mink, mujoco = _need("mink"), _need("mujoco")
        _need(settings.solver)
        robot = mujoco.MjModel.from_xml_string(_describe(model.geometry))
        self._configuration: Any = self._mink.Configuration(robot)
        self._tasks: list[Any] = [
            self._mink.FrameTask(f"{leg}_sole", "site", 1.0, settings.orientation_cost)
            for leg in LEGS
        ]
        rates = dict.fromkeys(AXIS_NAMES, model.geometry.max_rate)
        self._limits = [self._mink.VelocityLimit(robot, rates)]

    def _restart(self) -> None:
        super()._restart()
        self._configuration.update(q=np.array(self._joints))

    def _next(self, curve: PhaseCurve) -> Joints:
        phase, xi, mink = curve.phase, curve.path, self._mink
        waist = np.array(phase.waist_at(xi))
        heading = np.array(rotation_of((0.0, 0.0, phase.yaw_at(xi))))
        for leg, task in enumerate(self._tasks):
            target = np.eye(4)
            target[:3, :3] = heading.T @ np.array(rotation_of(phase.attitude_at(leg, xi)))
            target[:3, 3] = heading.T @ (np.array(phase.foot_at(leg, xi)) - waist)
            task.set_target(mink.SE3.from_matrix(target))
        rates = mink.solve_ik(
            self._configuration,
            self._tasks,
            self.period,
            self.settings.solver,
            self.settings.damping,
            limits=self._limits,
        )
        self._configuration.integrate_inplace(rates, self.period)
        return tuple(self._configuration.q.tolist())


def _need(module: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InfeasibleMotion(
            f"the law mink needs the package {module}, which is not installed ({error}); "
            f"`pip install mink daqp` does that."
        ) from error


def _describe(geometry: LegGeometry) -> str:
    """Return the legs' axes and lengths under a fixed waist, as MJCF; masses do not matter."""
    root = Element("mujoco")
    SubElement(root, "compiler", angle="radian")
    world = SubElement(root, "worldbody")
    for number, leg in enumerate(LEGS):
        body = world
        offsets = dict.fromkeys(JOINTS, "0 0 0") | {
            "hip_yaw": f"0 {geometry.side(number)!r} 0",
            "knee": f"0 0 {-geometry.thigh!r}",
            "ankle_pitch": f"0 0 {-geometry.shank!r}",
        }
        for joint, axis in zip(JOINTS, geometry.axes, strict=True):
            body = SubElement(body, "body", name=f"{leg}_{joint}", pos=offsets[joint])
            SubElement(body, "inertial", pos="0 0 0", mass="1", diaginertia="1 1 1")
            SubElement(body, "joint", name=f"{leg}_{joint}", axis=_AXES[axis])
        SubElement(body, "site", name=f"{leg}_sole", pos=f"0 0 {-geometry.ankle_height!r}")
    return tostring(root, encoding="unicode")
