"""A push: a force of a person or a thing that a plant's body gets for a moment."""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

LASTS = 0.1
"""How long a push acts, s."""

_HALF = math.sqrt(0.5)
LEVEL = {
    "forward": (1.0, 0.0, 0.0),
    "forward_left": (_HALF, _HALF, 0.0),
    "left": (0.0, 1.0, 0.0),
    "back_left": (-_HALF, _HALF, 0.0),
}
"""Directions of a push from the side, by name; a negative push goes the other way."""
ALONG = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
"""Directions in the world's axes."""


class Push:
    """The force on one body of a plant.

    Parameters
    ----------
    force : ndarray, shape (n,)
        Where the plant takes the force at the body's centre of mass from, N, along its axes.
    directions : mapping
        Unit vectors by name.
    what : str
        How the push is called: ``push``, as in ``left.push``.
    """

    def __init__(
        self,
        force: NDArray[np.float64],
        directions: Mapping[str, tuple[float, ...]],
        what: str,
    ) -> None:
        self._force = force
        self._directions = {f"{name}.{what}": vector for name, vector in directions.items()}
        self.ends = math.inf
        """When it is over, s; infinite if nobody pushes."""

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names of the pushes."""
        return tuple(self._directions)

    def begin(self, fault: str, impulse: float | None, now: float) -> None:
        """Push with an impulse (N s, default 1) from now on, evenly for `LASTS`.

        Raises
        ------
        ValueError
            It is not a finite number.
        """
        size = 1.0 if impulse is None else impulse
        if not math.isfinite(size):
            raise ValueError(f"plant: {fault} takes a finite impulse, not {size:g} N s")
        self._force[:] = [size / LASTS * part for part in self._directions[fault]]
        self.ends = now + LASTS

    def end(self) -> None:
        """Push no more."""
        self._force[:] = 0.0
        self.ends = math.inf
