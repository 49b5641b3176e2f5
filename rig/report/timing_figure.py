"""The figure of the cycle's times."""

from typing import TYPE_CHECKING

import numpy as np

from rig.report.data import RunData
from rig.report.figure import FigureKind
from rig.report.style import BLUE, INK, PAGE, PALETTE, VERMILION, new_figure, place_legend
from rig.report.timing import STAGES, has_timing, work_times

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rig.runtime.log_columns import LogColumns

_VIRTUAL = 1e-3
"""No cycle is later on a virtual clock, by rounding; on a real one some are, µs."""
_COMPILING = 50
"""Cycles in which a run that nothing was rehearsed for may compile what it calls first."""


def draw_timing(run: RunData) -> "Figure | None":
    """Draw what each stage of the cycle costs and how long whole cycles were."""
    if not has_timing(run.log):
        return None
    figure = new_figure(PAGE, 60.0)
    left, right = figure.subplots(1, 2, width_ratios=[1.15, 1.0])
    lateness = run.log.column("timing.lateness") * 1e6
    is_virtual = float(lateness.max()) < _VIRTUAL
    first = _COMPILING if is_virtual and len(lateness) > 2 * _COMPILING else 0
    rows = np.arange(len(STAGES))
    sums, median, p99, longest = np.array([_summed_up(run.log, s, first) for s in STAGES]).T
    share = sums / max(float(sums.sum()), 1e-12)
    left.hlines(rows, median, longest, color="#c9d3dc", lw=2.2, zorder=1)
    left.plot(median, rows, "o", color=BLUE, ms=4, label="median")
    left.plot(p99, rows, "|", color=INK, ms=8, mew=1.2, label="99 %")
    left.plot(longest, rows, "D", color=VERMILION, ms=2.6, label="longest")
    labels = [f"{s}  {100 * p:.0f} %" for s, p in zip(STAGES, share, strict=True)]
    left.set_yticks(rows, labels=labels)
    left.set_ylim(len(STAGES) - 0.5, -0.5)
    left.grid(axis="y", visible=False)
    left.set_xscale("log")
    without = f"\nwithout the first {first} cycles, which compile" if first else ""
    left.set_xlabel(f"time per cycle (µs){without}")
    left.set_ylabel("stage and its share")
    place_legend(left, 3)

    work = work_times(run.log)[first:] * 1e6
    period = float(np.median(work + run.log.column("timing.slack")[first:] * 1e6))
    top = max(float(work.max()), period)
    late = lateness[:0] if is_virtual else lateness[lateness > 0.0]
    bottom = min([float(work.min()), *np.percentile(late, [1.0])] if len(late) else [work.min()])
    bins = np.geomspace(max(bottom, 0.1), top * 1.05, 60)
    right.hist(work, bins=bins, histtype="stepfilled", color=PALETTE[5], label="work")
    if len(late):
        right.hist(
            np.maximum(late, bins[0]),
            bins=bins,
            histtype="step",
            color=VERMILION,
            lw=0.9,
            label="lateness",
        )
    right.axvline(period, color=INK, lw=0.8, ls=(0, (4, 2)), label="period")
    right.set_xscale("log")
    right.set_yscale("log")
    right.set_xlabel("time (µs)")
    right.set_ylabel("cycles")
    place_legend(right, 3)
    return figure


def _summed_up(log: "LogColumns", stage: str, first: int) -> tuple[float, float, float, float]:
    """Return sum, median, 99 % and maximum of a stage's times from a cycle on, µs."""
    times = log.column(f"timing.{stage}")[first:] * 1e6
    median, p99 = np.percentile(times, [50.0, 99.0])
    return float(times.sum()), float(median), float(p99), float(times.max())


TIMING_FIGURES = {
    "timing": FigureKind(
        draw_timing, "What each stage of the cycle costs, and how long whole cycles took."
    ),
}
