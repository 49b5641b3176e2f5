"""Metrics of one experiment under several versions: the same bytes, or the same but for rounding.

Numpy adds up in another order from version to version, and the newest one is not the same on every
Python. So the same bytes are asked of environments that compute with the same versions, whatever
their Python; others may differ in the last digits, and in what is nothing but rounding itself, a
residual of 4e-16.
"""

import json
import math
from collections.abc import Iterator, Mapping

ROUNDING = 1e-12
"""Relative, and in SI units."""

Texts = Mapping[str, str]
"""``metrics.json`` of each experiment."""


def same_bytes(first: Texts, second: Texts) -> Iterator[str]:
    """Yield what differs by a bit, experiment by experiment."""
    for name in sorted({*first, *second}):
        if first.get(name) != second.get(name):
            yield name


def same_numbers(first: Texts, second: Texts) -> Iterator[str]:
    """Yield what differs by more than rounding, with both values."""
    for name in sorted({*first, *second}):
        if name not in first or name not in second:
            yield f"{name}: missing"
            continue
        rows = (json.loads(texts[name])["metrics"] for texts in (first, second))
        for one, other in zip(*rows, strict=True):
            if not _agree(one, other):
                yield f"{name}: {one} against {other}"


def _agree(one: dict[str, object], other: dict[str, object]) -> bool:
    values = one["value"], other["value"]
    if {**one, "value": 0} != {**other, "value": 0}:
        return False
    if not all(isinstance(value, float) for value in values):
        return values[0] == values[1]
    return math.isclose(*values, rel_tol=ROUNDING, abs_tol=ROUNDING)
