"""The reaction table of a campaign: a row for each fault on each rig."""

from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rig.faults.verdict import Verdict


class Row(NamedTuple):
    """The outcomes of one fault on one rig.

    Parameters
    ----------
    fault, rig : str
        Of the row.
    n : int
        Cases.
    hazards, unseen, misnamed, false_trips, late, crashed : int
        How many went wrong, and how.
    stopped : int
        How many the program stopped because of a fault that it saw.
    reactions : tuple of float
        Median, 99th percentile and greatest time from the fault to the first safe setpoint, s;
        empty if it never stopped.
    period : float
        Of the rig's loop, s.
    """

    fault: str
    rig: str
    n: int
    hazards: int
    unseen: int
    misnamed: int
    false_trips: int
    late: int
    crashed: int
    stopped: int
    reactions: tuple[float, ...]
    period: float

    def cells(self) -> tuple[str, ...]:
        """Return it as text."""
        times = [f"{1e3 * value:.3g}" for value in self.reactions] or ["-"] * 3
        cycles = [f"{value / self.period:.0f}" for value in self.reactions] or ["-"] * 3
        wrong = (
            self.hazards, self.unseen, self.misnamed, self.false_trips, self.late, self.crashed
        )  # fmt: skip
        return (
            self.fault, self.rig, str(self.n), *map(str, wrong), str(self.stopped),
            "/".join(cycles), "/".join(times),
        )  # fmt: skip


HEADER = (
    "fault", "rig", "n", "hazards", "unseen", "misnamed", "false trips", "late", "crashed",
    "stopped", "cycles p50/p99/max", "ms p50/p99/max",
)  # fmt: skip


def make_rows(verdicts: Sequence[Verdict]) -> list[Row]:
    """Return the table's rows, in the order in which faults and rigs first came."""
    groups: dict[tuple[str, str], list[Verdict]] = defaultdict(list)
    for verdict in verdicts:
        fault = "+".join(item.kind for item in verdict.case.breaks)
        groups[fault if len(verdict.case.breaks) == 1 else "two at once", verdict.case.rig].append(
            verdict
        )
    return [make_row(fault, rig, group) for (fault, rig), group in groups.items()]


def make_row(fault: str, rig: str, verdicts: Sequence[Verdict]) -> Row:
    """Return one row: what came of these cases."""
    times = [v.ending.reaction for v in verdicts if v.ending.reaction is not None]
    reactions = tuple(float(x) for x in np.percentile(times, (50, 99, 100))) if times else ()
    return Row(
        fault, rig, len(verdicts),
        hazards=sum(v.hazard for v in verdicts),
        unseen=sum(v.unseen for v in verdicts),
        misnamed=sum(v.misnamed for v in verdicts),
        false_trips=sum(v.false_trip for v in verdicts),
        late=sum(v.late for v in verdicts),
        crashed=sum(v.crashed for v in verdicts),
        stopped=len(times),
        reactions=reactions,
        period=verdicts[0].period,
    )  # fmt: skip
