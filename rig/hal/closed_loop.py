"""How far a controlled loop is from instability."""

from typing import Final, NamedTuple

SENSITIVITY: Final = 1.7
"""The greatest that is asked of gains: the loop is then at least 1/1.7 from the critical point."""
MOST_SENSITIVE: Final = 2.0
"""The greatest with which hardware runs without a reason: what wears and warms needs room."""


class ClosedLoop(NamedTuple):
    """The distance of a controlled loop from instability, as a linear model says.

    Parameters
    ----------
    stable : bool
        Without the friction that a linear model leaves out.
    crossover : float
        Greatest frequency at which the loop's gain is 1, rad/s; 0 if it never is.
    phase : float
        Phase margin, rad; negative where it is not stable.
    delay : float
        Dead time that it bears beyond what the profile says, s; 0 where it is not stable.
    sensitivity : float
        Greatest sensitivity.
    """

    stable: bool
    crossover: float
    phase: float
    delay: float
    sensitivity: float

    @property
    def is_robust(self) -> bool:
        """Whether it is as far from instability as process control asks for.

        References
        ----------
        K. J. Åström, T. Hägglund, "Advanced PID control", ISA, 2006, section 4.5: sensitivities
        between 1.2 and 2.
        """
        return self.stable and self.sensitivity <= MOST_SENSITIVE
