"""Runs of one experiment side by side, drawn as befits the kind of rig."""

from collections.abc import Sequence

from rig.assembly import REGISTRY
from rig.report.comparison import Comparison
from rig.report.data import RunData
from rig.report.metric_bars import METRICS_COMPARISON


def comparison_of(runs: Sequence[RunData]) -> Comparison:
    """Return the first comparison that can draw all of the runs; bars of metrics can draw any."""
    mechanisms = {run.mechanism for run in runs}
    (mechanism,) = mechanisms if len(mechanisms) == 1 else (None,)
    kinds = (*REGISTRY.comparisons(mechanism, Comparison), METRICS_COMPARISON)
    return next(kind for kind in kinds if all(kind.suits(run) for run in runs))
