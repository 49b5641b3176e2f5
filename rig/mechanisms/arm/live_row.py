"""The plan's columns of a cycle that nobody has planned: what the law has just commanded."""

from controllers.arm.kinematics import Dimensions, link_points, singularity_indices
from controllers.arm.on_direction.numbers import Six
from controllers.arm.online.rehearsal import share_of, twist_within
from controllers.arm.plan import inside_boundary
from controllers.arm.types import ArmCommand


def commanded_row(
    arm: Dimensions, command: ArmCommand, asked: Six, period: float
) -> tuple[float, ...]:
    """Return hand, elbow, wrist, twist, what is asked for, indices, b twice, inside, place."""
    q = command.positions
    _, _, elbow, wrist, hand = link_points(arm, q)
    done = twist_within(arm, q, command.velocities, period)
    b = share_of(asked, done)
    indices = singularity_indices(arm, q)
    return (*hand, *elbow, *wrist, *done, *asked, *indices, b, b, inside_boundary(arm, q), *hand)
