"""Where feet come down if the servos yield to the robot's weight: a step off is a walk off."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.gait.leg_postures import leg_posture, rotations
from controllers.gait.plan import GaitPlan
from controllers.gait.sag import standing_torques
from controllers.gait.soles import gap_between, heights_of, sole_corners

Array = NDArray[np.float64]

_ONE_GROUND = 2e-3
"""Ground that is higher by less does not tip a foot over, m: soles land as hard as that."""


class Landing(NamedTuple):
    """A foot that comes down.

    Parameters
    ----------
    phase : str
        In which it swings.
    off : float
        How far from its print it comes down as the servos yield, along the ground, m. It adds up:
        the next step begins there.
    room : float
        From its print to the nearest one that is higher, seen from above, m; infinite: none is.
    higher : float
        By how much that one is higher, m.
    """

    phase: str
    off: float
    room: float
    higher: float


def landings(plan: GaitPlan, stiffness: float) -> tuple[Landing, ...]:
    """Return every foot that comes down, in their order.

    Parameters
    ----------
    plan : GaitPlan
        Of the walk.
    stiffness : float
        Of the servos' position loops, N m/rad, whose yielding nothing compensates.
    """
    swings = [p for p in plan.phases if p.phase.standing in ((True, False), (False, True))]
    yielded = plan.q - standing_torques(plan) / stiffness
    legs = [leg_posture(plan.geometry, leg, yielded) for leg in (0, 1)]
    feet = [plan.feet[0, leg] for leg in (0, 1)]
    turned = [rotations(plan.attitudes[:1, leg])[0] for leg in (0, 1)]
    prints = [_Print(plan, 0, leg) for leg in (0, 1)]
    prints += [_Print(plan, p.last, 0 if p.phase.standing[1] else 1) for p in swings]
    found = []
    for number, planned in enumerate(swings, 2):
        at, lands = planned.last, prints[number].leg
        stands = 1 - lands
        support, swinging = legs[stands], legs[lands]
        here = turned[stands] @ support.foot[at].T
        foot = feet[stands] + here @ (swinging.sole[at] - support.sole[at])
        along = here @ swinging.foot[at]
        # The ground takes it as it lies there: only its place and its heading are off.
        attitude = plan.attitudes[at, lands].copy()
        attitude[2] = np.arctan2(along[1, 0], along[0, 0])
        turned[lands] = rotations(attitude[None])[0]
        feet[lands] = np.array((foot[0], foot[1], plan.feet[at, lands, 2]))
        off = float(np.hypot(*(feet[lands] - plan.feet[at, lands])[:2]))
        room, higher = min(prints[number].room_to(other) for other in prints)
        found.append(Landing(planned.phase.name, off, room, higher))
    return tuple(found)


class _Print:
    """A footprint, as a plan has it at a sample."""

    def __init__(self, plan: GaitPlan, sample: int, leg: int) -> None:
        self.leg = leg
        self._at = tuple(plan.feet[sample, leg].tolist())
        roll, pitch, yaw = plan.attitudes[sample, leg].tolist()
        self._lies = (roll, pitch, yaw)
        self._sole = sole_corners(plan.geometry, self._at, self._lies)

    def room_to(self, other: "_Print") -> tuple[float, float]:
        """Return how far another print is away if it is higher (else infinity), and by how much."""
        apart = [
            theirs - mine
            for mine, theirs in zip(
                heights_of(self._at, self._lies, other._sole),
                heights_of(other._at, other._lies, other._sole),
                strict=True,
            )
        ]
        if max(apart) <= _ONE_GROUND:
            return np.inf, 0.0
        return max(gap_between(self._sole, other._sole), 0.0), max(apart)
