"""How hard a pair may pull within its limits, beside what its seals take to let go."""

from typing import Final

from rig.hal.formats import format_quantity
from rig.hal.quantities import Expected
from rig.mechanisms.pneumatic.settings import PneumaticSettings

USUAL_FLOOR: Final = 20e3
"""`pressure_floor` of the laws that ship, where a profile says no other one, Pa gauge."""
_FRICTION: Final = 1.6
"""Times the friction that a profile says: as much as units, wear and dry seals differ by. E"""


def compute_pull(settings: PneumaticSettings, base: float) -> float:
    """Return the greatest force of a pair at a base pressure (Pa), N; not above 0: it has none.

    Laws keep the mean of a pair's pressures at the base: one rises by what the other falls, and
    neither falls below their floor.
    """
    return 2.0 * settings.area * min(settings.limits.pressure[1] - base, base - _least(settings))


def say_too_low(settings: PneumaticSettings, base: float) -> str:
    """Say that a pair may not break its seals away at a base pressure (Pa); empty: it does."""
    pull, breakaway = compute_pull(settings, base), settings.friction.breakaway
    if pull >= _FRICTION * breakaway:
        return ""
    return (
        f"it leaves a pair {format_quantity(max(pull, 0.0), 'N')} above the usual pressure_floor "
        f"({format_quantity(_least(settings), 'Pa')}), and its seals take {breakaway:.3g} N to let "
        f"go, dry ones {_FRICTION:g} times that"
    )


def expect_pull(settings: PneumaticSettings) -> Expected:
    """Return the greatest force of a pair, N, and warn if it may not break the seals away."""
    (_, high), base = settings.limits.pressure, settings.base_pressure
    breakaway = settings.friction.breakaway
    warning = ""
    if say_too_low(settings, base):
        warning = (
            f"the seals take {breakaway:.3g} N to let go, and dry ones {_FRICTION:g} times that: "
            f"from the usual pressure_floor ({format_quantity(_least(settings), 'Pa')}) to the "
            f"most of limits.pressure ({format_quantity(high, 'Pa')}) leaves too little to either "
            f"side of base_pressure ({format_quantity(base, 'Pa')})"
        )
    pull = max(compute_pull(settings, base), 0.0)
    return Expected("the most that a pair may pull with", pull, "N", warning)


def _least(settings: PneumaticSettings) -> float:
    return max(settings.limits.pressure[0], USUAL_FLOOR)
