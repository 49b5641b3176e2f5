"""Somebody moves something to both of its ends, and its sensor is watched meanwhile."""

from collections.abc import Callable
from math import inf
from typing import NamedTuple

from rig.assembly import Rig
from rig.commissioning.bench import StepBench
from rig.commissioning.hands import EndToEnd
from rig.commissioning.operator import Task
from rig.commissioning.site import Site

_STILL = 3.0
"""It has been moved when it is still for so long, s."""
_MOVED = 0.5
"""Least share of its span that it has gone by then."""


class Ends(NamedTuple):
    """The least and the greatest reading while something was moved to both of its ends, SI."""

    low: float
    high: float


def watch_ends(
    site: Site, bench: StepBench, task: Task, hand: EndToEnd, read: Callable[[], float], span: float
) -> Ends:
    """Have somebody move something to both of its ends; return the ends of its readings.

    Parameters
    ----------
    site, bench : Site, StepBench
        Where; connected, and without energy.
    task : Task
        What is asked for; it nudges `hand` in simulation.
    hand : EndToEnd
        The simulated hand.
    read : callable
        Returns the sensor's reading of this cycle, SI.
    span : float
        How far it should go from end to end, SI: a person who is still before half of it has not
        begun yet.

    Raises
    ------
    DeviceFault
        The sensor is not well on the way.
    """
    rig = bench.rig
    if site.world_of(rig) is not None:
        return _moved_by_hand(site, rig, bench, task, hand, read)
    site.operator.do(task, None)
    low, high, changed = inf, -inf, bench.now
    end = bench.now + site.patience(rig)
    while bench.now < end:
        bench.cycle()
        here = read()
        if here < low or here > high:
            changed = bench.now
        low, high = min(low, here), max(high, here)
        if high - low > _MOVED * span and bench.now - changed > _STILL:
            break
    return Ends(low, high)


def _moved_by_hand(
    site: Site, rig: Rig, bench: StepBench, task: Task, hand: EndToEnd, read: Callable[[], float]
) -> Ends:
    low, high = inf, -inf
    while not hand.is_back:
        site.operator.do(task, site.world_of(rig))
        bench.cycle()
        low, high = min(low, read()), max(high, read())
    return Ends(low, high)
