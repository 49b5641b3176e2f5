"""The figure of the limits that cut commands: which of them, which channels, when, how often."""

import csv
import io
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
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
_PIECE = 10_000
"""Cycles that are looked at together: what they take of memory does not grow with the run."""


class _Pair(NamedTuple):
    """A channel with what was wanted and applied in each cycle, and what they differ by if cut."""

    channel: str
    unit: str
    wanted: "NDArray[np.float64]"
    applied: "NDArray[np.float64]"
    least: float

    def cut_in(self, begin: int) -> "NDArray[np.int64]":
        """Return the cycles of a piece in which the command was cut."""
        part = slice(begin, begin + _PIECE)
        return begin + np.flatnonzero(np.abs(self.wanted[part] - self.applied[part]) > self.least)


class _Cut(NamedTuple):
    """A channel whose command was cut, and in which cycles."""

    channel: str
    cycles: "NDArray[np.int64]"


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


def table_of_limits(run: RunData) -> Iterator[str]:
    """Yield every cycle in which a command was cut: time, limit, channel, value and bound, SI.

    The pieces together are a CSV, cycle by cycle as in the log.

    Notes
    -----
    A log says what was wanted and what was applied, not which limit cut it: where several did in a
    run, all are named.
    """
    limit = " or ".join(_told(run)[0])
    pairs, times = list(_pairs(run)), run.t
    yield _lines([("time (s)", "limit", "channel", "value", "bound", "unit")])
    for begin in range(0, len(times), _PIECE):
        cut = [(k, number) for number, pair in enumerate(pairs) for k in pair.cut_in(begin)]
        yield _lines(
            (f"{times[k]:.9g}", limit, pair.channel, f"{pair.wanted[k]:.9g}",
             f"{pair.applied[k]:.9g}", pair.unit)
            for k, pair in ((k, pairs[number]) for k, number in sorted(cut))
        )  # fmt: skip


def _lines(rows: Iterable[Sequence[str]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
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
    for pair in _pairs(run):
        found = [pair.cut_in(begin) for begin in range(0, len(pair.wanted), _PIECE)]
        cycles = np.concatenate(found) if found else np.zeros(0, np.int64)
        if len(cycles):
            yield _Cut(pair.channel, cycles)


def _pairs(run: RunData) -> Iterator[_Pair]:
    """Yield the channels of which a log has both what was wanted and what was applied."""
    for column in run.log.columns:
        channel = column.name.removeprefix(_COMMAND)
        if channel == column.name or _APPLIED + channel not in run.log:
            continue
        wanted, applied = run.log.column(column.name), run.log.column(_APPLIED + channel)
        size = max(wanted.max(initial=0.0), -wanted.min(initial=0.0))
        yield _Pair(channel, column.unit, wanted, applied, _SAME * float(size))


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
