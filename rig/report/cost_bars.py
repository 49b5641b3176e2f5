"""What each of several laws costs, as one bar a law."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.report.comparison import write_value
from rig.report.style import GREY, INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike


class Cost(NamedTuple):
    """A panel of bars on a logarithmic scale.

    Parameters
    ----------
    title : str
        With the unit.
    factor : float
        From SI to that unit.
    floor : float
        In that unit; less is written as less than that.
    bound : float, optional
        In that unit; drawn as a line.
    linear : bool
        On a linear scale instead.
    """

    title: str
    factor: float
    floor: float
    bound: float | None = None
    linear: bool = False


def draw_cost(
    axes: "Axes",
    cost: Cost,
    values: "ArrayLike",
    labels: Sequence[str],
    texts: Sequence[str] | None = None,
) -> None:
    """Draw a bar for each law, with its value or, where there is one, a text instead.

    Parameters
    ----------
    axes : Axes
        The panel.
    cost : Cost
        What it shows.
    values : array-like, shape (n,)
        SI; not finite where a law has none.
    labels, texts : sequence of str
        Of each law; an empty text stands for the value.
    """
    values = np.asarray(values, float)
    values = np.where(np.isfinite(values), values * cost.factor, np.nan)
    shown = np.maximum(values, cost.floor)
    lengths = np.where(values > cost.floor, shown, 0.0)
    axes.barh(range(len(values)), np.nan_to_num(lengths), 0.7, color=GREY)
    for row, (value, end, text) in enumerate(
        zip(values, shown, texts or [""] * len(values), strict=True)
    ):
        if text:
            write_value(axes, text, cost.floor, row)
        elif np.isfinite(value):
            small = "0" if value == 0.0 else f"< {cost.floor:g}"
            write_value(axes, f"{value:.3g}" if value > cost.floor else small, end, row)
    if cost.bound is not None:
        axes.axvline(cost.bound, color=INK, lw=0.8, ls=(0, (3, 1.5)))
    most = float(np.nanmax(shown)) if np.isfinite(shown).any() else 1.0
    if cost.linear:
        axes.set_xlim(left=0.0, right=1.25 * max(most, cost.bound or 0.0))
    else:
        # Limits first: where nothing is above the floor, there is nothing to scale to.
        axes.set_xlim(left=0.7 * cost.floor, right=max(6.0 * most, 3.0 * (cost.bound or 0.0)))
        axes.set_xscale("log")
    axes.set_yticks(range(len(values)), labels=labels)
    axes.tick_params(axis="y", labelsize=6.5, length=0)
    axes.invert_yaxis()
    axes.minorticks_off()
    axes.grid(axis="y", visible=False)
    axes.set_title(cost.title, loc="left", pad=2.0)
