"""Friction on the ball, fed forward: one vector for the ring, one force per pair for its wires.

The ring slides in one seat: its friction points against its velocity, ``K v / |v|``, and is
shared by the pairs. A friction per channel would be too much by up to sqrt(2) and jump where one
pair turns round while the ring moves on.
"""

import math

from controllers.compiled import inlined
from controllers.spherical_joint.geometry import Pair


@inlined
def slide(
    ring: float, wire: float, step: float, seat: Pair, wires: Pair, velocity: Pair, tension: Pair
) -> tuple[Pair, Pair, Pair]:
    """Return the force for each pair, N, and the deflections after a period.

    Between the surfaces stands a spring that yields (Dahl), for the ring with two dimensions that
    share one limit. Driven by the desired velocities, it says which force the contact will show.

    Parameters
    ----------
    ring, wire : float
        Friction of the ring and of a pair's wires over the sum of their tensions.
    step : float
        Period over the distance in which friction turns round, s/m.
    seat, wires : tuple of float
        Deflection of the seat and of the wires before, over what they bear.
    velocity : tuple of float
        Desired, of each pair, m/s.
    tension : tuple of float
        Sum of each pair's two tensions, N.

    References
    ----------
    P. R. Dahl, "A solid friction model", Aerospace Corp. TOR-158(3107-18), 1968.
    """
    first, second = step * velocity[0], step * velocity[1]
    # Implicit, so that any velocity is stable and no share exceeds 1.
    keep = 1.0 / (1.0 + math.hypot(first, second))
    x, y = (seat[0] + first) * keep, (seat[1] + second) * keep
    one = (wires[0] + first) / (1.0 + abs(first))
    other = (wires[1] + second) / (1.0 + abs(second))
    load = ring * (tension[0] + tension[1])
    force = (load * x + wire * tension[0] * one, load * y + wire * tension[1] * other)
    return force, (x, y), (one, other)
