"""Summarise the times of the cycle's stages."""

from typing import TYPE_CHECKING, NotRequired, TypedDict

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rig.runtime.log_columns import LogColumns

STAGES = ("receive", "read", "control", "transmit", "record")
"""Stages of the cycle, as in the log's columns ``timing.*``."""
WORST = 10
"""How many of the longest cycles are listed."""


class Spread(TypedDict):
    """The distribution of a time over the cycles, s."""

    p50: float
    p99: float
    max: float


class StageTime(Spread):
    """The distribution of one stage's time, and its share of all work."""

    share: float


class LongCycle(TypedDict):
    """One of the longest cycles; times in s."""

    cycle: int
    t: float
    work: float
    lateness: float
    blame: str


class TimingSummary(TypedDict):
    """The content of ``timing.json``; ``took`` (s) and ``speed`` are of the run as a whole."""

    period: float
    cycles: int
    missed: int
    overruns: int
    work: Spread
    lateness: Spread
    stages: dict[str, StageTime]
    worst: list[LongCycle]
    took: NotRequired[float]
    speed: NotRequired[float]


class NoTiming(TypedDict):
    """The summary of a log without times."""


def has_timing(log: "LogColumns") -> bool:
    """Return whether the log holds the stages' times."""
    return len(log.t) > 0 and all(
        f"timing.{name}" in log for name in (*STAGES, "slack", "lateness")
    )


def stage_times(log: "LogColumns") -> "NDArray[np.float64]":
    """Return how long each stage took, s, shape (n, stages)."""
    return np.column_stack([log.column(f"timing.{stage}") for stage in STAGES])


def summarise_timing(log: "LogColumns") -> TimingSummary | NoTiming:
    """Summarise a run's timing for ``timing.json``; ``{}`` if the log has none.

    Returns
    -------
    TimingSummary
        ``period`` (s), ``cycles``, ``missed`` ticks, ``overruns`` (cycles with more work than a
        period), ``stages`` {name: p50, p99, max in s, share of all work}, ``work`` and
        ``lateness`` {p50, p99, max}, and ``worst``: the longest cycles, each with the stage
        that took most more than its usual time.
    """
    if not has_timing(log):
        return {}
    times = stage_times(log)
    work = times.sum(axis=1)
    period = float(np.median(work + log.column("timing.slack")))
    usual = np.median(times, axis=0)
    total = float(work.sum())
    worst = np.argsort(-work, kind="stable")[:WORST]
    return {
        "period": period,
        "cycles": len(log.t),
        "missed": int(np.maximum(np.diff(log.cycle.astype(np.int64)) - 1, 0).sum()),
        "overruns": int(np.count_nonzero(work > period)),
        "work": _spread(work),
        "lateness": _spread(log.column("timing.lateness")),
        "stages": {
            stage: {
                **_spread(times[:, number]),
                "share": float(times[:, number].sum()) / total if total > 0.0 else 0.0,
            }
            for number, stage in enumerate(STAGES)
        },
        "worst": [
            {
                "cycle": int(log.cycle[index]),
                "t": float(log.t[index]),
                "work": float(work[index]),
                "lateness": float(log.column("timing.lateness")[index]),
                "blame": STAGES[int(np.argmax(times[index] - usual))],
            }
            for index in worst
        ],
    }


def _spread(values: "NDArray[np.float64]") -> Spread:
    p50, p99 = np.percentile(values, [50.0, 99.0])
    return {"p50": float(p50), "p99": float(p99), "max": float(values.max())}
