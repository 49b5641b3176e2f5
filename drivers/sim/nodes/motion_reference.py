"""Where a drive wants its motor to be: interpolated setpoints, velocities, ramps to standstill."""

from math import copysign, inf


class MotionReference:
    """The reference of a drive's servo loop as a function of time, in the drive's own unit.

    Attributes
    ----------
    position, velocity : float
        At the time of the last call, in units and units/s.
    """

    def __init__(self) -> None:
        self.position = 0.0
        self.velocity = 0.0
        self._time = 0.0
        self._end = inf
        self._target = 0.0
        self._deceleration = 0.0
        self._cruise = 0.0  # of the last setpoints, which end exactly when the next ones come

    @property
    def is_moving(self) -> bool:
        """Whether the reference will be elsewhere a moment later."""
        return self.velocity != 0.0

    def restart(self, position: float, now: float) -> None:
        """Stand still at a position."""
        self.position, self.velocity = position, 0.0
        self._time = now
        self._end = inf
        self._deceleration = self._cruise = 0.0

    def interpolate(self, target: float, duration: float, now: float) -> None:
        """Go to a target on a straight line that takes `duration` (s)."""
        self.advance(now)
        self._deceleration = 0.0
        self._target = target
        self._end = now + duration
        self.velocity = self._cruise = (target - self.position) / duration

    def run(self, velocity: float, now: float) -> None:
        """Move at a velocity until told otherwise."""
        self.advance(now)
        self._deceleration = 0.0
        self._end = inf
        self.velocity = self._cruise = velocity

    def slow_down(self, deceleration: float, now: float) -> None:
        """Come to a standstill along a ramp, units/s²."""
        self.advance(now)
        self.velocity = self._cruise
        self._end = inf
        self._deceleration = deceleration
        if deceleration <= 0.0:
            self.velocity = 0.0

    def advance(self, now: float) -> None:
        """Bring position and velocity to time `now`, s."""
        elapsed = now - self._time
        if elapsed <= 0.0:
            return
        self._time = now
        if self._deceleration > 0.0:
            self._advance_ramp(elapsed)
        elif now >= self._end:
            self.position, self.velocity = self._target, 0.0
            if now > self._end + 1e-3:  # the next setpoint did not come: it stands
                self._cruise = 0.0
        else:
            self.position += self.velocity * elapsed

    def _advance_ramp(self, elapsed: float) -> None:
        speed = abs(self.velocity)
        lasting = min(elapsed, speed / self._deceleration)
        after = speed - self._deceleration * lasting
        self.position += copysign(0.5 * (speed + after) * lasting, self.velocity)
        stopped = lasting < elapsed or after <= 0.0
        self.velocity = 0.0 if stopped else copysign(after, self.velocity)
        self._cruise = self.velocity
