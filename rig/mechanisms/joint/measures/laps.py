"""What the joint's controller makes of repeated laps."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.experiment.measure import Measure, Window, Windows, rms
from rig.mechanisms.joint.measures.tracking import marker_error, pair_errors

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ENDED = 2.0
"""Of the column ``estimate.learning``: nothing more is learnt."""


class LapErrors(NamedTuple):
    """The errors that each lap of a window left.

    Parameters
    ----------
    wires, marker : ndarray
        rms errors of the pairs and of the marker, m, shape (laps,).
    ended : int or None
        The first lap in which nothing was learnt any more.
    """

    wires: "Array"
    marker: "Array"
    ended: int | None


def lap_errors(window: Window) -> LapErrors:
    """Return the errors of each lap in a window.

    Raises
    ------
    ValueError
        It has no laps.
    """
    laps = window.column("estimate.lap")
    wires, marker = pair_errors(window), np.linalg.norm(marker_error(window), axis=1)
    numbers = [int(number) for number in np.unique(laps) if number >= 0.0]
    if not numbers:
        raise ValueError(f"{window.segment.name}: nothing is repeated")
    ended = laps[(window.column("estimate.learning") == ENDED) & (laps >= 0.0)]
    return LapErrors(
        np.array([rms(wires[laps == number]) for number in numbers]),
        np.array([rms(marker[laps == number]) for number in numbers]),
        int(ended[0]) if len(ended) else None,
    )


def laps_learnt(windows: Windows) -> float:
    """Return after how many laps learning had ended in every window; infinite if it did not."""
    ended = [lap_errors(window).ended for window in windows]
    return max(float("inf") if number is None else float(number) for number in ended)


def learning_gain(windows: Windows) -> float:
    """Return the marker's rms error in the last lap over that in the first; the worst window."""
    errors = [lap_errors(window).marker for window in windows]
    return max(float(error[-1] / error[0]) for error in errors)


LAP_MEASURES: dict[str, Measure] = {
    "laps_learnt": Measure(laps_learnt, "", "laps after which learning had ended by itself"),
    "learning_gain": Measure(
        learning_gain, "", "the marker's error in the last lap over that in the first"
    ),
}
