"""The kinds of comparison, and what they share."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple, NotRequired, TypedDict

import numpy as np

from rig.report.data import RunData
from rig.report.style import PALETTE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


class ComparisonRow(TypedDict):
    """One number of every run, SI; None where a run has none.

    ``refused`` is what stands there for a controller that refused.
    """

    name: str
    unit: str
    bound: float | None
    bound_kind: str | None
    values: list[float | str | None]
    refused: NotRequired[str | None]


class Comparison(NamedTuple):
    """A way to draw several runs in one figure.

    Parameters
    ----------
    suits : callable
        Takes a run; whether its log holds what the figure shows.
    draw : callable
        Takes the runs and a label for each.
    tabulate : callable, optional
        Takes the same; its rows take the place of those of `compare_metrics`.
    """

    suits: Callable[[RunData], bool]
    draw: "Callable[[Sequence[RunData], Sequence[str]], Figure]"
    tabulate: Callable[[Sequence[RunData], Sequence[str]], list[ComparisonRow]] | None = None


def color_of(number: int) -> str:
    """Return the colour of the run with this number."""
    return PALETTE[number % len(PALETTE)]


def metric_values(runs: Sequence[RunData], name: str) -> "NDArray[np.float64]":
    """Return a metric of each run, shape (n,); not a number where a run has none."""
    values = []
    for run in runs:
        value = next((m["value"] for m in run.metrics if m["name"] == name), None)
        values.append(np.nan if value is None else value)
    return np.array(values, float)


def rows_of_metrics(runs: Sequence[RunData]) -> list[ComparisonRow]:
    """Return a row for each metric, in the order of the first run that has it."""
    rows: dict[str, ComparisonRow] = {}
    for number, run in enumerate(runs):
        for metric in run.metrics:
            row = rows.setdefault(
                metric["name"],
                {
                    "name": metric["name"],
                    "unit": metric["unit"],
                    "bound": metric.get("bound"),
                    "bound_kind": metric.get("bound_kind"),
                    "values": [None] * len(runs),
                },
            )
            row["values"][number] = metric["value"]
    # With two bounds a metric is there twice, but it is one number.
    return [
        row
        for name, row in rows.items()
        if not (name.endswith(".min") and name.removesuffix(".min") in rows)
    ]


def write_value(axes: "Axes", text: str, x: float, y: float) -> None:
    """Write a bar's value at its end."""
    axes.annotate(
        text, (x, y), (2.5, 0), textcoords="offset points", va="center", fontsize=6.5, zorder=4,
        bbox={"fc": "white", "ec": "none", "pad": 0.8},
    )  # fmt: skip
