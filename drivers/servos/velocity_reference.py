"""Positions for drives that follow velocities."""

from collections.abc import Sequence

from rig.hal import Vector


class VelocityReference:
    """Tells velocity drives positions: those commanded, and the one where a joint shall stand.

    A drive that holds a velocity of zero lets its joint creep.

    Parameters
    ----------
    gain : float
        Velocity for an error in position, 1/s.
    speeds : sequence of float
        The greatest of each joint, rad/s.
    period : float
        Of the cycle, s.
    """

    def __init__(self, gain: float, speeds: Sequence[float], period: float) -> None:
        self._gain = gain
        self._speeds = tuple(speeds)
        self._period = period
        self._due: Vector | None = None
        self._held: list[float | None] = [None] * len(self._speeds)

    def reset(self) -> None:
        """Hold no joint any more, and begin anew."""
        self._due = None
        self._held = [None] * len(self._speeds)

    def follow(self, positions: Vector, before: Vector, measured: Vector) -> list[float]:
        """Return velocities for positions: their own, and the error times the gain.

        A joint is at a setpoint one period after it was sent, and was measured one period ago:
        it is compared with the last setpoint but one.

        Parameters
        ----------
        positions, before : tuple of float
            The setpoints of this cycle and of the one before, rad.
        measured : tuple of float
            Where the joints are, rad.
        """
        due = self._due or before
        self.reset()
        self._due = before
        return [
            self._limited(k, (position - before[k]) / self._period, due[k] - measured[k])
            for k, position in enumerate(positions)
        ]

    def turn(self, velocities: Vector, measured: Vector) -> list[float]:
        """Return velocities for velocities; a joint that shall stand is held where it is.

        Parameters
        ----------
        velocities : tuple of float
            The setpoints of this cycle, rad/s.
        measured : tuple of float
            Where the joints are, rad.
        """
        self._due = None
        turned = []
        for k, velocity in enumerate(velocities):
            if velocity:
                self._held[k] = None
                turned.append(velocity)
                continue
            held = self._held[k]
            if held is None:
                held = self._held[k] = measured[k]
            turned.append(self._limited(k, 0.0, held - measured[k]))
        return turned

    def _limited(self, k: int, velocity: float, error: float) -> float:
        fastest = self._speeds[k]
        return min(max(velocity + self._gain * error, -fastest), fastest)
