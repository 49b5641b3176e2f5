"""An arm's laws on the same twists: how much of them each does, and what it adds to them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.experiment.metrics import Evaluation, facts_from_json
from rig.report.comparison import Comparison, ComparisonRow
from rig.report.cost_bars import Cost, draw_cost
from rig.report.data import RunData
from rig.report.envelope import envelope
from rig.report.figure import TIME_LABEL, halves
from rig.report.style import BLUE, INK, PAGE, VERMILION, new_figure
from rig.run_facts import EVALUATION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_REACH = 1.0
"""m: a turn of 1 rad counts as much as so long a way."""
_MARK = "standing_share"
"""A number that only twists have."""


class _Entry(NamedTuple):
    """A row of the table, and the panel of bars that shows it, if any."""

    fact: str
    unit: str
    cost: Cost | None = None


_ENTRIES = (
    _Entry("off_direction", "m", Cost("off the direction (mm)", 1e3, 1e-3)),
    _Entry("turned_off", "rad", Cost("tool turned off (mrad)", 1e3, 1e-3)),
    _Entry("peak_rate_share", "", Cost("peak rate over its limit", 1.0, 1e-2, 1.0)),
    _Entry("peak_acceleration_share", ""),
    _Entry("rate_jump", "", Cost("rate jump in 1 ms over the limit", 1.0, 1e-3, 0.2)),
    _Entry("lag", "s", Cost("late at the end (s)", 1.0, 0.0, linear=True)),
    _Entry("standing_share", ""),
    _Entry("distance_asked", "m"),
    _Entry("distance", "m"),
    _Entry("distance_share", "", Cost("share of the way done", 1.0, 0.0, 1.0, linear=True)),
    _Entry("closest_wrist", ""),
    _Entry("closest_shoulder", "m"),
    _Entry("closest_elbow", ""),
)


def tabulate_twists(runs: Sequence[RunData], labels: Sequence[str]) -> list[ComparisonRow]:
    """Return the table: what is known of the commanded motion."""
    del labels
    facts = [_known(run) for run in runs]
    return [
        {
            "name": entry.fact,
            "unit": entry.unit,
            "bound": None,
            "bound_kind": None,
            "values": [_value(known, entry.fact) for known in facts],
        }
        for entry in _ENTRIES
        if any(entry.fact in known for known in facts)
    ]


def draw_twists(runs: Sequence[RunData], labels: Sequence[str]) -> "Figure":
    """Draw how much of the twists each law does and what it does beside them, over time."""
    figure = new_figure(PAGE, 30.0 + 34.0 * max(len(runs), 3))
    over_time, costs = halves(figure, 1.6)
    panels = over_time.subplots(len(runs), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    for axes, run, label in zip(panels, runs, labels, strict=True):
        _draw_shares(axes, run)
        axes.set_title(label, loc="left", pad=2.0)
    panels[0].set_xlim(0.0, max(float(run.time[-1]) for run in runs))
    panels[0].set_ylim(-0.1, 1.3)
    panels[-1].set_xlabel(TIME_LABEL)
    over_time.supylabel("twist of the hand over the one asked for", fontsize=8.5)
    panels[0].legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.16), ncols=3, frameon=False, borderaxespad=0.0
    )
    facts = [_known(run) for run in runs]
    drawn = [
        entry
        for entry in _ENTRIES
        if entry.cost is not None and any(entry.fact in known for known in facts)
    ]
    for axes, entry in zip(costs.subplots(len(drawn), 1), drawn, strict=True):
        assert entry.cost is not None
        values = [known.get(entry.fact, np.nan) for known in facts]
        draw_cost(axes, entry.cost, np.array(values, float), labels, [""] * len(runs))
    return figure


def _draw_shares(axes: "Axes", run: RunData) -> None:
    """Draw what is done along the twist and beside it, as shares of it."""
    t, asked, done = run.time, _twist(run, "plan.asked_"), _twist(run, "plan.twist_")
    square = (asked**2).sum(axis=1)
    is_asked = square > 0.0
    whole = np.where(is_asked, square, 1.0)
    along = np.where(is_asked, (asked * done).sum(axis=1) / whole, np.nan)
    beside = done - np.nan_to_num(along)[:, None] * asked
    share = np.where(is_asked, np.linalg.norm(beside, axis=1) / np.sqrt(whole), np.nan)
    axes.axhline(1.0, color=INK, lw=0.7, ls=(0, (4, 2)), label="asked for")
    axes.plot(*envelope(t, along), color=BLUE, lw=0.9, label="along it")
    axes.plot(*envelope(t, share), color=VERMILION, lw=0.9, label="beside it")


def _twist(run: RunData, of: str) -> "NDArray[np.float64]":
    """Return a twist of the plan, shape (n, 6); turning as the way at `_REACH`."""
    parts = [run.trace(f"{of}{kind}{axis}") for kind in "vw" for axis in "xyz"]
    scale = np.repeat([1.0, _REACH], 3)
    return np.asarray(np.column_stack(parts) * scale)


def _known(run: RunData) -> dict[str, float]:
    """Return what is known of twists beforehand, or what was measured of those that were heard."""
    facts = facts_from_json(run.folder.read_json(EVALUATION, Evaluation))
    measured = {m["name"]: m["value"] for m in run.metrics if m["value"] is not None}
    return {**measured, **{name: fact.value for name, fact in facts.items()}}


def _value(known: dict[str, float], name: str) -> float | None:
    value = known.get(name, np.nan)
    return value if np.isfinite(value) else None


def _follows_twists(run: RunData) -> bool:
    return run.has("plan.asked_vx", "plan.twist_vx") and _MARK in _known(run)


TWIST_COMPARISON = Comparison(_follows_twists, draw_twists, tabulate_twists)
