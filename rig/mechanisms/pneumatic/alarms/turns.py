"""Where a signal turns round, told as it comes in."""

import math


class Turns:
    """Finds where a signal turns round, beyond a distance that it has to come back."""

    def __init__(self, distance: float, *, rises: bool = True) -> None:
        self.distance = distance
        self._furthest = -math.inf if rises else math.inf
        self._rises = rises

    def update(self, value: float) -> float | None:
        """Take the next value; return an extreme once the signal has come back from it."""
        furthest = self._furthest
        if self._rises:
            if value > furthest:
                self._furthest = value
            elif furthest - value > self.distance:
                self._rises = False
                self._furthest = value
                return furthest
        elif value < furthest:
            self._furthest = value
        elif value - furthest > self.distance:
            self._rises = True
            self._furthest = value
            return furthest
        return None
