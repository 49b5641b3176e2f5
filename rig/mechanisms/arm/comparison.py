"""An arm's laws on one path: the rates they ask for, and where each of them loses."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.experiment.metrics import Evaluation, facts_from_json
from rig.hal.motion import Fact
from rig.mechanisms.arm.figures import JOINTS
from rig.mechanisms.arm.singular_band import mark_region
from rig.report.comparison import Comparison, ComparisonRow
from rig.report.cost_bars import Cost, draw_cost
from rig.report.data import RunData
from rig.report.envelope import envelope
from rig.report.figure import TIME_LABEL, halves
from rig.report.style import PAGE, PALETTE, VERMILION, new_figure
from rig.run_facts import EVALUATION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_OUTCOMES = ("done", "halts", "stalls")
_SHOWN, _ROOM = 2.4, 1.15
"""Rates are drawn up to so many times the limit, or the greatest of them."""
_SINGULARITIES = ("elbow", "shoulder", "wrist")


class _Row(NamedTuple):
    """A row of the table that is a fact.

    Parameters
    ----------
    name, fact, unit : str
        In the table; of the run; SI unit.
    """

    name: str
    fact: str
    unit: str


_ROWS = (
    *(_Row(f"peak_rate_{joint}", f"peak_rate_{joint}", "rad/s") for joint in JOINTS),
    _Row("peak_acceleration", "peak_acceleration", "rad/s^2"),
    _Row("end_acceleration_share", "end_acceleration_share", ""),
    _Row("path_deviation", "path_deviation", "m"),
    _Row("closest_boundary", "closest_boundary", "m"),
    _Row("closest_shoulder (c)", "closest_shoulder", "m"),
    _Row("closest_wrist (S5)", "closest_wrist", ""),
    _Row("time_crossing", "time_crossing", "s"),
    _Row("time_end", "time_end", "s"),
    _Row("time_over_optimum", "time_over_optimum", ""),
)


def tabulate_laws(runs: Sequence[RunData], labels: Sequence[str]) -> list[ComparisonRow]:
    """Return the table: facts of the commanded motion, what is measured, and how each law ends."""
    del labels
    facts = [_facts(run) for run in runs]
    rows = [
        _as_row(row.name, row.unit, [_value(known, row.fact) for known in facts]) for row in _ROWS
    ]
    if all("peak_torque_share" in known for known in facts):  # the profile says the drives' limits
        torques = [_value(known, "peak_torque_share") for known in facts]
        rows.insert(len(JOINTS) + 1, _as_row("peak_torque_share", "", torques))
    measured = [_metric(run, "path_deviation_measured") for run in runs]
    place = next(k for k, row in enumerate(rows) if row["name"] == "path_deviation")
    rows.insert(place + 1, _as_row("path_deviation_measured", "m", measured))
    crosses = [_crossed(known) for known in facts]
    ends = [_outcome(known) for known in facts]
    rows.append({**_as_row("crosses", "", crosses), "refused": None})
    rows.append({**_as_row("ends", "", ends), "refused": "refuses"})
    return rows


def draw_laws(runs: Sequence[RunData], labels: Sequence[str]) -> "Figure":
    """Draw each law's rates over time, as shares of the limits, beside what the law costs."""
    figure = new_figure(PAGE, 24.0 + 23.0 * max(len(runs), 4))
    over_time, costs = halves(figure, 1.6)
    panels = over_time.subplots(len(runs), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    facts = [_facts(run) for run in runs]
    for axes, run, label, known in zip(panels, runs, labels, facts, strict=True):
        _draw_rates(axes, run)
        axes.set_title(f"{label}: {_in_words(known)}", loc="left", pad=2.0)
    panels[0].set_xlim(0.0, max(float(run.time[-1]) for run in runs))
    panels[-1].set_xlabel(TIME_LABEL)
    over_time.supylabel("joint rate over its limit", fontsize=8.5)
    panels[0].legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.16), ncols=7, frameon=False, borderaxespad=0.0
    )
    limits = runs[0].settings["geometry"]["rate_limits"]
    shares = [
        max(known[f"peak_rate_{j}"].value / limit for j, limit in zip(JOINTS, limits, strict=True))
        for known in facts
    ]
    shown = min(_SHOWN, _ROOM * max(shares))
    panels[0].set_ylim(-shown, shown)
    ends = [_outcome(known) for known in facts]
    whole = ["" if end == "done" else end for end in ends]
    nearest, approaches = _closest(runs, facts)
    panels_of_costs: list[tuple[Cost, list[float], list[str]]] = [
        (Cost("peak rate over its limit", 1.0, 1e-2, 1.0), shares, [""] * len(runs)),
        (
            Cost("off the path (mm)", 1e3, 1e-3),
            [known["path_deviation"].value for known in facts],
            [""] * len(runs),
        ),
        (
            Cost("off the path, measured (mm)", 1e3, 1e-3, 1.0),
            [_metric(run, "path_deviation_measured") or np.nan for run in runs],
            [""] * len(runs),
        ),
        (nearest, approaches, [""] * len(runs)),
        (
            Cost("time over the least one", 1.0, 0.0, 1.0, linear=True),
            [known["time_over_optimum"].value for known in facts],
            whole,
        ),
    ]
    for axes, (cost, values, texts) in zip(
        costs.subplots(len(panels_of_costs), 1), panels_of_costs, strict=True
    ):
        draw_cost(axes, cost, np.array(values, float), labels, texts)
    return figure


