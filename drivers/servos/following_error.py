"""Whether a joint follows its reference, watched by the rig itself."""


class FollowingWatch:
    """Tell a joint that lags a little from one that is blocked or runs away.

    Parameters
    ----------
    window : float
        Permitted distance between reference and position, rad.
    time : float
        For how long it may be exceeded, s. It is also the time in which the reference of a
        joint that follows velocities forgets its distance: such a joint may drift.

    Attributes
    ----------
    reference : float
        Where the joint should be, rad.
    error : float
        By how much it is not, rad.
    """

    __slots__ = ("_good_at", "error", "reference", "time", "window")

    def __init__(self, window: float, time: float) -> None:
        self.window = window
        self.time = time
        self.reference = 0.0
        self.error = 0.0
        self._good_at = 0.0

    def reset(self, position: float, now: float) -> None:
        """Start from a measured position, rad."""
        self.reference = position
        self.error = 0.0
        self._good_at = now

    def drift(self, velocity: float, position: float, period: float) -> None:
        """Move the reference on by a velocity (rad/s) for a period (s), and towards a position."""
        share = period / (self.time + period)
        self.reference += velocity * period
        self.reference += (position - self.reference) * share

    def exceeds(self, position: float, now: float) -> float:
        """Return for how long the window has been exceeded too long, s; 0 while all is well."""
        self.error = self.reference - position
        if -self.window <= self.error <= self.window:
            self._good_at = now
            return 0.0
        duration = now - self._good_at
        return duration if duration > self.time else 0.0
