"""What another law would have commanded on the readings of a run: in open loop.

The rig followed the commands that were logged, so the readings are not those that the other law
would have led to. Its integrals and observers see errors that it cannot mend: the longer the
replay, the less it says of how that law would control. What it says is how the law answers.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.hal import ConfigurationError, RigError
from rig.hal.columns import Column
from rig.replaying.recorded import RecordedRun
from rig.replaying.retrace import Retrace

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_GROUP = "command."
_MOST_PANELS = 12
"""As many as a page holds; the columns that differ most are drawn."""


class OpenLoopAnswer(NamedTuple):
    """The commands of another law, beside those of the log.

    Parameters
    ----------
    columns : tuple of Column
        The commands, k of them.
    t : ndarray
        Since the reference started, s, shape (n,).
    logged, other : ndarray
        Commands, SI, shape (n, k).
    stopped : str or None
        Why the other law could not go on to the end.
    """

    columns: tuple[Column, ...]
    t: "NDArray[np.float64]"
    logged: "NDArray[np.float64]"
    other: "NDArray[np.float64]"
    stopped: str | None

    @property
    def rms(self) -> "NDArray[np.float64]":
        """How far the commands are apart, SI, shape (k,)."""
        distance: NDArray[np.float64] = np.sqrt(np.mean((self.other - self.logged) ** 2, axis=0))
        return distance

    @property
    def most(self) -> "NDArray[np.float64]":
        """How far they are apart at most, SI, shape (k,)."""
        distance: NDArray[np.float64] = np.max(np.abs(self.other - self.logged), axis=0)
        return distance


def answer(run: RecordedRun) -> OpenLoopAnswer:
    """Feed the readings of a run to the law of its plan, whatever law recorded it.

    Raises
    ------
    ConfigurationError
        The law answers in no cycle.
    """
    trace = Retrace(run.plan, judged=False)
    places = [k for k, column in enumerate(trace.columns) if column.name.startswith(_GROUP)]
    columns = tuple(trace.columns[k] for k in places)
    rows: list[list[float]] = []
    stopped = None
    for logged in run.cycles():
        if logged.values["fault"]:
            break
        try:
            values = trace.step(logged)
        except RigError as error:
            stopped = f"after {logged.t:.3f} s the law could not go on: {error}"
            break
        rows.append([values[k] for k in places])
    if not rows:
        raise ConfigurationError(f"{run.folder.path}: {stopped or 'its first cycle is a fault'}")
    end = len(rows)
    logged_commands = np.column_stack([run.log.column(column.name)[:end] for column in columns])
    t = run.log.column("reference.time")[:end]
    return OpenLoopAnswer(columns, t, logged_commands, np.array(rows), stopped)


def draw(found: OpenLoopAnswer, names: tuple[str, str]) -> "Figure":
    """Draw the commands of both laws, a panel for each column.

    Parameters
    ----------
    found : OpenLoopAnswer
        What to draw.
    names : tuple of str
        The law of the log and the other one.
    """
    from rig.report.figure import draw_line, finish_time_axis, panels
    from rig.report.style import BLUE, PAGE, VERMILION, new_figure

    order = np.sort(np.argsort(found.rms)[::-1][:_MOST_PANELS])
    figure = new_figure(PAGE, 22.0 + 26.0 * len(order))
    for axes, k in zip(panels(figure, len(order), 1, sharex=True), order, strict=True):
        column = found.columns[k]
        draw_line(axes, found.t, found.logged[:, k], BLUE, f"{names[0]}, as it ran")
        draw_line(axes, found.t, found.other[:, k], VERMILION, f"{names[1]}, in open loop", lw=0.6)
        finish_time_axis(axes, found.t, f"{column.name.removeprefix(_GROUP)} ({column.unit})")
        axes.label_outer()
    figure.axes[0].legend(loc="upper right", ncols=2)
    return figure
