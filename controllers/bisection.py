"""Where something stops being true, by halving."""

from collections.abc import Callable


def bisect(
    holds: Callable[[float], bool], low: float, high: float, rounds: int = 60
) -> tuple[float, float]:
    """Return the ends of the interval in which a condition stops to hold.

    For conditions that jump; where a smooth function changes its sign a solver needs fewer calls.

    Parameters
    ----------
    holds : callable
        Whether the condition holds: it does at `low` and does not at `high`.
    low, high : float
        Where to begin.
    rounds : int
        How often the interval is halved.
    """
    for _ in range(rounds):
        middle = 0.5 * (low + high)
        if holds(middle):
            low = middle
        else:
            high = middle
    return low, high
