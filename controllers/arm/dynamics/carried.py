"""What the drives need along a path: whether they can hold the arm there, and along a plan."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from controllers.arm.dynamics.chain import ArmTorques
from controllers.arm.dynamics.limits import HELD, TooHeavy, halfway, heaviest, holding_along
from controllers.arm.dynamics.settings import Payload
from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.plan import ArmPlan
from controllers.motion import InfeasibleMotion

Array = NDArray[np.float64]


def torques_for(geometry: ArmGeometry, payload: Payload, share: float = 1.0) -> ArmTorques:
    """Return the torques of an arm with a payload, whose limits are a share of its drives'.

    Raises
    ------
    InfeasibleMotion
        Nothing is known of its masses.
    """
    if geometry.dynamics is None:
        raise InfeasibleMotion(
            "the path is to be timed under the drives' torques, and the profile does not say them: "
            "give geometry.dynamics."
        )
    torques = ArmTorques(geometry, geometry.dynamics, payload)
    torques.limits = share * torques.limits
    return torques


def check_held(
    torques: ArmTorques,
    light: ArmTorques,
    q: Array,
    tangent: Array,
    gone: Callable[[int], float],
) -> None:
    """Raise if the drives could not hold the arm with its payload anywhere on its way.

    Parameters
    ----------
    torques, light : ArmTorques
        Of the arm with its load, and without.
    q, tangent : ndarray, shape (n, 6)
        The joints at places to look at, rad, and which way they go.
    gone : callable
        Returns how far the hand is on its way at one of the places, m.

    Raises
    ------
    InfeasibleMotion
        With place, joint, torque, limit, and the payload that would be held.
    """
    loaded = holding_along(torques, q, tangent)
    try:
        loaded.check()
    except TooHeavy as error:
        most = heaviest(holding_along(light, q, tangent), loaded, torques.carried)
        most = math.floor(1e3 * most) / 1e3
        would = f"{most:g} kg would be held" if most > 0.0 else "not even an empty hand is held"
        raise InfeasibleMotion(
            f"after {gone(error.at):.4f} m of the path {AXIS_NAMES[error.joint]} would need "
            f"{error.torque:.4g} N m to hold the arm and its payload of {torques.carried:g} kg, "
            f"beyond {100.0 * HELD:g} % of the {torques.limits[error.joint]:.6g} N m that it may "
            f"have; the rest has to move it: {would}."
        ) from error


def torques_of_plan(torques: ArmTorques, plan: ArmPlan) -> Array:
    """Return the torques halfway between the samples of a plan, N m, shape (n - 2, 6)."""
    return torques.of(*halfway(plan.positions[:-1], plan.velocities[:-1], plan.period))