def _draw_rates(axes: "Axes", run: RunData) -> None:
    t = run.time
    for bound, label in ((-1.0, "_"), (1.0, "limit")):
        axes.axhline(bound, color=VERMILION, lw=0.8, ls=(0, (5, 2)), label=label)
    limits = run.settings["geometry"]["rate_limits"]
    for joint, limit, color in zip(JOINTS, limits, PALETTE, strict=True):
        rate = run.trace(f"command.velocity_{joint}")
        axes.plot(*envelope(t, rate / limit), color=color, lw=0.8, label=joint)
    mark_region(axes, run)


def _facts(run: RunData) -> dict[str, Fact]:
    return facts_from_json(run.folder.read_json(EVALUATION, Evaluation))


def _value(facts: dict[str, Fact], name: str) -> float | None:
    value = facts[name].value
    return value if np.isfinite(value) else None


def _metric(run: RunData, name: str) -> float | None:
    return next((m["value"] for m in run.metrics if m["name"] == name), None)


def _crossed(facts: dict[str, Fact]) -> str:
    crossed = [name for name in _SINGULARITIES if facts[f"crosses_{name}"].value]
    return " and ".join(crossed) or "no"


def _outcome(facts: dict[str, Fact]) -> str:
    return _OUTCOMES[round(facts["outcome"].value)]


def _in_words(facts: dict[str, Fact]) -> str:
    """Return what became of the motion."""
    outcome, crossed = _outcome(facts), _crossed(facts)
    text = outcome if outcome != "done" else f"{facts['time_end'].value:.2f} s"
    return text if crossed == "no" else f"{text}, crosses the singularity of the {crossed}"


def _closest(runs: Sequence[RunData], facts: Sequence[dict[str, Fact]]) -> tuple[Cost, list[float]]:
    """Return how near each law comes to the singularity that the path is about."""
    geometry = runs[0].settings["geometry"]
    reach = geometry["a2"] + geometry["a3"]
    offered = (
        ("closest_boundary", reach, Cost("closest to the boundary (mm)", 1e3, 1e-2)),
        ("closest_shoulder", reach, Cost("closest to the axis of q1, |c| (mm)", 1e3, 1e-2)),
        ("closest_wrist", 1.0, Cost("closest to the wrist's, |sin q5|", 1.0, 1e-5)),
    )
    name, _, cost = min(
        offered, key=lambda entry: min(known[entry[0]].value for known in facts) / entry[1]
    )
    return cost, [known[name].value for known in facts]


def _as_row(name: str, unit: str, values: Sequence[float | str | None]) -> ComparisonRow:
    return {"name": name, "unit": unit, "bound": None, "bound_kind": None, "values": list(values)}


def _follows_a_path(run: RunData) -> bool:
    """Return whether a law has planned it: of twists that are heard nothing is known before."""
    return run.has("plan.index_elbow", "command.velocity_q1") and "peak_rate_q1" in _facts(run)


ARM_COMPARISON = Comparison(_follows_a_path, draw_laws, tabulate_laws)
