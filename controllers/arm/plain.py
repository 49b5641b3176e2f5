"""What a lab would otherwise use: the plain inverse, damped least squares, halting in time.

All three follow the pose over nominal time, with the path's twist ahead and feedback of the
commanded joints' pose error, and step the joints once a period.
"""

import math
from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import Annotated, TypeVar

import numpy as np
from annotated_types import Ge, Gt, Unit
from numpy.typing import NDArray

from controllers.arm.decomposition import full_scale, joint_rates
from controllers.arm.geometry import ArmGeometry
from controllers.arm.integration import moved
from controllers.arm.kinematics import forward, jacobian_columns
from controllers.arm.law import ArmLaw, Motion, MotionEnd
from controllers.arm.online.follower import TwistFollower
from controllers.arm.online.rivals import DampedTwist, HaltingTwist
from controllers.arm.plan import Sample
from controllers.arm.promises import ALL_JOINTS, Promises
from controllers.arm.trajectory import Trajectory
from controllers.arm.types import AT_REST, Joints, Twist
from controllers.arm.vectors import along, minus, rotation_error

_HALTED = 1e-2
_DAMPING = 0.1
"""Of twists, where the settings have none: what comes is not known, and nothing can be tuned."""


@dataclass(frozen=True, slots=True)
class InverseSettings:
    """Feedback of the pose.

    Parameters
    ----------
    feedback : float
        Velocity asked for over the pose error, 1/s.
    """

    feedback: Annotated[float, Unit("1/s"), Ge(0)] = 10.0


Following = TypeVar("Following", bound=InverseSettings)


class _PoseLaw(ArmLaw[Following]):
    """Follows poses over time: what the three laws share."""

    @abstractmethod
    def rates(self, q: Joints, twist: Twist) -> Joints:
        """Return the joint rates for a twist, rad/s."""

    def share(self, q: Joints) -> float:
        """Return by how much time passes more slowly along the path here, 0 … 1."""
        del q
        return 1.0

    def move(self, trajectory: Trajectory, end: MotionEnd) -> Motion:
        """Yield a sample per period."""
        q, t, tau, waits = trajectory.start, 0.0, 0.0, False
        while tau < trajectory.duration - 1e-9:
            share = self.share(q)
            command = trajectory.twist(tau)
            if share < _HALTED:
                yield Sample(q, AT_REST, 0.0, 0.0, command)
                end.duration, end.outcome = t, "halts"
                return
            rates = self.rates(q, self._wanted(q, trajectory, tau, share))
            waits = rates == AT_REST and any(map(any, command[:2]))
            yield Sample(q, rates, share, share, command)
            step = min(self.period, (trajectory.duration - tau) / share)
            q = moved(q, rates, step)
            t, tau = t + step, tau + share * step
        yield Sample(q, AT_REST, 0.0, 0.0, trajectory.twist(tau))
        end.duration, end.outcome = t, "stalls" if waits else "done"

    def _wanted(self, q: Joints, trajectory: Trajectory, tau: float, share: float) -> Twist:
        wanted, actual = trajectory.pose(tau), forward(self.arm, q)
        linear, angular = trajectory.twist(tau)
        gain = self.settings.feedback
        away = minus(wanted.position, actual.position)
        turn = rotation_error(wanted.rotation, actual.rotation)
        ahead = (share * linear[0], share * linear[1], share * linear[2])
        turning = (share * angular[0], share * angular[1], share * angular[2])
        return Twist(along(ahead, away, gain), along(turning, turn, gain))


class _InverseLaw(_PoseLaw[Following]):
    """Follows poses by the plain velocity inverse."""

    def rates(self, q: Joints, twist: Twist) -> Joints:
        """Return ``J^-1`` times the twist; at the singularity itself the arm waits."""
        if math.sin(q[2] + self.arm.elbow_angle) == 0.0:
            return AT_REST
        return joint_rates(self.arm, q, twist.linear, twist.angular, full_scale(self.arm, q))


class Inverse(_InverseLaw[InverseSettings]):
    """The plain velocity inverse.

    Promises nothing near a singularity: rates grow without bound, and the elbow comes back on
    the side that it came from.

    References
    ----------
    Miyata et al., eq. (2)-(4) with b = 1.
    """

    Settings = InverseSettings
    name = "inverse"


@dataclass(frozen=True, slots=True)
class DampedSettings(InverseSettings):
    """Damping that grows as the arm loses manipulability.

    Parameters
    ----------
    manipulability : float
        |det J| below which the inverse is damped, m³.
    damping : float, optional
        lambda_0, at the singularity. None: the least power of sqrt(2) with which the path keeps
        the rate limits, in a region two or four times as wide if it has to be.
    """

    manipulability: Annotated[float, Gt(0)] = 0.02
    damping: Annotated[float, Ge(0)] | None = None


