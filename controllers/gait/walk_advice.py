"""What would fit for a whole walk where no step of its own helps: flatter, longer treads."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from controllers.gait.footprints import Footstep

_FOLLOWS = (40, 60, 80)
"""How far the waist might go to meet a foot, mm."""
_FLATTER = tuple(round(0.1 * k, 1) for k in range(10, 0, -1))
"""What all heights are multiplied by, the most first."""
_LONGER = (1.0, 1.05, 1.1, 1.2, 1.3)
"""What all ways ahead are multiplied by; where the robot turns, they stay."""

WalkFits = Callable[[Sequence[Footstep], float], bool]


def advise_walk(fits: WalkFits, steps: Sequence[Footstep], follow: float) -> str:
    """Say how all steps would fit, flatter, longer or with a waist that goes to meet the foot.

    A step down may do by itself and leave the foot behind too high for the next one: then what has
    to change lies before the step that is refused.

    Parameters
    ----------
    fits : callable
        Whether all steps can be done with a waist that follows so far, m.
    steps : sequence of Footstep
        As they are asked for.
    follow : float
        How far the waist goes to meet a foot as it is, m.
    """
    follows = (follow, *(1e-3 * mm for mm in _FOLLOWS if 1e-3 * mm > follow))
    ahead = all(step.heading == 0.0 for step in steps)
    slopes = any(step.pitch or step.roll for step in steps)
    climbs = any(step.height for step in steps) and not slopes
    for flatter in _FLATTER if climbs else _FLATTER[:1]:
        for longer in _LONGER if ahead and not slopes else _LONGER[:1]:
            tried = [replace(s, x=s.x * longer, height=s.height * flatter) for s in steps]
            for its in follows:
                if fits(tried, its):
                    said = [
                        f"follow at {its * 1e3:.0f} mm" if its != follow else "",
                        f"every height times {flatter:g}" if flatter != 1.0 else "",
                        f"every x times {longer:g}" if longer != 1.0 else "",
                    ]
                    words = ", ".join(word for word in said if word)
                    return f" With {words} all steps would fit."
    return ""
