"""Numbers as they are said: in so few digits that somebody can write them down."""

import math


def floor(value: float) -> float:
    """Return the greatest number of four digits that is no greater."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 3)
    return float(f"{math.floor(value / digit) * digit:.4g}")


def ceiling(value: float) -> float:
    """Return the least number of four digits that is no less."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 3)
    return float(f"{math.ceil(value / digit) * digit:.4g}")
