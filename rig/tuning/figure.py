"""One figure of a tuning: the search, the errors on every plant, and the margins."""

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rig.hal.closed_loop import SENSITIVITY, ClosedLoop
from rig.report.style import BLUE, GREY, INK, PAGE, VERMILION, new_figure, paper_style
from rig.tuning.verdict import EnsembleVerdict, is_told

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST_SHOWN = 4.0
"""Greatest sensitivity that is drawn where it is."""
_UNTOLD = 4.7
"""Where loops are drawn that were not told."""
_WIDEST_LABEL = 8
"""Letters of a line below the errors."""


def draw_tuning(
    path: Path, costs: Sequence[float], now: EnsembleVerdict, before: EnsembleVerdict
) -> tuple[Path, ...]:
    """Draw a tuning into files of a name, as png and svg; return them."""
    with paper_style():
        figure = new_figure(PAGE, 62.0)
        search, errors, margins = figure.subplots(1, 3, width_ratios=(1.0, 1.5, 1.0))
        search.plot(range(len(costs)), costs, color=BLUE)
        search.xaxis.get_major_locator().set_params(integer=True)
        search.set_xlabel("generation; a walk after the look of 0,\nmore plants in each part")
        search.set_ylabel("least cost")
        _draw_errors(errors, now, before)
        _draw_margins(margins, now, before)
        written = []
        for suffix in ("png", "svg"):
            written.append(path.with_suffix(f".{suffix}"))
            figure.savefig(written[-1], metadata={"Date": None} if suffix == "svg" else None)
    return tuple(written)


def _draw_errors(axes: "Axes", now: EnsembleVerdict, before: EnsembleVerdict) -> None:
    """Draw each plant's error of each stretch; the plant that is as told has a ring."""
    from matplotlib.ticker import LogLocator

    names = list(now.nominal.errors)
    for verdict, color, shift, label in ((before, GREY, -0.16, "before"), (now, BLUE, 0.16, "now")):
        for place, name in enumerate(names):
            values = [1e3 * trial.errors[name] for trial in verdict.trials if name in trial.errors]
            spread = shift + np.linspace(-0.1, 0.1, max(len(values), 1))
            axes.plot(place + spread[: len(values)], values, ".", ms=3.0, color=color,
                      label=label if place == 0 else None)  # fmt: skip
            if name in verdict.nominal.errors:
                told = 1e3 * verdict.nominal.errors[name]
                axes.plot(place + shift, told, "o", ms=5.0, mfc="none", color=INK, mew=0.7)
    labels = [textwrap.fill(name, _WIDEST_LABEL) for name in names]
    axes.set_xticks(range(len(names)), labels=labels)
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter("")
    axes.set_ylabel("error (mm rms), ring: as told")
    lost = [len(verdict.lost) for verdict in (before, now)]
    title = f"lost plants: {lost[0]} before, {lost[1]} now" if any(lost) else ""
    axes.legend(title=title, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)


def _draw_margins(axes: "Axes", now: EnsembleVerdict, before: EnsembleVerdict) -> None:
    for verdict, color in ((before, GREY), (now, BLUE)):
        sizes = sorted(_place(margin) for margin in verdict.margins)
        axes.step(sizes, np.arange(1, len(sizes) + 1) / len(sizes), color=color, where="post")
    axes.axvline(SENSITIVITY, color=VERMILION, lw=0.8, ls="--")
    most = f"{_MOST_SHOWN:g}: or more"
    if any(verdict.told < len(verdict.margins) for verdict in (before, now)):
        axes.set_xlim(1.0, _UNTOLD + 0.1)
        ticks = range(1, int(_MOST_SHOWN) + 1)
        axes.set_xticks([*ticks, _UNTOLD], labels=[*map(str, ticks), "not\ntold"])
        axes.axvspan(_MOST_SHOWN + 0.1, _UNTOLD + 0.1, color=GREY, alpha=0.15, lw=0.0)
    else:
        axes.set_xlim(1.0, 1.02 * _MOST_SHOWN)
    axes.set_xlabel(f"sensitivity ({most})\ndashed: at most {SENSITIVITY:g}")
    axes.set_ylabel("share of drawn plants")


def _place(margin: ClosedLoop) -> float:
    """Return where a loop is drawn: what is not told stands beside the greatest."""
    if not is_told(margin):
        return _UNTOLD
    return min(margin.sensitivity, _MOST_SHOWN) if margin.stable else _MOST_SHOWN
