"""Whether the robot has fallen, by two sensors that know nothing of each other."""

import math
from typing import Final

from controllers.gait.sensing import Sensing
from rig.hal import SafetyError

_BORNE: Final = 0.5
"""Share of its weight that a robot on its feet has on them, even while it lands."""
_LASTS: Final = 0.05
"""s; a foot that lands hard has left the ground for less."""


class FallWatch:
    """Stops a robot whose waist leans while its feet bear next to nothing, and only then.

    An inertial sensor that lies alone does not stop a robot that stands, nor does a robot fall that
    is lifted upright.

    Parameters
    ----------
    bound : float or None
        Lean of the waist beyond which a robot may have fallen, rad; None: it is not watched.
    weight : float
        Of the robot, N.
    period : float
        The loop's, s.
    """

    def __init__(self, bound: float | None, weight: float, period: float) -> None:
        self._bound = math.inf if bound is None else bound
        self._weight = weight
        self._most = max(1, round(_LASTS / period))
        self._cycles = 0

    @property
    def has_fallen(self) -> bool:
        """Whether it has been found to fall."""
        return self._cycles >= self._most

    def see(self, sensing: Sensing) -> None:
        """Take the measurements of a cycle.

        Raises
        ------
        SafetyError
            They have been those of a robot that falls, for 50 ms.
        """
        lean = max(map(abs, sensing.lean))
        borne = sensing.feet[0].force + sensing.feet[1].force
        falls = lean > self._bound and borne < _BORNE * self._weight
        self._cycles = self._cycles + 1 if falls else 0
        if self.has_fallen:
            raise SafetyError(
                f"the robot falls or lies: its waist leans by {math.degrees(lean):.3g} deg, the "
                f"limit is {math.degrees(self._bound):.3g} deg (legs.fall_tilt), and its feet bear "
                f"{borne:.3g} N of its weight of {self._weight:.3g} N. It was pushed or struck, it "
                f"stood on an edge or slipped, or a joint gave way"
            )
