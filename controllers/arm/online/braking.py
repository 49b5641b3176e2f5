"""How fast joints may go whose hand has to be at rest soon after nobody asks for anything."""

import math
from dataclasses import replace

from controllers.arm.geometry import ArmGeometry
from controllers.arm.online.commands import ArmTwists
from controllers.motion import InfeasibleMotion

_EDGE = 1e-9
"""Of a period: sums of periods are rounded."""


def periods_to_rest(twists: ArmTwists, period: float) -> int:
    """Return how many periods `ArmTwists.rest` leaves to brake.

    Up to one passes before a word is read, and then `ArmTwists.silence` before anybody brakes.

    Raises
    ------
    InfeasibleMotion
        None is left.
    """
    waited = 1 + math.ceil(twists.silence / period - _EDGE)
    left = math.floor(twists.rest / period + _EDGE) - waited
    if left < 1:
        raise InfeasibleMotion(
            f"the hand has to be at rest {1e3 * twists.rest:g} ms after the last word "
            f"(reference.rest), and is waited for {1e3 * twists.silence:g} ms (reference.silence) "
            f"and a cycle of {1e3 * period:g} ms: no time is left to brake. A rest of "
            f"{1e3 * (waited + 1) * period:g} ms or more, or less silence, would do."
        )
    return left


def slowed_to_rest(geometry: ArmGeometry, periods: int | None, period: float) -> ArmGeometry:
    """Return the arm with the rates that its joints can brake from in so many periods.

    Parameters
    ----------
    geometry : ArmGeometry
        The arm.
    periods : int or None
        None: as long as it takes.
    period : float
        s.
    """
    if periods is None:
        return geometry
    limits = zip(geometry.rate_limits, geometry.acceleration_limits, strict=True)
    q1, q2, q3, q4, q5, q6 = (min(rate, hardest * periods * period) for rate, hardest in limits)
    return replace(geometry, rate_limits=(q1, q2, q3, q4, q5, q6))
