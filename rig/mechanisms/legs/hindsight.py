"""What a simulated walk's log tells once it has ended: when the robot fell, and over which step."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from controllers.gait.geometry import LEGS
from rig.experiment.measure import PHASE_RUN
from rig.hal.motion import Note
from rig.mechanisms.legs.measures import from_first_stance

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rig.hal.hindsight import Logged

    Array = NDArray[np.float64]

_ON_EDGE = 2e-3
"""A foot that stands so much higher or lower than its print stands on something else, m."""
_SETTLED = 0.3
"""After a foot was to stand it does, s."""


def remark_on_fall(logged: "Logged", phases: Sequence[str]) -> tuple[Note, ...]:
    """Return when the robot fell, and which foot stood too high or too low before, if it fell.

    Parameters
    ----------
    logged : callable
        Returns a column of the log by its name; one of a simulation has the plant's truth.
    phases : sequence of str
        What those of the plan are called.
    """
    followed = logged("phase") == PHASE_RUN
    fell = np.flatnonzero(logged("truth.fell")[followed] > 0.5)
    if not len(fell):
        return ()
    time = logged("reference.time")[followed]
    number = logged("plan.phase")[followed].astype(int)

    def when(sample: int) -> str:
        return f"{time[sample]:.2f} s ({phases[number[sample]]})"

    words = f"the robot fell after {when(int(fell[0]))}"
    off = _off_prints(logged, followed)[: fell[0]]
    stands = np.column_stack([logged(f"plan.stands_{leg}")[followed] > 0.5 for leg in LEGS])
    settled = _for_long(stands[: fell[0]], time[: fell[0]])
    for sample, leg in np.argwhere(settled & (np.abs(off[:, :, 2]) > _ON_EDGE))[:1].tolist():
        x, y, up = 1e3 * off[sample, leg]
        words += (
            f"; from {when(sample)} on its {LEGS[leg]} foot is {abs(up):.1f} mm "
            f"{'higher' if up > 0.0 else 'lower'} than planned and {np.hypot(x, y):.1f} mm beside "
            f"its print: one of the feet is on an edge, the ground is not the plan's, or the robot "
            f"was pushed"
        )
    return (Note("fell", words),)


def _off_prints(logged: "Logged", followed: "NDArray[np.bool_]") -> "Array":
    """Return how far both feet are from where they are planned, shape (n, 2, 3), m."""
    truth, planned = (
        from_first_stance(
            np.stack(
                [
                    np.column_stack([logged(f"{of}.{leg}_foot_{axis}")[followed] for axis in "xyz"])
                    for leg in LEGS
                ],
                axis=1,
            )
        )
        for of in ("truth", "reference")
    )
    return truth - planned


def _for_long(stands: "NDArray[np.bool_]", time: "Array") -> "NDArray[np.bool_]":
    """Return where feet have been to stand for long enough to do so, shape (n, 2)."""
    since = np.where(stands, -np.inf, time[:, None])  # the last instant at which it was in the air
    return np.asarray(time[:, None] - np.maximum.accumulate(since, axis=0) >= _SETTLED)
