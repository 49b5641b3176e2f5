"""What the drives need along a path: whether they can hold the arm there, and along a plan."""

import math

import numpy as np
from numpy.typing import NDArray

from controllers.arm.axis_path import AxisPath
from controllers.arm.dynamics.chain import ArmTorques
from controllers.arm.dynamics.limits import PathTorques, TooHeavy, halfway, heaviest
from controllers.arm.dynamics.settings import Payload
from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.plan import ArmPlan
from controllers.motion import InfeasibleMotion

Array = NDArray[np.float64]


def torques_for(geometry: ArmGeometry, payload: Payload) -> ArmTorques:
    """Return the torques of an arm with a payload.

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
    return ArmTorques(geometry, geometry.dynamics, payload)


def check_held(
    geometry: ArmGeometry, payload: Payload, path: AxisPath, s: Array, speed: float
) -> None:
    """Raise if the drives could not hold the arm with its payload anywhere on a path.

    Parameters
    ----------
    geometry, payload
        The arm and its load.
    path : AxisPath
        The joints.
    s : ndarray, shape (n,)
        Places to look at, rad.
    speed : float
        Nominal, of the hand, m/s.

    Raises
    ------
    InfeasibleMotion
        With place, joint, torque, limit, and the payload that would be held.
    """
    torques = torques_for(geometry, payload)
    along = PathTorques(torques, path, s)
    try:
        along.check_held()
    except TooHeavy as error:
        gone = speed * float(path.way(s[error.at : error.at + 1])[0, 0])
        light = PathTorques(torques_for(geometry, Payload()), path, s)
        most = heaviest(light, along, payload.mass) if payload.mass else -math.inf
        held = (
            f"{math.floor(1e3 * most) / 1e3:g} kg would be held"
            if most > 1e-3
            else "no payload would be held"
        )
        raise InfeasibleMotion(
            f"after {gone:.4f} m of the path {AXIS_NAMES[error.joint]} would need "
            f"{error.torque:.4g} N m to hold the arm and its payload of {payload.mass:g} kg, "
            f"beyond 98 % of its limit of {torques.limits[error.joint]:g} N m; the rest has to "
            f"move it: {held}."
        ) from error


def torques_of_plan(torques: ArmTorques, plan: ArmPlan) -> Array:
    """Return the torques halfway between the samples of a plan, N m, shape (n - 2, 6)."""
    return torques.of(*halfway(plan.positions[:-1], plan.velocities[:-1], plan.period))
