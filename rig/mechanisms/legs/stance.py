"""Whether the legs stand as their encoders say, before anything moves."""

import numpy as np

from controllers.gait.geometry import AXIS_NAMES, LegGeometry
from controllers.gait.leg_postures import leg_posture
from rig.hal import SafetyError, Vector


def check_stance(geometry: LegGeometry, positions: Vector, begins: Vector, bound: float) -> None:
    """Raise if the soles of legs that stand would not both lie on the ground.

    An encoder that is off cannot be seen while its joint rests, and a walk that begins with it
    falls. Of legs that stand it shows: their soles are flat on one ground, however that slopes.

    Parameters
    ----------
    geometry : LegGeometry
        Dimensions.
    positions, begins : tuple of float
        The twelve joints as they are and where the walk begins, rad.
    bound : float
        Greatest angle between the soles, rad.

    Raises
    ------
    SafetyError
        With the angle, and the joint that is farthest from where the walk begins.
    """
    q = np.array([positions])
    right, left = (leg_posture(geometry, leg, q).foot[0, :, 2] for leg in (0, 1))
    tilt = float(np.arctan2(np.linalg.norm(np.cross(right, left)), right @ left))
    if tilt <= bound:
        return
    off = np.subtract(positions, begins)
    farthest = int(np.argmax(np.abs(off)))
    raise SafetyError(
        f"by the encoders the soles are {np.degrees(tilt):.3g} deg apart, at most "
        f"{np.degrees(bound):.3g} deg on a floor (legs.start_tilt): {AXIS_NAMES[farthest]} is "
        f"farthest from where the walk begins, by {np.degrees(off[farthest]):.3g} deg. Its encoder "
        f"is off, or the legs do not stand: put both soles flat on the floor, or let start_tilt be "
        f"null if they hang"
    )
