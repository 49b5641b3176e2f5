"""What a chamber's pressure should be for its setpoints, and how far and how alike it is off."""

import math
from typing import Final

from rig.mechanisms.pneumatic.alarms.bounds import PressureBounds

LEAST_LAG = 2.0
"""A slow regulator would be off by so many times the hysteresis, rms, or the motion cannot show
that it is slow."""
_LIKE_SLOW = 0.6
"""Share of a deviation's power that is in step with a slow regulator's: else it is not slow."""
_LINEAR: Final = 2.0
"""Times the hysteresis that a regulator may be off by its linearity: 1 % of its range …"""
_BENT: Final = 4e-2
"""… and Pa/Pa by which that changes at most from one pressure to another, of a parabola."""


class ChannelAnswers:
    """A healthy regulator's pressure for the setpoints that were sent, and when it was met.

    Of two: one answers after the dead time, the other, prompt, at once; what is between them is
    well. Beside them a regulator with half of the bandwidth, how alike the deviations are, and one
    with twice the bandwidth, which goes where none of the others does.
    """

    __slots__ = (
        "expected", "held", "jump", "lag_mean", "lag_power", "likeness", "mean", "near_at", "off",
        "power", "prompt", "prompt_rate", "quick", "quick_at", "quick_rate", "rate", "rested",
        "slow", "slow_rate", "unknown", "usual", "well_at",
    )  # fmt: skip

    def __init__(self, pressure: float, now: float) -> None:
        self.expected = self.prompt = self.slow = self.quick = self.held = self.rested = pressure
        self.rate = self.prompt_rate = self.slow_rate = self.quick_rate = 0.0
        self.off = self.mean = self.usual = self.unknown = self.jump = 0.0
        self.lag_mean = self.lag_power = self.likeness = self.power = 0.0
        self.well_at = self.quick_at = self.near_at = now

    def answer(self, acting: float, latest: float, step: float, pull: float, drag: float) -> None:
        """Let the healthy, the slow and the quick regulators go on by a step, s.

        Parameters
        ----------
        acting, latest : float
            The setpoint of a dead time ago, and the one of now, Pa.
        pull, drag : float
            Of the healthy ones, times the step: stiffness (1/s) and damping (1).
        """
        brake = 1.0 / (1.0 + drag)
        self.rate = (self.rate + pull * (acting - self.expected)) * brake
        self.expected += step * self.rate
        self.prompt_rate = (self.prompt_rate + pull * (latest - self.prompt)) * brake
        self.prompt += step * self.prompt_rate
        brake = 1.0 / (1.0 + 0.5 * drag)
        self.slow_rate = (self.slow_rate + 0.25 * pull * (acting - self.slow)) * brake
        self.slow += step * self.slow_rate
        brake = 1.0 / (1.0 + 2.0 * drag)
        self.quick_rate = (self.quick_rate + 4.0 * pull * (acting - self.quick)) * brake
        self.quick += step * self.quick_rate

    def take(self, pressure: float) -> None:
        """Note how far a pressure is off the healthy ones, Pa: 0 between them."""
        late, prompt = self.expected, self.prompt
        self.off = max(pressure - max(late, prompt), 0.0) + min(pressure - min(late, prompt), 0.0)

    def learn(
        self, pressure: float, lag: float, usual: float, share: float, bounds: PressureBounds
    ) -> None:
        """Learn what is usual at rest, Pa, and how far it may be off that at higher pressures yet.

        Parameters
        ----------
        pressure : float
            Of this cycle, Pa.
        lag : float
            By which a slow one is behind a healthy one, Pa: a ramp tells nothing.
        usual : float
            Share of this cycle in what is usual.
        share : float
            Share of this cycle in what a slow one is compared by, which remembers as long.
        """
        if abs(lag) < bounds.loop:
            self.usual += usual * (self.off - self.usual)
            self.rested = max(self.rested, pressure)
        unknown = min(_BENT * (pressure - self.rested), _LINEAR * bounds.loop)
        self.unknown = max(unknown, self.unknown * (1.0 - share))

    def strays(self, pressure: float, setpoint: float, most: float) -> bool:
        """Return whether a pressure is more than `most`, Pa, beside all that a late answer passes.

        Every answer is on its way from where it was to the setpoint: the slow one is the last, and
        the quick one the farthest after a setpoint that was there for a moment only.
        """
        late, prompt, slow, quick = self.expected, self.prompt, self.slow, self.quick
        pressure -= self.usual
        if -most <= pressure - late <= most:  # most of the time, and cheap
            return False
        way = (late, prompt, slow, quick, setpoint)
        return not min(way) - most <= pressure <= max(way) + most

    def compare(self, lag: float, share: float, bounds: PressureBounds) -> bool:
        """Return whether this one is slow: compared over time with a slow one's deviation, Pa."""
        off = self.off - self.usual
        self.lag_power = power = self.lag_power + share * (lag * lag - self.lag_power)
        self.likeness = likeness = self.likeness + share * (lag * off - self.likeness)
        self.power += share * (off * off - self.power)
        # The cheap half first: most of the time a regulator is far from slow.
        return likeness > bounds.slow * power and self.slowness(bounds) > self.most_slow(bounds)

    def slowness(self, bounds: PressureBounds) -> float:
        """Return which share of a slow regulator's deviation this has; 0: the motion shows none."""
        least = LEAST_LAG * bounds.loop
        return self.likeness / self.lag_power if self.lag_power > least * least else 0.0

    def may_be_slow(self, bounds: PressureBounds) -> bool:
        """Return whether this one is off to where a slow one would be while its setpoint moves."""
        return self.lag_mean > bounds.loop and self.likeness > 0.0

    def most_slow(self, bounds: PressureBounds) -> float:
        """Return the permitted share: hysteresis hides the more, the less there is to see.

        And at pressures at which it has not rested since its chamber was filled, its linearity.
        """
        power, hidden = self.lag_power, bounds.loop + self.unknown
        return bounds.slow + hidden / math.sqrt(power) if power > 0.0 else math.inf

    def most_mean(self, bounds: PressureBounds) -> float:
        """Return how far the mean may be off what is usual, Pa."""
        return bounds.offset + bounds.slow * self.lag_mean

    def strangeness(self, bounds: PressureBounds) -> float:
        """Return mean or slowness over what is permitted of it, whichever is more."""
        return max(
            abs(self.mean - self.usual) / self.most_mean(bounds),
            self.slowness(bounds) / self.most_slow(bounds),
        )

    def is_slow(self, bounds: PressureBounds) -> bool:
        """Return whether the deviation is that of a slow regulator in size and in shape."""
        return self.slowness(bounds) > self.most_slow(bounds) and (
            self.likeness > math.sqrt(_LIKE_SLOW * self.lag_power * self.power)
        )
