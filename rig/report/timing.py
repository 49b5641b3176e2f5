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
    return log.rows > 0 and all(f"timing.{name}" in log for name in (*STAGES, "slack", "lateness"))


def work_times(log: "LogColumns") -> "NDArray[np.float64]":
    """Return how long all stages of each cycle took, s, shape (n,)."""
    work, end = np.empty_like(log.t), 0
    for stages in zip(*(log.pieces(f"timing.{stage}") for stage in STAGES), strict=True):
        start, end = end, end + len(stages[0])
        work[start:end] = np.column_stack(stages).sum(axis=1)
    return work


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
    work = work_times(log)
    period = float(np.median(work + log.column("timing.slack")))
    total = float(work.sum())
    worst = _longest(work)
    stages: dict[str, StageTime] = {}
    delays = np.empty((len(worst), len(STAGES)))
    for number, stage in enumerate(STAGES):  # no more than one is in memory
        times = log.column(f"timing.{stage}")
        delays[:, number] = times[worst] - np.median(times)
        share = float(times.sum()) / total if total > 0.0 else 0.0
        stages[stage] = {**_spread(times), "share": share}
    cycle, t, lateness = log.cycle, log.t, log.column("timing.lateness")
    return {
        "period": period,
        "cycles": log.rows,
        "missed": int(np.maximum(np.diff(cycle.astype(np.int64)) - 1, 0).sum()),
        "overruns": int(np.count_nonzero(work > period)),
        "work": _spread(work),
        "lateness": _spread(lateness),
        "stages": stages,
        "worst": [
            {
                "cycle": int(cycle[index]),
                "t": float(t[index]),
                "work": float(work[index]),
                "lateness": float(lateness[index]),
                "blame": STAGES[int(np.argmax(delay))],
            }
            for index, delay in zip(worst.tolist(), delays, strict=True)
        ],
    }


def _longest(work: "NDArray[np.float64]") -> "NDArray[np.intp]":
    """Return which cycles took longest, the longest first, of equal ones the earlier."""
    least = np.partition(work, -WORST)[-WORST] if len(work) > WORST else -np.inf
    found = np.flatnonzero(work >= least)
    return found[np.argsort(-work[found], kind="stable")][:WORST]


def _spread(values: "NDArray[np.float64]") -> Spread:
    p50, p99 = np.percentile(values, [50.0, 99.0])
    return {"p50": float(p50), "p99": float(p99), "max": float(values.max())}
