"""A plan held against what its law promises, before anything moves."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.arm.dynamics.carried import check_held, torques_for, torques_of_plan
from controllers.arm.dynamics.limits import shares_between
from controllers.arm.dynamics.settings import Payload
from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.plan import ArmPlan
from controllers.motion import InfeasibleMotion

Array = NDArray[np.float64]

ALL_JOINTS = tuple(range(len(AXIS_NAMES)))

_SHARE = 1e-3
"""By which a limit may be passed, relative: the drives do not resolve it."""
_OFF_PATH = 1e-6
"""How far the hand may be off its path, m."""
_ORDER = 4
"""Of the integration: with it the hand gets nearer to its path as the period covers less of it."""
_NEVER = 1e12
"""How much more slowly an arm has to move that its drives cannot hold."""
_ROOM = 1.1
"""So much more slowly than that order says a motion is tried."""


class Promises(NamedTuple):
    """The promises of a law about each of its plans.

    Parameters
    ----------
    rates, accelerations : tuple of int
        Joints that keep their limits, counted from 0.
    path : bool
        Whether the hand stays on its path.
    carried : Payload, optional
        With it in the hand no drive needs more than its torque; None: torques are not promised.
    """

    rates: tuple[int, ...] = ()
    accelerations: tuple[int, ...] = ()
    path: bool = False
    carried: Payload | None = None


class TooFast(InfeasibleMotion):
    """A plan goes beyond a limit that its law keeps, or its hand off its path.

    Attributes
    ----------
    factor : float
        So many times as long the motion has to take, at least.
    is_guess : bool
        Whether it is no more than worth a try.
    """

    def __init__(self, message: str, factor: float, *, is_guess: bool = False) -> None:
        super().__init__(message)
        self.factor = factor
        self.is_guess = is_guess


def check_promises(geometry: ArmGeometry, plan: ArmPlan, promises: Promises) -> None:
    """Raise if a plan does not keep what its law promises.

    Raises
    ------
    TooFast
        With the joint or the hand's way off its path, the instant, the number and its bound,
        without a full stop.
    """
    check_rates(geometry, plan.t, plan.rates, promises)
    limits = geometry.acceleration_limits
    _check(plan.t, promises.accelerations, plan.accelerations, limits, "rad/s^2", 0.5)
    if promises.carried is not None:
        _check_torques(geometry, promises.carried, plan)
    if promises.path and plan.path_deviation > _OFF_PATH:
        k = int(np.argmax(plan.deviation))
        raise TooFast(
            f"after {plan.t[k]:.3f} s the hand would be {1e3 * plan.deviation[k]:.4g} mm off its "
            f"path, more than {1e3 * _OFF_PATH:g} mm, as a period is too long beside a singularity",
            _ROOM * (plan.path_deviation / _OFF_PATH) ** (1.0 / _ORDER),
            is_guess=True,
        )


def _check_torques(geometry: ArmGeometry, carried: Payload, plan: ArmPlan) -> None:
    """Raise if a drive needs more than its torque.

    What holds the arm does not become less by time: the rest has to fit into what is left, and
    where nothing is left no speed is slow enough.
    """
    torques = torques_for(geometry, carried)
    limits = tuple(torques.limits.tolist())
    try:
        _check(plan.t, ALL_JOINTS, torques_of_plan(torques, plan), limits, "N m", 0.5)
    except TooFast as error:
        used = shares_between(torques, plan.positions[:-1], plan.velocities[:-1], plan.period)
        if used.min() < 0.0:
            steps = np.linalg.norm(np.diff(plan.hand, axis=0), axis=1)
            gone = np.concatenate(([0.0], np.cumsum(steps)))
            check_held(
                torques, torques_for(geometry, Payload()), plan.positions, plan.velocities,
                lambda k: float(gone[k]),
            )  # fmt: skip
        factor = math.sqrt(float(used.max())) if used.min() >= 0.0 else _NEVER
        raise TooFast(str(error), factor) from error


def check_rates(geometry: ArmGeometry, t: Array, rates: Array, promises: Promises) -> None:
    """Raise if rates, rad/s, shape (n, 6), at instants, s, shape (n,), pass a promised limit.

    Raises
    ------
    TooFast
        As `check_promises`.
    """
    _check(t, promises.rates, rates, geometry.rate_limits, "rad/s", 1.0)


def _check(
    t: Array,
    joints: tuple[int, ...],
    values: Array,
    limits: tuple[float, ...],
    unit: str,
    power: float,
) -> None:
    """Raise if a joint passes a limit; time that passes `k` times slower divides by k^(1/power)."""
    if not joints or not len(values):
        return
    shares = np.abs(values[:, joints]) / np.array(limits)[list(joints)]
    k, place = np.unravel_index(int(np.argmax(shares)), shares.shape)
    worst = float(shares[k, place])
    if worst <= 1.0 + _SHARE:
        return
    joint = joints[int(place)]
    raise TooFast(
        f"after {t[k]:.3f} s {AXIS_NAMES[joint]} would need {abs(values[k, joint]):.4g} "
        f"{unit}, beyond its limit of {limits[joint]:g} {unit}",
        worst**power,
    )
