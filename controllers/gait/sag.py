"""What position servos give way by under the robot's weight, commanded beforehand."""

from collections.abc import Iterator
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from controllers.gait.balance import GRAVITY, link_centres
from controllers.gait.correction_settings import SagSettings
from controllers.gait.geometry import LegGeometry
from controllers.gait.leg_postures import LegPosture, leg_posture
from controllers.gait.pieces import in_pieces
from controllers.gait.plan import GaitPlan, PlannedPhase

Array = NDArray[np.float64]

_LINKS: Final = 5
"""Of a leg in `link_centres`: hip, thigh, shank, ankle, foot."""
_FIRST_BEYOND: Final = (1, 1, 1, 2, 4, 4)
"""For each joint of a leg, the first of these links that it turns and whose centre is elsewhere."""


def sag_offsets(plan: GaitPlan, settings: SagSettings) -> Array:
    """Return what is to be added to each commanded angle, shape (n, 12), rad.

    A servo that is a spring holds a torque by being off its command.

    Parameters
    ----------
    plan : GaitPlan
        Of the motion.
    settings : SagSettings
        The servos' stiffness, and how the offsets begin.
    """
    brought_in = np.clip((plan.t + plan.period) / max(settings.fade, plan.period), 0.0, 1.0)
    offsets: Array = brought_in[:, None] * standing_torques(plan) / settings.stiffness
    return offsets


def standing_torques(plan: GaitPlan) -> Array:
    """Return the torques of all joints at each sample, shape (n, 12), N m.

    They are those of the robot at rest: each foot bears the share of the weight that puts the
    centre of pressure where the plan has it, and nothing pushes the feet apart.

    Parameters
    ----------
    plan : GaitPlan
        Of the motion.
    """
    shares, pressed = _bearing(plan)
    return in_pieces(partial(_torques, plan.geometry), plan.q, shares, pressed)


def _torques(geometry: LegGeometry, q: Array, shares: Array, pressed: Array) -> Array:
    """Return the joints' torques with feet that bear these shares there, N m."""
    weight = GRAVITY * geometry.masses.total
    links = link_centres(geometry, q, np.zeros((len(q), 3)))
    torques = np.zeros_like(q)
    for leg in (0, 1):
        posture = leg_posture(geometry, leg, q)
        first = 1 + _LINKS * leg
        for joint, (pivot, axis) in enumerate(_joints(q[:, 6 * leg : 6 * leg + 6], posture)):
            arm = pressed[:, leg] - pivot
            lifted = (weight * shares[:, leg])[:, None] * arm
            for link in range(first + _FIRST_BEYOND[joint], first + _LINKS):
                lifted -= GRAVITY * links.masses[link] * (links.positions[:, link] - pivot)
            # The moment of a vertical force f at (x, y) is (y f, -x f, 0); the servo holds it.
            moment = axis[:, 0] * lifted[:, 1] - axis[:, 1] * lifted[:, 0]
            torques[:, 6 * leg + joint] = -moment
    return torques


def _bearing(plan: GaitPlan) -> tuple[Array, Array]:
    """Return each foot's share of the weight, shape (n, 2), and where it is pressed, (n, 2, 3), m.

    The places are as the waist sees them.
    """
    stands = np.array([p.phase.standing for p in plan.phases], bool)[plan.phase_number]
    feet, centre = plan.feet[:, :, :2], plan.balance.zero_moment
    across = feet[:, 1] - feet[:, 0]
    left = np.einsum("ni,ni->n", centre - feet[:, 0], across) / np.sum(across**2, axis=1)
    left = np.where(
        np.all(stands, axis=1), np.clip(_handed_over(plan, left), 0.0, 1.0), stands[:, 1]
    )
    shares = np.stack((1.0 - left, left), axis=1)
    middle = np.einsum("nk,nki->ni", shares, feet)
    pressed = feet + (centre - middle)[:, None] - plan.waist[:, None, :2]
    s, c = np.sin(plan.yaw)[:, None], np.cos(plan.yaw)[:, None]
    x, y = pressed[..., 0], pressed[..., 1]
    return shares, np.stack((c * x + s * y, c * y - s * x, np.zeros_like(x)), axis=2)


def _handed_over(plan: GaitPlan, left: Array) -> Array:
    """Return the left foot's share of phases on both feet, so that no foot bears at once.

    A foot that has just come down bears nothing yet, and one that is about to leave nothing any
    more, though the centre of pressure need not be right over the other ankle then: what it is off
    by, the sole that stands makes up for, as it does while it stands alone.
    """
    shared = left.copy()
    alone = [None, *(_who_stands(planned) for planned in plan.phases), None]
    for planned, before, here, after in zip(
        plan.phases, alone[:-2], alone[1:-1], alone[2:], strict=True
    ):
        if here is not None:
            continue
        first, last = planned.first, planned.last
        during = slice(first + (first > 0), last + 1)  # the sample between two is the first one's
        xi = plan.path[during]
        if before is not None:
            shared[during] += (1.0 - xi) * (before - left[first])
        if after is not None:
            shared[during] += xi * (after - left[last])
    return shared


def _who_stands(planned: PlannedPhase) -> int | None:
    """Return the leg that stands alone in a phase; None: both stand."""
    right, left = planned.phase.standing
    return None if right == left else int(left)


def _joints(q: Array, posture: LegPosture) -> Iterator[tuple[Array, Array]]:
    """Yield where each joint of a leg is, and its axis, as the waist sees them, shapes (n, 3)."""
    s1, c1, s2, c2 = np.sin(q[:, 0]), np.cos(q[:, 0]), np.sin(q[:, 1]), np.cos(q[:, 1])
    none = np.zeros_like(s1)
    pitch = np.stack((-s1 * c2, c1 * c2, s2), axis=1)
    yield posture.hip, np.stack((none, none, none + 1.0), axis=1)
    yield posture.hip, np.stack((c1, s1, none), axis=1)
    yield posture.hip, pitch
    yield posture.knee, pitch
    yield posture.ankle, pitch
    yield posture.ankle, posture.foot[..., 0]
