"""Friction on the ball, fed forward: one vector for the ring, one force per pair for its wires.

The ring slides in one seat: its friction points against its velocity, ``K v / |v|``, and is
shared by the pairs. A friction per channel would be too much by up to sqrt(2) and jump where one
pair turns round while the ring moves on.
"""

import math

Pair = tuple[float, float]
"""One value per pair, (1, 3) and (4, 2)."""


class BallFriction:
    """Forces that the desired motion takes on the ball, with pre-sliding.

    Between the surfaces stands a spring that yields (Dahl), for the ring with two dimensions that
    share one limit. Driven by the desired velocities, it says which force the contact will show.

    Parameters
    ----------
    ring : float
        Friction of the ring at the wires' radius over the sum of the four tensions.
    wire : float
        Friction of a pair's wires over the sum of its two tensions.
    distance : float
        Motion of a wire over which friction turns round, m.
    period : float
        The loop's period, s.

    References
    ----------
    P. R. Dahl, "A solid friction model", Aerospace Corp. TOR-158(3107-18), 1968.
    """

    def __init__(self, ring: float, wire: float, distance: float, period: float) -> None:
        self._ring = ring
        self._wire = wire
        self._step = period / distance
        self._seat: Pair = (0.0, 0.0)
        self._wires: Pair = (0.0, 0.0)

    def reset(self) -> None:
        """Forget the past: no deflection."""
        self._seat = self._wires = (0.0, 0.0)

    def update(self, velocity: Pair, tension: Pair) -> Pair:
        """Step by one period and return the force for each pair, N.

        Parameters
        ----------
        velocity : tuple of float
            Desired, of each pair, m/s.
        tension : tuple of float
            Sum of each pair's two tensions, N.
        """
        first, second = self._step * velocity[0], self._step * velocity[1]
        # Implicit, so that any velocity is stable and no share exceeds 1.
        keep = 1.0 / (1.0 + math.hypot(first, second))
        seat = ((self._seat[0] + first) * keep, (self._seat[1] + second) * keep)
        wires = (
            (self._wires[0] + first) / (1.0 + abs(first)),
            (self._wires[1] + second) / (1.0 + abs(second)),
        )
        self._seat, self._wires = seat, wires
        ring, wire = self._ring * (tension[0] + tension[1]), self._wire
        return (
            ring * seat[0] + wire * tension[0] * wires[0],
            ring * seat[1] + wire * tension[1] * wires[1],
        )
