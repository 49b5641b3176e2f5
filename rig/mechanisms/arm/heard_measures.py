"""What an arm made of twists that nobody knew beforehand: numbers of the log by a plan's names.

Of twists that are known a plan says the same, and then its numbers are taken.
"""

from typing import TYPE_CHECKING

import numpy as np

from controllers.arm.singular_places import least_size
from rig.experiment.measure import Measure, Window, Windows
from rig.mechanisms.arm.fact_kinds import INDICES, TWIST_FACTS
from rig.mechanisms.arm.twist_facts import STANDS

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def _shares(window: Window) -> "tuple[Array, Array]":
    """Return which cycles ask for a twist, and which share of it the hand is sent in them."""
    told = np.abs(window.columns("plan.asked_")).max(axis=1) > 0.0
    return told, window.column("plan.scale")[told]


def _period(window: Window) -> float:
    return float(np.median(np.diff(window.t))) if len(window.t) > 1 else 0.0


def standing_share(windows: Windows) -> float:
    """Return in which share of the time with a twist the hand stands."""
    shares = np.concatenate([_shares(window)[1] for window in windows])
    return float((np.abs(shares) < STANDS).sum()) / max(len(shares), 1)


def lag(windows: Windows) -> float:
    """Return what the hand is late by at the end, s."""
    return sum(float((1.0 - _shares(window)[1]).sum()) * _period(window) for window in windows)


def distance_asked(windows: Windows) -> float:
    """Return the way of the hand that the twists ask for, m."""
    return sum(float(_speeds(window).sum()) * _period(window) for window in windows)


def distance(windows: Windows) -> float:
    """Return the way that the hand is sent, m."""
    return sum(
        float(np.linalg.norm(np.diff(window.columns("reference.hand_"), axis=0), axis=1).sum())
        for window in windows
    )


def distance_share(windows: Windows) -> float:
    """Return which share of the way that was asked for the hand is sent along the twists."""
    whole = distance_asked(windows)
    along = 0.0
    for window in windows:
        told, shares = _shares(window)
        along += float((shares * _speeds(window)[told]).sum()) * _period(window)
    return along / whole if whole else 1.0


def _speeds(window: Window) -> "Array":
    return np.asarray(np.linalg.norm(window.columns("plan.asked_v"), axis=1))


def _closest(name: str) -> "Callable[[Windows], float]":
    def compute(windows: Windows) -> float:
        return min(least_size(window.column(f"plan.index_{name}")) for window in windows)

    return compute


def _measure(name: str, compute: "Callable[[Windows], float]") -> Measure:
    kind = TWIST_FACTS[name]
    return Measure(compute, kind.unit, kind.description)


HEARD_MEASURES: dict[str, Measure] = {
    "lag": _measure("lag", lag),
    "standing_share": _measure("standing_share", standing_share),
    "distance_asked": _measure("distance_asked", distance_asked),
    "distance": _measure("distance", distance),
    "distance_share": _measure("distance_share", distance_share),
    **{f"closest_{of}": _measure(f"closest_{of}", _closest(of)) for of, _ in INDICES},
}
"""Of twists from Python or a gamepad; by the names and meanings of `TWIST_FACTS`."""
