"""What a lab would otherwise follow twists with: damped least squares, and a servo that halts."""

import math
from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of, jacobian_columns
from controllers.arm.on_direction.numbers import Six
from controllers.arm.online.follower import TwistFollower
from controllers.arm.types import AT_REST

Array = NDArray[np.float64]

_LEAVING = 2.0
"""Times as far beyond `slow` as `halt` a hand is halted that moves away from the singularity."""
_AHEAD = 1e-3
"""Share of a second by which one looks ahead whether the condition gets worse."""


class _Clamped(TwistFollower):
    """Rates from some inverse, held within the limits without a look ahead.

    All joints are slowed down alike, in rate and then in acceleration, as usual in such servos;
    at its range a joint stops.
    """

    def __init__(self, geometry: ArmGeometry, period: float) -> None:
        self.arm = dimensions_of(geometry)
        self._geometry, self._period = geometry, period
        self._limits = np.array(geometry.rate_limits)
        self._steps = period * np.array(geometry.acceleration_limits)
        self.rest(AT_REST)

    def rest(self, positions: Six) -> None:
        """See `TwistFollower.rest`."""
        self.positions = positions
        self._rates = np.zeros(6)

    def jacobian(self, q: Six) -> Array:
        """Return J, shape (6, 6)."""
        return np.array(jacobian_columns(self.arm, q)).T

    @abstractmethod
    def wanted(self, asked: Six) -> Array:
        """Return the rates that some inverse makes of a twist, rad/s."""

    def step(self, asked: Six) -> tuple[Six, Six]:
        """See `TwistFollower.step`."""
        wanted = self.wanted(asked) if any(asked) else np.zeros(6)
        wanted = wanted / max(1.0, float((np.abs(wanted) / self._limits).max()))
        change = wanted - self._rates
        rates = self._rates + change / max(1.0, float((np.abs(change) / self._steps).max()))
        before = np.array(self.positions)
        after = np.clip(
            before + self._period * rates, self._geometry.position_min, self._geometry.position_max
        )
        self._rates = (after - before) / self._period
        self.positions = tuple(after.tolist())
        q1, q2, q3, q4, q5, q6 = self._rates.tolist()
        return self.positions, (q1, q2, q3, q4, q5, q6)


class DampedTwist(_Clamped):
    """Damped least squares: bends the direction, and goes on at a singularity.

    Parameters
    ----------
    geometry, period
        See `OnDirection`.
    manipulability, damping : float
        See `DampedSettings`.

    References
    ----------
    Y. Nakamura and H. Hanafusa, ASME J. Dynamic Systems, Measurement, and Control 108, 1986.
    """

    def __init__(
        self, geometry: ArmGeometry, period: float, manipulability: float, damping: float
    ) -> None:
        super().__init__(geometry, period)
        self._manipulability, self._damping = manipulability, damping

    def wanted(self, asked: Six) -> Array:
        """Return ``J^T (J J^T + lambda^2)^-1`` times the twist."""
        J = self.jacobian(self.positions)
        share = 1.0 - abs(float(np.linalg.det(J))) / self._manipulability
        square = (self._damping * max(share, 0.0)) ** 2 + 1e-12
        return np.asarray(J.T @ np.linalg.solve(J @ J.T + square * np.eye(6), np.array(asked)))


class HaltingTwist(_Clamped):
    """MoveIt Servo's rule: the speed falls between two condition numbers of J, to a halt.

    A hand that moves away from the singularity is halted at twice the distance between them.

    Parameters
    ----------
    geometry, period
        See `OnDirection`.
    slow, halt : float
        See `ServoHaltSettings`.

    References
    ----------
    MoveIt Servo's parameters ``lower_singularity_threshold``, ``hard_stop_singularity_threshold``
    and ``leaving_singularity_threshold_multiplier``, whose defaults these are.
    """

    def __init__(self, geometry: ArmGeometry, period: float, slow: float, halt: float) -> None:
        super().__init__(geometry, period)
        self._slow, self._halt = slow, halt

    def wanted(self, asked: Six) -> Array:
        """Return the plain inverse times the twist, slowed down."""
        q = self.positions
        J = self.jacobian(q)
        u, singular, vt = np.linalg.svd(J)
        least = max(float(singular[-1]), 1e-9)
        rates = vt.T @ ((u.T @ np.array(asked)) / np.maximum(singular, 1e-9))
        condition = float(singular[0]) / least
        share = self._share(condition, rates)
        return np.asarray(share * rates)

    def _share(self, condition: float, rates: Array) -> float:
        if condition <= self._slow:
            return 1.0
        size = float(np.abs(rates).max())
        ahead = np.array(self.positions) + rates * (_AHEAD / max(size, 1e-9))
        values = np.linalg.svd(self.jacobian(tuple(ahead.tolist())), compute_uv=False)
        leaving = float(values[0] / max(float(values[-1]), 1e-9)) < condition
        width = (self._halt - self._slow) * (_LEAVING if leaving else 1.0)
        return min(max(1.0 - (condition - self._slow) / width, 0.0), 1.0)


def turned_into_base(rotation: tuple[tuple[float, ...], ...], twist: Six) -> Six:
    """Return a twist that is given in the tool's axes in the base's."""
    v, w = twist[:3], twist[3:]
    first, second = (
        [math.fsum(a * b for a, b in zip(row, part, strict=True)) for row in rotation]
        for part in (v, w)
    )
    return (first[0], first[1], first[2], second[0], second[1], second[2])
