"""One step of the law for poses that come one at a time, as from an operator's hand."""

from collections.abc import Callable

from controllers.arm.decomposition import joint_rates
from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of, forward
from controllers.arm.region import elbow_scale
from controllers.arm.types import Joints, Pose, Rotation, Vector
from controllers.arm.vectors import rotation_error
from controllers.compiled import compile_kernel

EscStep = Callable[[Joints, Vector, Rotation, Vector, Vector], Joints]
"""``(q, position, rotation, linear, angular) -> rates``: the joints that are commanded now (rad),
the pose and twist that are wanted, and the six joint rates (rad/s) that go there."""


def make_step(
    geometry: ArmGeometry, sin_qs: float, side: float = 1.0, feedback: float = 10.0
) -> EscStep:
    """Return the compiled step; compiling takes seconds unless the cache has it.

    The rates go along the wanted twist and back to the wanted pose; they are scaled by the
    region around the elbow's singularity, and as a whole so that no joint exceeds its limit.

    Parameters
    ----------
    geometry : ArmGeometry
        Dimensions and rate limits.
    sin_qs : float
        Half width of the region; see `controllers.arm.region`.
    side : float
        Sign of S3 when the motion started.
    feedback : float
        Velocity over the pose error, 1/s.

    References
    ----------
    Miyata et al., eq. (1)-(6), (11).
    """
    arm = dimensions_of(geometry)
    g1, g2, g3, g4, g5, g6 = (1.0 / limit for limit in geometry.rate_limits)

    def build(digest: int) -> EscStep:
        def step(
            q: Joints, position: Vector, rotation: Rotation, linear: Vector, angular: Vector
        ) -> Joints:
            _ = digest
            actual: Pose = forward(arm, q)
            turn = rotation_error(rotation, actual.rotation)
            there = actual.position
            v = (
                linear[0] + feedback * (position[0] - there[0]),
                linear[1] + feedback * (position[1] - there[1]),
                linear[2] + feedback * (position[2] - there[2]),
            )
            w = (
                angular[0] + feedback * turn[0],
                angular[1] + feedback * turn[1],
                angular[2] + feedback * turn[2],
            )
            scale = elbow_scale(q[2] + arm.elbow_angle, sin_qs, side)
            r1, r2, r3, r4, r5, r6 = joint_rates(arm, q, v, w, scale)
            worst = max(
                abs(r1) * g1, abs(r2) * g2, abs(r3) * g3, abs(r4) * g4, abs(r5) * g5, abs(r6) * g6
            )
            share = 1.0 if worst <= 1.0 else 1.0 / worst
            return share * r1, share * r2, share * r3, share * r4, share * r5, share * r6

        return step

    return compile_kernel(build)
