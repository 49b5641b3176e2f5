"""The figure of what was true of a rig that was broken, until after its program had ended."""

from typing import TYPE_CHECKING, NamedTuple, TypedDict

import numpy as np

from rig.report.data import RunData
from rig.report.figure import FigureKind, draw_line
from rig.report.style import GREY, INK, PAGE, PALETTE, VERMILION, new_figure
from rig.run_facts import TRUTH, TRUTH_COLUMNS, read_events
from rig.typed_json import read_json

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_BEFORE = 0.3
"""So much is drawn before the first fault, s."""
_PANEL = 34.0
"""Height of a panel, mm."""
_MARKED = {"injected": VERMILION, "fault": INK, "hazard": VERMILION, "not counted": VERMILION}
"""Kinds of events that are lines; what was injected is dashed."""
_SCALES = {"m": (1e3, "mm"), "Pa": (1e-3, "kPa"), "rad": (180.0 / np.pi, "deg"),
           "rad/s": (180.0 / np.pi, "deg/s")}  # fmt: skip


class _What(TypedDict):
    """A quantity that has bounds, in SI; None: none on that side."""

    column: str
    hazard: str
    unit: str
    low: float | None
    high: float | None
    only_safe: bool


class _Told(TypedDict):
    """The part of ``truth.json`` that is drawn."""

    ended: float
    judged: list[_What]


class _Judged(NamedTuple):
    """A quantity that has bounds, and what it came to, shape (n,)."""

    what: _What
    values: "NDArray[np.float64]"


def draw_truth(run: RunData) -> "Figure | None":
    """Draw what has bounds, with them, from before the fault to the end; None: nobody kept it."""
    path = run.folder.path / TRUTH
    if not path.is_file():
        return None
    told = read_json(path.parent / TRUTH_COLUMNS, _Told)
    with np.load(path) as kept:
        if "judged" not in kept:
            return None
        t, judged = kept["t"], kept["judged"]
    events = [(event["kind"], event.get("t")) for event in read_events(run.folder.path)]
    broke = [at for kind, at in events if kind == "injected" and at is not None]
    part = t >= (min(broke) - _BEFORE if broke else t[0])
    rows = [_Judged(what, judged[part, k]) for k, what in enumerate(told["judged"])]
    panels: dict[tuple[str, ...], list[_Judged]] = {}
    for row in rows:
        shares = [r.what["column"] for r in rows if r.what["hazard"] == row.what["hazard"]]
        panels.setdefault((*shares, row.what["unit"]), []).append(row)
    figure = new_figure(PAGE, 18.0 + _PANEL * len(panels))
    for axes, of in zip(
        np.ravel(figure.subplots(len(panels), 1, sharex=True)), panels.values(), strict=True
    ):
        _draw_panel(axes, t[part], of, told["ended"])
        for kind, at in events:
            if at is not None and kind in _MARKED and t[part][0] <= at <= t[part][-1]:
                axes.axvline(
                    at, color=_MARKED[kind], lw=0.7, ls="--" if kind == "injected" else "-"
                )
        axes.axvline(told["ended"], color=GREY, lw=0.7, ls=":")
    axes.set_xlabel("time of the log's clock (s)")
    axes.set_xlim(float(t[part][0]), float(t[part][-1]))
    return figure


def _draw_panel(axes: "Axes", t: "NDArray[np.float64]", rows: list[_Judged], ended: float) -> None:
    """Draw the columns of one panel, and every bound that they have."""
    factor, unit = _SCALES.get(rows[0].what["unit"], (1.0, rows[0].what["unit"]))
    columns = {row.what["column"]: row.values for row in rows}
    for (name, values), color in zip(columns.items(), PALETTE * len(columns), strict=False):
        draw_line(axes, t, factor * values, color, name)
    reach = factor * max(float(np.nanmax(np.abs(row.values))) for row in rows)
    # Columns of one hazard share its bounds.
    for what in {row.what["hazard"]: row.what for row in rows}.values():
        start = ended if what["only_safe"] else float(t[0])
        for bound in (what["low"], what["high"]):
            if bound is not None and abs(factor * bound) < 1.5 * reach:
                level = factor * bound
                axes.plot([start, float(t[-1])], [level, level], color=GREY, lw=0.8, ls="--")
    axes.set_ylabel(f"{rows[0].what['hazard']} ({unit})")
    if len(columns) > 1:
        axes.legend(ncols=4, frameon=False, fontsize=6)


TRUTH_FIGURES = {
    "truth": FigureKind(
        draw_truth,
        "What was true of the simulated rig, from before it was broken until after its program had "
        "ended (dotted). Grey dashes are the limits with their margins; red dashes say when it "
        "broke, black lines when the program said so, and red lines when a hazard began.",
    )
}
