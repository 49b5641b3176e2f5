"""Runs of one experiment side by side, drawn as befits the kind of rig."""

from collections.abc import Sequence

from rig.report.comparisons.arm import ARM_COMPARISON
from rig.report.comparisons.base import Comparison
from rig.report.comparisons.joint import JOINT_COMPARISON
from rig.report.comparisons.legs import LEGS_COMPARISON
from rig.report.comparisons.metrics import METRICS_COMPARISON
from rig.report.comparisons.pair import PAIR_COMPARISON
from rig.report.data import RunData

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
