"""The figure of the limits that cut commands: which of them, which channels, when, how often."""

import csv
import io
from collections import defaultdict
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.report.data import RunData
from rig.report.figure import TIME_LABEL, FigureKind
from rig.report.style import BLUE, PAGE, VERMILION, new_figure
from rig.run_facts import read_events

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_ROW = 9.0
"""Height of a row, mm."""
_SAME = 1e-9
"""Share of its size by which an applied command differs by rounding alone."""
_COMMAND, _APPLIED = "command.", "applied."


class _Cut(NamedTuple):
    """A channel whose command was cut: the cycles, and what was wanted and applied in each."""

    channel: str
    unit: str
    cycles: "NDArray[np.int64]"
    wanted: "NDArray[np.float64]"
    applied: "NDArray[np.float64]"


def draw_limits(run: RunData) -> "Figure | None":
    """Draw when each limit began to cut commands, and of which channels; None if none ever did."""
    times, hits = _told(run)
    if not times:
        return None
    cuts = list(_cuts(run))
    count = len(times) + len(cuts)
    figure = new_figure(PAGE, 28.0 + _ROW * count)
    axes = figure.subplots()
    label = "begins to cut"
    for row, began in enumerate(times.values()):
        at = np.interp(began, run.log.t, run.t)
        axes.plot(at, [row] * len(at), "|", color=VERMILION, ms=9, label=label)
        label = "_"
    label = "command is cut"
    for row, cut in enumerate(cuts, len(times)):
        spans = [(run.t[a], run.t[b] - run.t[a]) for a, b in _stretches(cut.cycles, len(run.t))]
        axes.broken_barh(spans, (row - 0.2, 0.4), facecolors=BLUE, lw=0, label=label)
        label = "_"
    labels = [f"{name}: {hits[name]} cycles" for name in times]
    labels += [f"{cut.channel}: {len(cut.cycles)} cycles" for cut in cuts]
    axes.set_yticks(range(count), labels=labels)
    axes.set_ylim(count - 0.5, -0.5)
    axes.set_xlim(float(run.t[0]), float(run.t[-1]))
    axes.grid(axis="y", visible=False)
    axes.set_xlabel(TIME_LABEL)
    figure.legend(loc="outside upper right", ncols=2, frameon=False)
    return figure


def table_of_limits(run: RunData) -> str:
    """Return every cycle in which a command was cut: time, limit, channel, value and bound, SI.

    Notes
    -----
    A log says what was wanted and what was applied, not which limit cut it: where several did in a
    run, all are named.
    """
    limit = " or ".join(_told(run)[0])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("time (s)", "limit", "channel", "value", "bound", "unit"))
    rows = (
        (run.t[k], limit, cut.channel, wanted, applied, cut.unit)
        for cut in _cuts(run)
        for k, wanted, applied in zip(cut.cycles, cut.wanted, cut.applied, strict=True)
    )
    for t, *names, wanted, applied, unit in sorted(rows, key=lambda row: row[0]):
        writer.writerow((f"{t:.9g}", *names, f"{wanted:.9g}", f"{applied:.9g}", unit))
    return text.getvalue()


def _told(run: RunData) -> tuple[dict[str, list[float]], dict[str, int]]:
    """Return when each limit began to cut, by the log's clock, and in how many cycles it did."""
    times: dict[str, list[float]] = defaultdict(list)
    hits: dict[str, int] = {}
    for event in read_events(run.folder.path):
        t, count = event.get("t"), event.get("data", {}).get("hits")
        if event.get("kind") != "limit" or t is None or not isinstance(count, int):
            continue
        name, begins, _ = event["message"].partition(" is limited")
        if begins:
            times[name].append(t)
        hits[name.partition(" was limited")[0]] = count  # the run's last event of it: of all
    return times, hits


def _cuts(run: RunData) -> Iterator[_Cut]:
    """Yield the channels whose applied command is not the one that the law gave."""
    for column in run.log.columns:
        channel = column.name.removeprefix(_COMMAND)
        if channel == column.name or _APPLIED + channel not in run.log:
            continue
        wanted, applied = run.log.column(column.name), run.log.column(_APPLIED + channel)
        cycles = np.flatnonzero(np.abs(wanted - applied) > _SAME * np.abs(wanted).max(initial=0.0))
        if len(cycles):
            yield _Cut(channel, column.unit, cycles, wanted[cycles], applied[cycles])


def _stretches(cycles: "NDArray[np.int64]", count: int) -> Iterator[tuple[int, int]]:
    """Yield the first cycle of each stretch, and the one after it."""
    ends = np.flatnonzero(np.diff(cycles) > 1)
    firsts = cycles[np.concatenate(([0], ends + 1))]
    lasts = cycles[np.concatenate((ends, [len(cycles) - 1]))]
    for first, last in zip(firsts, lasts, strict=True):
        yield int(first), min(int(last) + 1, count - 1)


LIMIT_FIGURES = {
    "limits": FigureKind(
        draw_limits,
        "When each limit of the profile began to cut commands, and in how many cycles it did; "
        "below, the channels whose command was cut.",
        table_of_limits,
    ),
}
