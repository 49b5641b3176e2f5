"""Of a slow test of many drawn cases, the few that have their turn today.

A test says ``@pytest.mark.sampled(4)``: of its slow cases four stay what they are, the rest are
`lengthy` today. ``each="rig"`` means four of each rig. The cases go round in an order of the
test's own, so that n cases have all had their turn after n / 4 days. The name of a case that fails
says all that it was drawn from: ``pytest -m slow 'FILE::TEST[CASE]'`` repeats it on any day.
"""

import datetime
import os
import random
from collections.abc import Hashable, Sequence
from typing import Any, TypeVar

import pytest

DAY = "SAMPLE_DAY"
"""The variable that says which day it is, counted from the first of the year 1."""
_LENGTHY = pytest.mark.lengthy

Case = TypeVar("Case", bound=Hashable)


def today() -> int:
    """Return the day of this session, the same in all of its processes."""
    return int(os.environ.setdefault(DAY, str(datetime.date.today().toordinal())))


def having_their_turn(cases: Sequence[Case], most: int, day: int, name: str) -> set[Case]:
    """Return the cases of a day.

    Parameters
    ----------
    cases : sequence
        All of them.
    most : int
        How many a day has.
    day : int
        Which; the next one goes on where it ends.
    name : str
        Of what they are cases: their order is drawn from it, lest neighbours of all tests meet.
    """
    order = random.Random(name).sample(cases, len(cases))
    return {order[(day * most + k) % len(order)] for k in range(most)}


def set_the_others_apart(items: Sequence[Any], day: int) -> None:
    """Mark the cases that have no turn today as `lengthy`.

    Raises
    ------
    pytest.UsageError
        A test is lengthy and not slow: nothing would leave it out of the default set.
    """
    groups: dict[str, list[Any]] = {}
    for item in items:
        marker = item.get_closest_marker("sampled")
        is_slow, is_lengthy = map(item.get_closest_marker, ("slow", "lengthy"))
        if is_lengthy and not is_slow:
            raise pytest.UsageError(f"{item.nodeid} is marked lengthy, and not slow")
        if marker is not None and is_slow and not is_lengthy:
            each = marker.kwargs.get("each")
            of = "" if each is None else f" {item.callspec.params[each]!r}"
            groups.setdefault(f"{item.nodeid.partition('[')[0]}{of}", []).append(item)
    for name, group in groups.items():
        (most,) = group[0].get_closest_marker("sampled").args
        cases = {item.nodeid: item for item in group}
        for case in cases.keys() - having_their_turn([*cases], most, day, name):
            cases[case].add_marker(_LENGTHY)
