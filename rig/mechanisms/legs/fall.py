"""Whether the robot has fallen, by two sensors that know nothing of each other."""

import math
from typing import Final

from controllers.gait.sensing import Sensing
from rig.hal import SafetyError

_BORNE: Final = 0.5
"""Share of its weight that a robot on its feet has on them, even while it lands."""
_LASTS: Final = 0.05
"""s; a foot that lands hard has left the ground for less."""
_LIFTED: Final = 0.1
"""Share of its weight below which it stands on nothing, however it leans, …"""
_GONE: Final = 0.3
"""… for so long, s: no walk has it in the air."""


class FallWatch:
    """Stops a robot that leans while its feet bear little, or that has stood and stands no more.

    An inertial sensor that lies does not stop a robot that stands, nor do load cells that show half
    of what they bear. Legs that hang from the start, and have never stood, may move in the air.

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
        self._bound = bound
        self._weight = weight
        self._most_leaning = max(1, round(_LASTS / period))
        self._most_lifted = max(1, round(_GONE / period))
        self._leaning = self._lifted = 0
        self._has_stood = False
        self.has_fallen = False

    def see(self, sensing: Sensing) -> None:
        """Take the measurements of a cycle.

        Raises
        ------
        SafetyError
            They have been those of a robot that falls for 50 ms, or that has left its feet for
            0.3 s.
        """
        if self._bound is None:
            return
        lean = max(map(abs, sensing.lean))
        borne = sensing.feet[0].force + sensing.feet[1].force
        is_light = borne < _BORNE * self._weight
        self._has_stood |= not is_light
        self._leaning = self._leaning + 1 if is_light and lean > self._bound else 0
        is_lifted = self._has_stood and borne < _LIFTED * self._weight
        self._lifted = self._lifted + 1 if is_lifted else 0
        if self._leaning >= self._most_leaning or self._lifted >= self._most_lifted:
            self.has_fallen = True
            raise SafetyError(
                f"the robot falls, lies or is lifted: its feet bear {borne:.3g} N of its weight of "
                f"{self._weight:.3g} N, and its waist leans by {math.degrees(lean):.3g} deg, the "
                f"limit is {math.degrees(self._bound):.3g} deg (legs.fall_tilt). It was pushed or "
                f"struck, it stood on an edge or slipped, or a joint gave way"
            )
