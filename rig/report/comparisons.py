"""Runs of one experiment side by side, drawn as befits the kind of rig."""

from collections.abc import Sequence

from rig.mechanisms.arm.comparison import ARM_COMPARISON
from rig.mechanisms.cylinder.comparison import PAIR_COMPARISON
from rig.mechanisms.joint.comparison import JOINT_COMPARISON
from rig.mechanisms.legs.comparison import LEGS_COMPARISON
from rig.report.comparison import Comparison
from rig.report.data import RunData
from rig.report.metric_bars import METRICS_COMPARISON

COMPARISONS = (
    ARM_COMPARISON,
    LEGS_COMPARISON,
    JOINT_COMPARISON,
    PAIR_COMPARISON,
    METRICS_COMPARISON,
)
"""In the order in which they are tried; the last one can draw any runs."""


def comparison_of(runs: Sequence[RunData]) -> Comparison:
    """Return the first comparison that can draw all of the runs."""
    return next(kind for kind in COMPARISONS if all(kind.suits(run) for run in runs))
