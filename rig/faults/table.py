"""The reaction table of a campaign: a row for each fault on each rig, a column for each phase."""

from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rig.faults.case import Moment
from rig.faults.verdict import CameTo, Verdict

DOUBLE = "two at once"
SUM = "all"


class Row(NamedTuple):
    """The outcomes of one fault on one rig.

    Parameters
    ----------
    fault, rig : str
        Of the row.
    n : int
        Cases.
    phases : tuple of (int, int)
        For each `Moment`: the cases, and those of them that went wrong.
    passes : tuple of int
        How many of them were seen, ridden out, and excused.
    wrongs : tuple of int
        Hazards, unseen, misnamed, false trips, late, crashed, never happened.
    reactions : tuple of float
        Median, 99th percentile and greatest time from the fault to the first safe setpoint, s;
        empty if it never stopped the rig.
    period : float
        Of the rig's loop, s.
    """

    fault: str
    rig: str
    n: int
    phases: tuple[tuple[int, int], ...]
    passes: tuple[int, ...]
    wrongs: tuple[int, ...]
    reactions: tuple[float, ...]
    period: float

    def cells(self) -> tuple[str, ...]:
        """Return it as text."""
        phases = [f"{n}!{wrong}" if wrong else str(n) if n else "" for n, wrong in self.phases]
        reactions = self.reactions if len(set(self.reactions)) > 1 else self.reactions[:1]
        times = [f"{1e3 * value:.3g}" for value in reactions]
        cycles = [f"{value / self.period:.0f}" for value in reactions]
        return (
            self.fault, self.rig, str(self.n), *phases,
            *[str(count) if count else "" for count in (*self.passes, *self.wrongs)],
            "/".join(cycles), "/".join(times),
        )  # fmt: skip

    def as_json(self) -> dict[str, object]:
        """Return it as plain data, times in s."""
        return {
            "fault": self.fault,
            "rig": self.rig,
            "n": self.n,
            "phases": {m.value: list(p) for m, p in zip(Moment, self.phases, strict=True)},
            **dict(zip(PASSES, self.passes, strict=True)),
            **dict(zip(WRONGS, self.wrongs, strict=True)),
            "reactions": list(self.reactions),
            "period": self.period,
        }


PASSES = tuple(str(outcome) for outcome in CameTo if outcome is not CameTo.WRONG)
WRONGS = ("hazards", "unseen", "misnamed", "false trips", "late", "crashed", "never")
HEADER = (
    "fault", "rig", "n", *(moment.value for moment in Moment), *PASSES, *WRONGS,
    "cycles p50/p99/max", "ms p50/p99/max",
)  # fmt: skip


CASE_HEADER = ("fault", "rig", "where", "when", "came to", "ms", "what the rig said")


def used_columns(rows: Sequence[Row]) -> tuple[list[int], list[str]]:
    """Return the columns of `HEADER` that say something, and the names of the others."""
    cells = [row.cells() for row in rows]
    used = [k for k, name in enumerate(HEADER) if name in PASSES or any(row[k] for row in cells)]
    return used, [name for k, name in enumerate(HEADER) if k not in used]


def case_cells(verdict: Verdict) -> tuple[str, ...]:
    """Return one case as text: what broke, and what the rig said of it."""
    case, ending = verdict.case, verdict.ending
    reaction = "" if verdict.reaction is None else f"{1e3 * verdict.reaction:.3g}"
    where = " + ".join(item.where for item in case.breaks)
    said = ending.message or "nothing"
    return (
        " + ".join(case.kinds), case.rig, where, str(case.moment), str(verdict.outcome), reaction,
        said,
    )  # fmt: skip


def make_rows(verdicts: Sequence[Verdict]) -> list[Row]:
    """Return the table's rows, in the order in which faults first came, and their sums."""
    groups: dict[tuple[str, str], list[Verdict]] = defaultdict(list)
    for verdict in verdicts:
        kinds = verdict.case.kinds
        groups[kinds[0] if len(kinds) == 1 else DOUBLE, verdict.case.rig].append(verdict)
    faults = list(dict.fromkeys(fault for fault, _ in groups))
    ordered = sorted(groups.items(), key=lambda item: faults.index(item[0][0]))
    rows = [make_row(fault, rig, group) for (fault, rig), group in ordered]
    if len(rows) < 2:
        return rows
    rigs = dict.fromkeys(verdict.case.rig for verdict in verdicts)
    sums = [make_row(SUM, rig, [v for v in verdicts if v.case.rig == rig]) for rig in rigs]
    return [*rows, *sums, *([make_row(SUM, "", verdicts)] if len(rigs) > 1 else [])]


def make_row(fault: str, rig: str, verdicts: Sequence[Verdict]) -> Row:
    """Return one row: what came of these cases."""
    times = [v.reaction for v in verdicts if v.reaction is not None]
    in_phase = [[v for v in verdicts if v.case.moment is moment] for moment in Moment]
    return Row(
        fault, rig, len(verdicts),
        phases=tuple((len(some), sum(v.failed for v in some)) for some in in_phase),
        passes=tuple(sum(v.outcome == outcome for v in verdicts) for outcome in PASSES),
        wrongs=tuple(
            sum(flags)
            for flags in zip(*((v.hazard, v.unseen, v.misnamed, v.false_trip, v.late, v.crashed,
                                v.never) for v in verdicts), strict=True)
        ),
        reactions=tuple(float(x) for x in np.percentile(times, (50, 99, 100))) if times else (),
        period=verdicts[0].period,
    )  # fmt: skip
