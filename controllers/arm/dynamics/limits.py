"""Limits of the drives' torques along a joint path, linear in acceleration and squared speed."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.arm.axis_path import AxisPath
from controllers.arm.dynamics.chain import ArmTorques
from controllers.arm.geometry import AXIS_NAMES
from controllers.motion import InfeasibleMotion
from controllers.reachable_speeds import Rows

Array = NDArray[np.float64]

_SHARE = 0.995
"""Of what is left of a limit beyond weight and dry friction that is used: it is met at the grid's
points, not between them."""
_OVER = 5e-4
"""Of a limit, by which it may be passed."""
HELD = 0.98
"""Of a limit that weight and dry friction may need: the rest moves the arm."""
_SLOW = 1e-4
"""Share of the greatest squared speed below which viscous friction is taken as it is there."""


class Holding(NamedTuple):
    """The torques that hold an arm along its way: weight, and dry friction whichever way it goes.

    Parameters
    ----------
    least, most : ndarray, shape (n, 6)
        N m.
    limits : ndarray, shape (6,)
        Of the drives, N m.
    """

    least: Array
    most: Array
    limits: Array

    def check(self) -> None:
        """Raise if the arm could not stop anywhere on its way.

        Raises
        ------
        TooHeavy
            Weight and dry friction alone need more than a joint's drive has.
        """
        shares = np.maximum(self.most, -self.least) / self.limits
        k, joint = np.unravel_index(int(np.argmax(shares)), shares.shape)
        if shares[k, joint] > HELD:
            raise TooHeavy(int(k), int(joint), float(shares[k, joint] * self.limits[joint]))


def holding_along(torques: ArmTorques, q: Array, tangent: Array) -> Holding:
    """Return what holds an arm.

    Parameters
    ----------
    torques : ArmTorques
        Of the arm with its payload.
    q, tangent : ndarray, shape (n, 6)
        Its joints along the way, and which way they go.
    """
    sense = np.sign(tangent)
    wide = np.vstack((sense[:1], sense, sense[-1:]))
    # A joint that turns back between two points rubs either way at both.
    around = np.stack((wide[:-2], sense, wide[2:]))
    weight = torques.weight(q)
    return Holding(
        weight + torques.friction * around.min(axis=0),
        weight + torques.friction * around.max(axis=0),
        torques.limits,
    )


class PathTorques:
    """The torques along a path as functions of squared speed `x` and acceleration `u` along it.

    Of each joint ``m u + b x + d sqrt(x) + c``: inertia, what the curve asks for, viscous
    friction, and weight with dry friction.

    Parameters
    ----------
    torques : ArmTorques
        Of the arm with its payload; its limits are what counts.
    path : AxisPath
        The joints.
    s : ndarray, shape (n,)
        Places along it, rad.
    """

    def __init__(self, torques: ArmTorques, path: AxisPath, s: Array) -> None:
        q, tangent, bend = (path.joints(s, order) for order in range(3))
        still = np.zeros_like(q)
        self.limits = torques.limits
        self._m = torques.inertial(q, still, tangent)
        self._b = torques.inertial(q, tangent, bend)
        self._d = torques.viscous * tangent
        self.held = holding_along(torques, q, tangent)

    def rows(self, squares: Array, strain: Array | float = 1.0) -> Rows:
        """Return the limits for speeds near to those given.

        Parameters
        ----------
        squares : ndarray, shape (n,)
            Squared speeds at which the root of viscous friction is replaced by its tangent.
        strain : ndarray, shape (n, 6)
            By how much more a motion is said to need than it does.
        """
        low, high = -self.limits - self.held.least, self.limits - self.held.most
        room = np.where(self._d > 0.0, high, -low)
        with np.errstate(divide="ignore"):
            most = (room / np.abs(self._d)) ** 2  # beyond it the friction alone takes all
        at = np.minimum(np.maximum(squares, _SLOW * squares.max())[:, None], most)
        root = np.sqrt(at)
        with np.errstate(divide="ignore", invalid="ignore"):
            rising = np.where(self._d == 0.0, 0.0, 0.5 * self._d / root)
        fixed = 0.5 * self._d * root
        need = strain / (_SHARE * self.limits)
        return Rows(
            self._m * need,
            (self._b + rising) * need,
            low / self.limits - fixed * need,
            high / self.limits - fixed * need,
        )


def shares_between(torques: ArmTorques, q: Array, rates: Array, period: float) -> Array:
    """Return what samples use of each limit beyond weight and dry friction, shape (n - 1, 6).

    It is looked at halfway from one to the next. No more than `_OVER` of the limit itself is as
    good as all that is left.

    Parameters
    ----------
    torques : ArmTorques
        Of the arm.
    q, rates : ndarray, shape (n, 6)
        Samples, rad and rad/s.
    period : float
        From one to the next, s.
    """
    at, rate, change = halfway(q, rates, period)
    moving = torques.inertial(at, rate, change) + torques.viscous * rate
    held = torques.weight(at) + torques.friction * np.sign(rate)
    room = np.where(moving > 0.0, torques.limits - held, torques.limits + held)
    shares = np.abs(moving) / room
    within = np.abs(moving) - room <= _OVER * torques.limits
    return np.asarray(np.where(within, np.minimum(shares, 1.0), shares))


def halfway(q: Array, rates: Array, period: float) -> tuple[Array, Array, Array]:
    """Return joints, rates and accelerations halfway from one sample to the next."""
    return 0.5 * (q[1:] + q[:-1]), 0.5 * (rates[1:] + rates[:-1]), np.diff(rates, axis=0) / period


class TooHeavy(InfeasibleMotion):
    """An arm that its drives cannot hold still.

    Attributes
    ----------
    at, joint : int
        Where, as a place of the grid, and which joint, from 0.
    torque : float
        What it would need, N m.
    """

    def __init__(self, at: int, joint: int, torque: float) -> None:
        super().__init__(f"{AXIS_NAMES[joint]} would need {torque:.4g} N m to be held")
        self.at, self.joint, self.torque = at, joint, torque


def heaviest(light: Holding, loaded: Holding, mass: float) -> float:
    """Return the greatest payload that is held all along, kg; 0: not even none is.

    Parameters
    ----------
    light, loaded : Holding
        Along the same way, without a payload and with one.
    mass : float
        Of that payload, kg.
    """
    if mass == 0.0:
        return 0.0
    grows = (loaded.most - light.most) / mass
    bound = HELD * light.limits
    with np.errstate(divide="ignore", invalid="ignore"):
        up = np.where(grows > 0.0, (bound - light.most) / grows, np.inf)
        down = np.where(grows < 0.0, (-bound - light.least) / grows, np.inf)
    return max(float(min(up.min(), down.min())), 0.0)