class DampedLeastSquares(_PoseLaw[DampedSettings]):
    """Damped least squares, tuned to the joints' rate limits.

    Promises rates within the limits. Does not keep the path near a singularity, and the elbow
    comes back on the side that it came from.

    References
    ----------
    Y. Nakamura and H. Hanafusa, "Inverse Kinematic Solutions with Singularity Robustness for
    Robot Manipulator Control", ASME Journal of Dynamic Systems, Measurement, and Control 108,
    1986; reference [1] of Miyata et al.
    """

    Settings = DampedSettings
    name = "dls"
    promises = Promises(rates=ALL_JOINTS)

    def __init__(self, settings: DampedSettings, model: ArmGeometry, period: float) -> None:
        super().__init__(settings, model, period)
        self._used = settings

    def move(self, trajectory: Trajectory, end: MotionEnd) -> Motion:
        """Yield a sample per period, once the damping is found."""
        if self.settings.damping is None:
            self._used = self._tuned(trajectory)
        return super().move(trajectory, end)

    def rates(self, q: Joints, twist: Twist) -> Joints:
        """Return ``J^T (J J^T + lambda^2)^-1`` times the twist."""
        J = np.array(jacobian_columns(self.arm, q)).T
        share = 1.0 - abs(np.linalg.det(J)) / self._used.manipulability
        damping = self._used.damping
        assert damping is not None, "move() has tuned it"
        square = (damping * max(share, 0.0)) ** 2
        wanted = np.array((*twist.linear, *twist.angular))
        solved = np.linalg.solve(J @ J.T + square * np.eye(6), wanted)
        return tuple((J.T @ solved).tolist())

    def follower(
        self, geometry: ArmGeometry, *, through: bool, rest: int | None = None
    ) -> TwistFollower:
        """Return the same inverse for twists; nothing is tuned to what is not yet known."""
        del through, rest
        damping = self.settings.damping
        return DampedTwist(
            geometry,
            self.period,
            self.settings.manipulability,
            _DAMPING if damping is None else damping,
        )

    def _tuned(self, trajectory: Trajectory) -> DampedSettings:
        """Return the narrowest region, then the least damping in it, that keeps the limits.

        Where damping alone does not, what it has put off is caught up too fast at the region's
        border. Where nothing does, the settings that come nearest.
        """
        tried: list[tuple[float, DampedSettings]] = []
        for width in (1.0, 2.0, 4.0):
            damping = 0.005
            while damping < 1.0:
                settings = replace(
                    self.settings,
                    damping=damping,
                    manipulability=width * self.settings.manipulability,
                )
                over = self._greatest_share(settings, trajectory)
                if over <= 1.0:
                    return settings
                tried.append((over, settings))
                damping *= math.sqrt(2.0)
        return min(tried, key=lambda one: one[0])[1]

    def _greatest_share(self, settings: DampedSettings, trajectory: Trajectory) -> float:
        """Return the greatest rate on the whole path over its limit."""
        law = DampedLeastSquares(settings, self.geometry, self.period)
        return max(
            abs(rate) / limit
            for sample in law.move(trajectory, MotionEnd())
            for rate, limit in zip(sample.velocities, self.geometry.rate_limits, strict=True)
        )


@dataclass(frozen=True, slots=True)
class ServoHaltSettings(InverseSettings):
    """Conditions of J at which the hand is slowed and halts.

    Parameters
    ----------
    slow, halt : float
        Condition numbers of J between which the speed goes to zero.
    """

    slow: Annotated[float, Gt(1)] = 17.0
    halt: Annotated[float, Gt(1)] = 30.0

    def __post_init__(self) -> None:
        if not self.slow < self.halt:
            raise ValueError(f"slow ({self.slow:g}) must be below halt ({self.halt:g}).")


class ServoHalt(_InverseLaw[ServoHaltSettings]):
    """The plain inverse under MoveIt Servo's rule: the hand slows to a halt before a singularity.

    The thresholds of the rule are MoveIt Servo's, too. It halts before a singularity: a path
    through one is not finished, and the plan's outcome is ``"halts"``. Promises no rates.
    """

    Settings = ServoHaltSettings
    name = "servo-halt"

    def follower(
        self, geometry: ArmGeometry, *, through: bool, rest: int | None = None
    ) -> TwistFollower:
        """Return the same rule for twists, as MoveIt Servo has it."""
        del through, rest
        return HaltingTwist(geometry, self.period, self.settings.slow, self.settings.halt)

    def share(self, q: Joints) -> float:
        """Return the share of the commanded speed, 1 … 0 between the condition numbers."""
        J: NDArray[np.float64] = np.array(jacobian_columns(self.arm, q)).T
        singular = np.linalg.svd(J, compute_uv=False)
        condition = float(singular[0] / max(singular[-1], 1e-12))
        settings = self.settings
        share: float = (settings.halt - condition) / (settings.halt - settings.slow)
        return min(max(share, 0.0), 1.0)
