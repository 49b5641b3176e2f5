"""A walk from gains that are nearly right: one gain at a time, then what helped at once.

Gains in force often lack a single number: around them costs fall along few gains, which a search
that draws all of them at once finds late.

References
----------
R. Hooke and T. A. Jeeves, "'Direct search' solution of numerical and statistical problems",
Journal of the ACM 8, 1961.
"""

from collections.abc import Sequence
from typing import Final

Place = list[float]

STEPS: Final = (0.1, 0.06, 0.03)
"""Of each round, as a share of the bounds."""
TOGETHER: Final = 10
"""At most so many places of a round change several gains at once."""


def tried_by_walk(count: int) -> int:
    """Return how many places a walk tries at most, of so many gains."""
    return len(STEPS) * (2 * count + TOGETHER)


def one_by_one(place: Sequence[float], step: float) -> list[Place]:
    """Return the places beside one in which a single gain is greater or smaller."""
    found = []
    for number, share in enumerate(place):
        for moved in (share + step, share - step):
            other = list(place)
            other[number] = min(max(moved, 0.0), 1.0)
            found.append(other)
    return found


def together(
    place: Sequence[float], least: float, alone: Sequence[tuple[float, Place]]
) -> list[Place]:
    """Return places in which several gains move that helped alone: the two best, three, and on.

    Parameters
    ----------
    place : sequence of float
        Where the round began.
    least : float
        Its cost.
    alone : sequence of (float, list of float)
        What `one_by_one` returns, with costs.
    """
    helped: dict[int, float] = {}
    for cost, other in sorted(alone, key=lambda pair: pair[0]):
        moved = [number for number, share in enumerate(place) if share != other[number]]
        if cost < least and moved:
            helped.setdefault(moved[0], other[moved[0]])
    found, so_far = [], list(place)
    for number, share in helped.items():  # the best first
        so_far[number] = share
        found.append(list(so_far))
    return found[1 : 1 + TOGETHER]
