"""What a log tells of a rod that never comes to rest while its reference does."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.experiment.measure import PHASE_RUN
from rig.hal.hindsight import HUNTS
from rig.hal.motion import Note
from rig.mechanisms.pneumatic.alarms.turns import Turns

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rig.hal.hindsight import Logged

    Array = NDArray[np.float64]

_SWING = 0.3e-3
"""m peak to peak: three times what swings in any of the shipped experiments."""
_SWINGS = 6
"""From one extreme to the next; fewer may be what a step has left behind."""
_KEPT = 0.5
"""What dies away is below this share of what it was at first."""
_STEP = 0.005
"""s between the samples that are looked at: loops swing more slowly than 20 Hz."""
_LOOK = 0.05
"""s over which a reference rests …"""
_STILL = 20e-6
"""… that moves by less, m: a camera goes on correcting it."""
_RESTS = 0.5
"""s: a reference that turns round rests for less."""


class Hunt(NamedTuple):
    """A stretch in which a rod swings about a reference that rests.

    Parameters
    ----------
    start, end : float
        s since the reference started.
    frequency : float
        Hz.
    size : float
        Mean way from one extreme to the next, m.
    """

    start: float
    end: float
    frequency: float
    size: float


def remarks_on_hunting(logged: "Logged", rods: Mapping[str, tuple[str, str]]) -> tuple[Note, ...]:
    """Return which rods or pairs hunt, the worst stretch of each, and what it may come from.

    Parameters
    ----------
    logged : callable
        Returns a column of the log by its name.
    rods : mapping
        What each is called, and the columns of its reference and its reading.
    """
    followed = np.flatnonzero(logged("phase") == PHASE_RUN)
    if len(followed) < 2:
        return ()
    time = logged("reference.time")[followed]
    every = max(1, round(_STEP * (len(time) - 1) / max(time[-1] - time[0], _STEP)))
    notes = []
    for name, (wanted, measured) in rods.items():
        goal = logged(wanted)[followed][::every]
        hunts = hunts_of(time[::every], goal, logged(measured)[followed][::every] - goal)
        if hunts:
            worst = max(hunts, key=lambda hunt: (hunt.end - hunt.start) * hunt.size)
            lasting = sum(hunt.end - hunt.start for hunt in hunts)
            notes.append(
                Note(
                    HUNTS,
                    f"{name} hunts about a reference that rests, for {lasting:.2g} s in all: at "
                    f"{worst.frequency:.1f} Hz by {1e3 * worst.size:.2g} mm peak to peak from "
                    f"{worst.start:.1f} s on: its gains do not bear this rig's "
                    "regulators and friction",
                )
            )
    return tuple(notes)


def hunts_of(t: "Array", goal: "Array", error: "Array") -> list[Hunt]:
    """Return the stretches in which an error swings on and on while its goal rests.

    Parameters
    ----------
    t, goal, error : ndarray, shape (n,)
        Instants, s; where a rod should be, and how far it is off, m.
    """
    look = max(1, round(_LOOK / max(float(np.median(np.diff(t))), 1e-6)))
    moves = np.abs(goal[look:] - goal[:-look]) > _STILL
    rests = np.concatenate(
        ([False], ~np.concatenate((np.full(look, fill_value=True), moves)), [False])
    )
    edges = np.flatnonzero(np.diff(rests.astype(int)))
    found = []
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if t[last - 1] - t[first] < _RESTS:
            continue
        turns = Turns(_SWING)
        extremes = [
            (at, extreme)
            for at, value in zip(t[first:last].tolist(), error[first:last].tolist(), strict=True)
            if (extreme := turns.update(value)) is not None
        ][1:]  # the first is where the rod came from
        sizes = np.abs(np.diff([value for _, value in extremes]))
        if len(sizes) < _SWINGS or sizes[-3:].mean() < _KEPT * sizes[:3].mean():
            continue
        (start, _), (end, _) = extremes[0], extremes[-1]
        found.append(Hunt(start, end, 0.5 * len(sizes) / (end - start), float(sizes.mean())))
    return found
