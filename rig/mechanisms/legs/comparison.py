"""Walks under several laws: both knees' rates one above the other, and what each law costs."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rig.experiment.metrics import Evaluation, facts_from_json
from rig.mechanisms.legs.fact_kinds import LEGS_FACTS
from rig.mechanisms.legs.figures.base import COLORS, mark_phases
from rig.report.comparison import Comparison, ComparisonRow, metric_values, rows_of_metrics
from rig.report.cost_bars import Cost, draw_cost
from rig.report.data import RunData
from rig.report.envelope import envelope
from rig.report.figure import TIME_LABEL, halves
from rig.report.style import GREY, PAGE, new_figure, place_legend
from rig.run_facts import EVALUATION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


_COSTS = (
    ("peak_knee_rate", Cost("peak knee rate, at 1 kHz (rad/s)", 1.0, 1e-2)),
    ("rate_jump", Cost("greatest jump in 1 ms (rad/s)", 1.0, 1e-4)),
    ("path_deviation", Cost("off the path (mm)", 1e3, 1e-3)),
    ("leg_mismatch", Cost("legs disagree by (mm)", 1e3, 1e-3)),
    ("tilt", Cost("soles tilt by (mrad)", 1e3, 1e-3)),
    ("feet_astray_end", Cost("feet end off their prints by (mm)", 1e3, 1e-2)),
    ("tilt_max", Cost("waist tilts by (deg)", 180.0 / math.pi, 1e-2)),
    ("slip_max", Cost("feet slip by (mm)", 1e3, 1e-2)),
    ("knee_torque_max", Cost("greatest knee torque (N m)", 1.0, 1e-2)),
)
"""What is planned, and then what came of it; a figure has room for the first few."""
_PANELS = 5
_PLANNED = ("peak_knee_rate", "rate_jump", "path_deviation", "leg_mismatch", "tilt", "min_knee")
"""What laws differ in before a robot walks; told whatever an experiment measures."""
_SAME = 1e-6
"""Numbers that differ by less, of their size or of SI, say nothing of a law."""


def tabulate_walks(runs: Sequence[RunData], labels: Sequence[str]) -> list[ComparisonRow]:
    """Return what laws differ in by their plans, and what the experiment measures."""
    del labels
    measured = rows_of_metrics(runs)
    names = {row["name"].removesuffix(".min") for row in measured}
    planned: list[ComparisonRow] = []
    for name in _PLANNED:
        values = _planned_values(runs, name).tolist()
        if name in names or not _differ(values):
            continue
        unit = LEGS_FACTS[name].unit
        told = [value if math.isfinite(value) else None for value in values]
        planned.append(
            {"name": name, "unit": unit, "bound": None, "bound_kind": None, "values": [*told]}
        )
    return [*planned, *measured]


def _differ(values: Sequence[float]) -> bool:
    known = [value for value in values if math.isfinite(value)]
    return bool(known) and max(known) - min(known) > _SAME * max(1.0, *map(abs, known))


def draw_walks(runs: Sequence[RunData], labels: Sequence[str]) -> "Figure":
    """Draw the knee rates under each law, as the paper's Fig. 4, beside what the law costs.

    Each law has its own scale: the plain one's would hide all others.

    References
    ----------
    Kameta, Sekiguchi, Tsumaki and Nenchev, "Walking control around singularity using the SC
    approach", Fig. 4.
    """
    figure = new_figure(PAGE, 24.0 + 23.0 * max(len(runs), 4))
    walks, costs = halves(figure, 1.75)
    top = None
    panels = walks.subplots(len(runs), 1, sharex=True, squeeze=False)[:, 0]
    for axes, run, label in zip(panels, runs, labels, strict=True):
        top = top or axes
        _draw_rates(axes, run)
        most = float(np.abs(axes.dataLim.get_points()[:, 1]).max())
        axes.set_title(f"{label}: up to {most:.3g} rad/s as commanded", loc="left", pad=2.0)
    panels[-1].set_xlabel(TIME_LABEL)
    walks.supylabel("knee rate (rad/s), each law on its own scale", fontsize=8.5)
    place_legend(panels[0], 2)
    measured = [(name, metric_values(runs, name)) for name, _ in _COSTS]
    asked = {name: values for name, values in measured if np.isfinite(values).any()}
    planned = [(name, _planned_values(runs, name)) for name in _PLANNED if name not in asked]
    differ = [(name, values) for name, values in planned if _differ(values.tolist())]
    asked |= dict(differ[: max(_PANELS - len(asked), 0)])
    known = [(cost, asked[name]) for name, cost in _COSTS if name in asked][:_PANELS]
    if known:
        panels = costs.subplots(len(known), 1, squeeze=False)[:, 0]
        for axes, (cost, values) in zip(panels, known, strict=True):
            draw_cost(axes, cost, values, labels)
    return figure


def _planned_values(runs: Sequence[RunData], name: str) -> "NDArray[np.float64]":
    """Return what was known of each run beforehand, shape (n,)."""
    facts = [facts_from_json(run.folder.read_json(EVALUATION, Evaluation)) for run in runs]
    return np.array([known[name].value if name in known else np.nan for known in facts])


def _draw_rates(axes: "Axes", run: RunData) -> None:
    t = run.time
    axes.axhline(0.0, color=GREY, lw=0.5)
    for leg, color in COLORS.items():
        rate = run.trace(f"command.velocity_{leg}_knee")
        axes.plot(*envelope(t, rate), color=color, lw=0.7, label=f"{leg} knee")
    axes.set_xlim(float(t[0]), float(2.0 * t[-1] - t[-2]))
    axes.margins(y=0.12)
    mark_phases(axes, run)


LEGS_COMPARISON = Comparison(
    lambda run: run.has("command.velocity_right_knee", "command.velocity_left_knee"),
    draw_walks,
    tabulate_walks,
)
