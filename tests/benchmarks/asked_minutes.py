"""How long a program is to measure, as its user says it."""

import argparse
import math


def minutes(text):
    """Return a number of minutes; nothing can be measured in none."""
    value = float(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"it is {text}, and must be above 0")
    return value


def whole_minutes(text):
    """Return a whole number of minutes."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"it is {text}, and must be 1, 2, 3 …")
    return int(text)
