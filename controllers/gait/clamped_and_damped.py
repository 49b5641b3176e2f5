"""What else is done about singularities: the plain law's path, by joints that do not quite follow.

They are here to be compared with. Near the straight knee both leave the path, and each leg on its
own: the waist is torn between the feet.
"""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Gt
from numpy.typing import NDArray

from controllers.base import Chosen
from controllers.gait.kinematics import LegAngles, jacobian, waist_from_foot
from controllers.gait.law import GaitLaw, PaceMaker, TimedPhase
from controllers.gait.laws import NoSettings
from controllers.gait.phase_curve import PhaseCurve
from controllers.gait.time_laws import ConstantPathPace
from controllers.gait.turning import rotation_of
from controllers.gait.types import GaitModel, Joints, LegsCommand

Array = NDArray[np.float64]


class RivalLaw(GaitLaw[Chosen]):
    """Constant speed along the path; the joints are a matter of their own."""

    def __init__(self, settings: Chosen, model: GaitModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._joints: Joints = ()

    def _pace_maker(self, phases: Sequence[TimedPhase], speed: float) -> PaceMaker:
        return lambda entry: ConstantPathPace(entry.cycles)

    def _restart(self) -> None:
        super()._restart()
        self._joints = self._schedule[0].curve.joints

    def _command(self, curve: PhaseCurve, moved: bool) -> LegsCommand:
        before, after = self._joints, self._next(curve)
        self._joints = after
        rate = 1.0 / self.period
        return LegsCommand(
            after, tuple([rate * (b - a) for a, b in zip(before, after, strict=True)])
        )

    @abstractmethod
    def _next(self, curve: PhaseCurve) -> Joints:
        """Return where the joints go from `_joints` in this period."""


class ClampedLaw(RivalLaw[NoSettings]):
    """The closed-form inverse, with each joint cut at its greatest rate."""

    Settings = NoSettings
    name = "clamp"
    keeps_rates = True

    def _next(self, curve: PhaseCurve) -> Joints:
        most = self.model.geometry.max_rate * self.period
        return tuple(
            [
                here + min(max(there - here, -most), most)
                for here, there in zip(self._joints, curve.joints, strict=True)
            ]
        )


@dataclass(frozen=True, slots=True)
class DampedGaitSettings:
    """Of damped least squares.

    Parameters
    ----------
    damping : float
        λ, with lengths in terms of the thigh's.
    """

    damping: Annotated[float, Gt(0)] = 0.05


class DampedLaw(RivalLaw[DampedGaitSettings]):
    """Damped least squares towards the path, each leg on its own.

    References
    ----------
    Y. Nakamura, H. Hanafusa, "Inverse kinematic solutions with singularity robustness for robot
    manipulator control", J. Dyn. Sys., Meas., Control 108(3), 1986.
    """

    Settings = DampedGaitSettings
    name = "dls"

    def _next(self, curve: PhaseCurve) -> Joints:
        phase, xi = curve.phase, curve.path
        waist = np.array(phase.waist_at(xi))
        joints: list[float] = []
        for leg in (0, 1):
            sole = np.array(rotation_of(phase.attitude_at(leg, xi)))
            seen = sole.T @ (waist - np.array(phase.foot_at(leg, xi)))
            turned = sole.T @ np.array(rotation_of((0.0, 0.0, phase.yaw_at(xi))))
            first, second, third, fourth, fifth, sixth = self._joints[6 * leg : 6 * leg + 6]
            angles = (first, second, third, fourth, fifth, sixth)
            joints += self._leg(leg, angles, seen, turned)
        return tuple(joints)

    def _leg(self, leg: int, q: LegAngles, waist: Array, turned: Array) -> list[float]:
        geometry = self.model.geometry
        position, rotation = waist_from_foot(geometry, leg, q)
        R = np.array(rotation) @ turned.T
        # The rotation vector that is left to the wanted one, for small angles.
        lean = 0.5 * np.array((R[1, 2] - R[2, 1], R[2, 0] - R[0, 2], R[0, 1] - R[1, 0]))
        scale = np.repeat((1.0 / geometry.thigh, 1.0), 3)
        error = scale * np.concatenate((waist - position, lean))
        J = scale[:, None] * jacobian(geometry, leg, q)
        damped = J @ J.T + self.settings.damping**2 * np.eye(6)
        moved: list[float] = (np.array(q) + J.T @ np.linalg.solve(damped, error)).tolist()
        return moved
