"""How hard a pair may pull within its limits, beside what its seals take to let go."""

from typing import Final

from rig.hal.quantities import Expected
from rig.mechanisms.pneumatic.settings import PneumaticSettings

_FRICTION: Final = 1.6
"""Times the friction that a profile says: as much as units, wear and dry seals differ by. E"""


def expect_pull(settings: PneumaticSettings) -> Expected:
    """Return the greatest force of a pair, N, and warn if it may not break the seals away.

    Laws keep the mean of a pair's pressures at the base: one rises by what the other falls.
    """
    (low, high), base = settings.limits.pressure, settings.base_pressure
    pull = 2.0 * settings.area * min(high - base, base - low)
    breakaway = settings.friction.breakaway
    warning = ""
    if pull < _FRICTION * breakaway:
        warning = (
            f"the seals take {breakaway:.3g} N to let go, and dry ones {_FRICTION:g} times that: "
            f"limits.pressure ({low * 1e-3:.4g} … {high * 1e-3:.4g} kPa) leaves too little to "
            f"either side of base_pressure ({base * 1e-3:.4g} kPa)"
        )
    return Expected("the most that a pair may pull with", pull, "N", warning)
