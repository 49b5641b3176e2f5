"""What an experiment may ask for."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Unit

from controllers.minimum_jerk import minimum_jerk
from rig.hal import Motion, Segment
from rig.scaffolding.templates.mechanism.types import AXES, MyRigReference

_PEAK = 1.875
"""Of the speed of a minimum-jerk move over its mean."""


@dataclass(frozen=True, slots=True)
class MyRigTurns:
    """There, a rest, and back.

    Parameters
    ----------
    angle : float
        How far, rad.
    rise : float
        How long each way takes, s.
    rest : float
        How long it stands there, s.
    """

    angle: Annotated[float, Unit("rad"), Gt(0)]
    rise: Annotated[float, Unit("s"), Gt(0)] = 1.0
    rest: Annotated[float, Unit("s"), Ge(0)] = 0.5


class Turning(Motion[MyRigReference]):
    """The motion of `MyRigTurns`, of all axes alike."""

    def __init__(self, turns: MyRigTurns) -> None:
        self._turns = turns
        self.fastest = _PEAK * turns.angle / turns.rise
        """rad/s."""

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return 2.0 * self._turns.rise + self._turns.rest

    @property
    def segments(self) -> tuple[Segment, ...]:
        """Stretches that measures judge apart."""
        rise, rest = self._turns.rise, self._turns.rest
        return Segment("there", 0.0, rise), Segment("back", rise + rest, self.duration)

    def at(self, t: float) -> MyRigReference:
        """Return the desired angles and speeds at `t`."""
        angle, rise, rest = self._turns.angle, self._turns.rise, self._turns.rest
        if t < rise + rest:
            here, speed, _ = minimum_jerk(0.0, angle, rise, t)
        else:
            here, speed, _ = minimum_jerk(angle, 0.0, rise, t - rise - rest)
        return MyRigReference((here,) * len(AXES), (speed,) * len(AXES))
