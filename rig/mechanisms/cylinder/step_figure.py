"""The figure of a step response: every step of a run on top of each other, and how it is judged."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from rig.experiment.measure import NoSuchMotion, Samples, Window
from rig.mechanisms.cylinder.measures import (
    SETTLING_BAND,
    first_time,
    overshoot,
    rise_time,
    settling_time,
    step_response,
    steps_of,
)
from rig.report.data import RunData
from rig.report.figure import FigureKind
from rig.report.style import BAND, GREY, INK, PAGE, PALETTE, new_figure, segment_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from numpy.typing import NDArray

_MOST: Final = 6
"""Steps that are told apart by colour."""
_LEVELS: Final = (0.1, 0.9)
"""Between these shares of a step its rise is timed."""


def draw_steps(run: RunData) -> "Figure | None":
    """Draw the share of each step that is done over the time since it, with what is judged."""
    if not run.has("reference.position", "reading.position", "reference.time", "phase"):
        return None
    try:
        steps = steps_of(_windows(run))
    except NoSuchMotion:
        return None
    figure = new_figure(PAGE, 72.0)
    axes = figure.subplots()
    longest = max(float(window.t[-1] - window.t[0]) for window in steps)
    told = f"within {100.0 * SETTLING_BAND:.0f} %"
    near = (1.0 - SETTLING_BAND, 1.0 + SETTLING_BAND)
    axes.axhspan(*near, color=BAND, lw=0, zorder=0, label=told)
    for level in (0.0, 1.0):
        axes.axhline(level, color=GREY, lw=0.5)
    shown = [_Step(window) for window in steps[:_MOST]]
    wanted = _reference(steps[0])
    axes.plot(shown[0].t, wanted, color=INK, lw=0.7, ls=(0, (4, 2)), label="reference")
    for step, color in zip(shown, PALETTE, strict=False):
        axes.plot(step.t, step.done, color=color, lw=0.9, label=step.told)
        _mark(axes, step, color)
    axes.set_xlim(0.0, longest)
    axes.set_xlabel("time since the step (s)")
    axes.set_ylabel("share of the step (1)")
    lines = axes.get_legend_handles_labels()[0]
    axes.legend(handles=[*lines, *_marks_of(shown)], loc="center right")
    return figure


def _windows(run: RunData) -> list[Window]:
    """Return the segments as far as the log goes: what was broken off is drawn, too."""
    samples = Samples(run.log)
    found = []
    for segment in run.segments:
        first, last = np.searchsorted(samples.t, [segment.start, segment.end]).tolist()
        if last - first > 1:
            found.append(Window(segment, samples, slice(first, last)))
    return found


class _Step:
    """A step, and when it rose, how far it went too far, and when it was settled."""

    def __init__(self, window: Window) -> None:
        self.t = window.t - window.t[0]
        self.done = step_response(window)
        self.low, self.high = (first_time(self.t, self.done >= level) for level in _LEVELS)
        self.rise = rise_time([window])
        self.over = overshoot([window])
        self.settled = settling_time([window])
        ends = "never settles" if math.isinf(self.settled) else f"settled {self.settled:.2f} s"
        rises = "never rises" if math.isinf(self.rise) else f"rise {self.rise:.2f} s"
        name = segment_label(window.segment.name)
        self.told = f"{name}: {rises}, overshoot {100.0 * self.over:.0f} %, {ends}"


def _reference(window: Window) -> "NDArray[np.float64]":
    """Return the share of a step that its reference has gone."""
    wanted = window.column("reference.position")
    before = window.before("reference.position")
    start = float(wanted[0]) if before is None else before
    way = float(wanted[-1]) - start
    return np.asarray((wanted - start) / way)


def _mark(axes: "Axes", step: _Step, color: str) -> None:
    """Mark the two ends of the rise, the peak beyond the level, and the end of the settling."""
    for t, level in zip((step.low, step.high), _LEVELS, strict=True):
        if math.isfinite(t):
            axes.plot(t, level, "o", ms=3.5, mfc="white", color=color, label="_rise")
    if step.over > 0.0:
        peak = int(np.argmax(step.done))
        axes.plot(step.t[peak], step.done[peak], "^", ms=4.0, color=color, label="_overshoot")
    if math.isfinite(step.settled):
        at = int(np.searchsorted(step.t, step.settled).clip(max=len(step.t) - 1))
        axes.plot(step.t[at], step.done[at], "s", ms=3.5, color=color, label="_settled")


def _marks_of(steps: "Sequence[_Step]") -> "list[Line2D]":
    """Return what the marks mean, of those that any step has."""
    from matplotlib.lines import Line2D

    rise = f"rise from {100.0 * _LEVELS[0]:.0f} to {100.0 * _LEVELS[1]:.0f} %"
    marks = (
        ("o", "white", rise, any(math.isfinite(step.low) for step in steps)),
        ("^", GREY, "overshoot", any(step.over > 0.0 for step in steps)),
        ("s", GREY, "settled", any(math.isfinite(step.settled) for step in steps)),
    )
    return [
        Line2D([], [], ls="", marker=marker, ms=4.0, mfc=fill, mec=GREY, label=label)
        for marker, fill, label, is_shown in marks
        if is_shown
    ]


STEP_FIGURES = {
    "step-response": FigureKind(
        draw_steps,
        "Each step as a share of its size: circles where its rise is timed (10 and 90 %), a "
        "triangle at the overshoot, a square where it stays within the band of 2 %.",
    ),
}
