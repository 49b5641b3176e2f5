"""What came of a case, and whether that is what had to come of it."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from math import inf

from rig.faults.case import Case, Moment
from rig.faults.kind import Must
from rig.faults.oracle import Violation
from rig.faults.subject import Subject

OK, MISSED, REFUSED, FAULTED, OURS, INTERRUPTED = 0, 1, 3, 4, 70, 130
"""Exit codes of a run."""
_CONTROLLED = (Moment.ENERGISE, Moment.APPROACH, Moment.RUN)
"""Phases in which what breaks must be seen; a procedure widens what rests on what it looks for."""
_FELT = (0.0, 0.0)
"""Of a case that has not been performed: each of its faults will be felt."""


class CameTo(StrEnum):
    """The sum of a verdict."""

    WRONG = "wrong"
    """Something was wrong."""
    SEEN = "seen"
    """The program said that something is wrong, or died of it, and nobody was in danger."""
    RIDDEN = "ridden out"
    """The run went on as if nothing had been, as it had to."""
    EXCUSED = "excused"
    """It was not seen, or a hazard became true, and the reason for which that counts is stated."""


@dataclass(frozen=True, slots=True)
class CaseEnding:
    """The end of the program, as it was told and as it was.

    Parameters
    ----------
    code : int or None
        Its exit code; None if it was killed.
    message : str
        What the operator was told.
    broke_at : float or None
        When the first fault happened, s; None if the run had ended before.
    seen_at : float or None
        When the program said that there is a fault, s.
    violations : tuple of Violation
        Hazards that became true.
    felt_at : tuple of (float or None)
        When each fault that happened could first be seen, s; None if it never could. See `Felt`.
    since : str
        What all these times are counted from.
    excused : tuple of Violation
        Hazards that became true and that nothing could have kept off.
    """

    code: int | None
    message: str
    broke_at: float | None
    seen_at: float | None
    violations: tuple[Violation, ...] = ()
    felt_at: tuple[float | None, ...] = ()
    since: str = ""
    excused: tuple[Violation, ...] = ()

    @property
    def clock(self) -> str:
        """The clock of its times, in words, and when the first fault came by it."""
        at = "" if self.broke_at is None else f", the fault at {self.broke_at:.3f} s"
        return f" (since {self.since}{at})" if self.since else ""

    @property
    def is_tripped(self) -> bool:
        """Whether the program said that something is wrong."""
        return self.code in (REFUSED, FAULTED, OURS)

    @property
    def is_seen(self) -> bool:
        """Whether it did, or died of it."""
        return self.is_tripped or self.code is None

    @property
    def reaction(self) -> float | None:
        """From the fault to the first safe setpoint, s."""
        if self.broke_at is None or self.seen_at is None:
            return None
        return max(0.0, self.seen_at - self.broke_at)


@dataclass(frozen=True, slots=True)
class Verdict:
    """A case, how it ended, and what is wrong about that.

    Parameters
    ----------
    case, ending
        As run.
    must : Must
        What had to come of it.
    wanted : float
        How soon it had to be seen, if it had to, s.
    hazard, unseen, misnamed, false_trip, late, crashed, never : bool
        What is wrong; all False if nothing is. A case that gave no verdict of its own crashed. The
        moment of a fault that did not happen never came: the case tells nothing of the rig.
    folder : str
        The run folder, where it was kept.
    since : float or None
        When what had to be seen broke, s: of two faults it may be the second.
    """

    case: Case
    ending: CaseEnding
    must: Must
    wanted: float
    hazard: bool = False
    unseen: bool = False
    misnamed: bool = False
    false_trip: bool = False
    late: bool = False
    crashed: bool = False
    never: bool = False
    folder: str = ""
    period: float = 1e-3
    since: float | None = None

    def broken(self, why: str) -> "Verdict":
        """Return this verdict as that of a case that did not work, and why."""
        return replace(self, crashed=True, ending=replace(self.ending, message=why))

    def missed(self) -> "Verdict":
        """Return this verdict as that of a case with a fault whose moment never came."""
        return replace(self, never=True)

    @property
    def outcome(self) -> CameTo:
        """The sum of it."""
        if self.failed:
            return CameTo.WRONG
        if self.ending.excused:
            return CameTo.EXCUSED
        if self.ending.is_seen:
            return CameTo.SEEN
        return CameTo.RIDDEN if self.must is Must.RIDE else CameTo.EXCUSED

    @property
    def failed(self) -> bool:
        """Whether anything is wrong."""
        return any(True for _ in self.wrongs())

    @property
    def reaction(self) -> float | None:
        """From the fault that had to be seen to the first safe setpoint, s; None: there is none."""
        seen_at = self.ending.seen_at
        if self.since is None or seen_at is None:
            return None
        return max(0.0, seen_at - self.since)

    @property
    def exit_code(self) -> int:
        """The exit code of the case alone: 1 after a hazard, 2 if its moment never came."""
        return 1 if self.hazard or self.crashed else 2 if self.never else 0

    def wrongs(self) -> Iterator[str]:
        """Yield what is wrong, a sentence each."""
        if self.crashed:
            yield self.ending.message
        if self.never:
            yield f"never happened: {self.case.awaited}; it was all over before"
        if self.hazard:
            yield f"hazard: {'; '.join(map(str, self.ending.violations))}{self.ending.clock}"
        if self.unseen:
            yield f"unseen: the run ended with {self.ending.code} as if nothing were wrong"
        if self.false_trip:
            yield f"false trip: {self.ending.message}"
        if self.misnamed:
            yield f"misnamed: {self.ending.message}"
        if self.late:
            reaction = self.ending.reaction or 0.0
            yield f"late: seen after {1e3 * reaction:.0f} ms, {1e3 * self.wanted:.0f} ms wanted"

    def uncounted(self) -> Iterator[str]:
        """Yield the hazards that nothing could have kept off, a sentence each."""
        broke_at = self.ending.broke_at
        for violation in self.ending.excused:
            after = (
                ""
                if broke_at is None
                else f", {1e3 * (violation.t - broke_at):.0f} ms after it broke"
            )
            yield f"{violation}{after}"

    def as_json(self) -> dict[str, object]:
        """Return it as plain data, with what is wrong in words."""
        hazards = {
            "violations": [violation._asdict() for violation in self.ending.violations],
            "excused": [violation._asdict() for violation in self.ending.excused],
        }
        return asdict(self) | {
            "case": self.case.as_json(),
            "ending": asdict(self.ending) | hazards,
            "outcome": self.outcome,
            "wrongs": list(self.wrongs()),
            "again": self.case.command,
        }


def give_verdict(case: Case, ending: CaseEnding, subject: Subject) -> Verdict:
    """Compare what came of a case with what had to."""
    must, wanted = what_must_come(case, subject, ending.felt_at), how_soon(case, ending, subject)
    tripped, seen = ending.is_tripped, ending.is_seen
    happened = ending.broke_at is not None
    stopping = case.moment in (Moment.RELEASE, Moment.STOP)  # then it is made safe anyway
    named = not happened or _is_named(case, ending, subject)
    reaction = ending.reaction
    late = (
        must is Must.SAFE
        and reaction is not None
        and case.moment in _CONTROLLED
        and reaction > wanted
    )
    return Verdict(
        case,
        ending,
        must,
        wanted,
        hazard=bool(ending.violations),
        unseen=happened and must is Must.SAFE and not seen,
        misnamed=tripped and must is not Must.RIDE and not stopping and not named,
        false_trip=tripped and (must is Must.RIDE or not happened),
        late=late,
        # An exception of ours says nothing of a fault, but where the law itself raised one.
        crashed=ending.code == OURS and not any(item.row.spoils_law for item in case.breaks),
        period=subject.period,
        since=_since(case, ending, subject),
    )


def _since(case: Case, ending: CaseEnding, subject: Subject) -> float | None:
    """Return when what had to be seen broke, s; None: nothing did."""
    first, then = case.first, case.then
    if ending.broke_at is None or then is None:
        return ending.broke_at
    second = ending.broke_at + case.then_after
    musts = [item.row.must(item.sizes, subject) is Must.SAFE for item in (first, then)]
    if musts == [False, True] and ending.seen_at is not None and ending.seen_at >= second:
        return second
    return ending.broke_at


def what_must_come(case: Case, subject: Subject, felt_at: Sequence[float | None] = ()) -> Must:
    """Return what must come of a case's first fault in its phase; a second one excuses none.

    What was never felt need not be seen: a law that was spoilt and that nobody followed any more
    (drives brake by themselves), setpoints that were lost while all of them stood.
    """
    # Drives that are being enabled are told where they stand, again and again.
    rests = case.moment is Moment.ENERGISE and not subject.has_pressure
    musts = [
        Must.EITHER
        if felt is None or (rests and item.row.in_setpoints)
        else item.row.must(item.sizes, subject)
        for item, felt in zip(case.breaks, (*felt_at, *_FELT), strict=False)
    ]
    if case.moment is Moment.CONNECT and case.first.kind != "nothing":
        return Must.EITHER  # it may be refused, or be past before anybody looks
    if Must.SAFE in musts:
        # While it connects or is made safe anyway, what breaks need not be told apart.
        return Must.SAFE if case.moment in _CONTROLLED and not _is_stopping(case) else Must.EITHER
    return Must.EITHER if Must.EITHER in musts else Must.RIDE


def _is_stopping(case: Case) -> bool:
    """Return whether Ctrl-C came before the fault, or made it safe at once before it was seen."""
    if case.first.kind in ("interrupted", "interrupted_twice"):
        return True
    ends = case.then is not None and case.then.kind == "interrupted_twice"
    return ends and case.then_after < case.first.row.within


def how_soon(case: Case, ending: CaseEnding, subject: Subject) -> float:
    """Return how long after the first fault the rig must be made safe at the latest, s.

    Each of two faults that must be seen has its own time, which begins when it is first felt, or
    when the program is no longer stalled by the other one.
    """
    if ending.broke_at is None:
        return inf
    fills = case.moment is Moment.ENERGISE
    felt = [(at, item) for at, item in zip(ending.felt_at, case.breaks, strict=False)
            if at is not None]  # fmt: skip
    stalls = [(at, at + (item.magnitude or 0.0)) for at, item in felt if item.row.stalls]

    def begins(at: float) -> float:
        return max([at, *(end for begin, end in stalls if begin < at < end)])

    return min(
        (
            begins(at) - ending.broke_at + max(item.row.within, item.row.filling if fills else 0.0)
            for at, item in felt
            if item.row.must(item.sizes, subject) is Must.SAFE
        ),
        default=inf,
    )


def _is_named(case: Case, ending: CaseEnding, subject: Subject) -> bool:
    said = ending.message.lower()
    words = [name for item in case.breaks for name in item.place(subject).names]
    # A name may go on (wire, wires) but not begin within another one (agonist, antagonist).
    return any(re.search(rf"(?<!\w){re.escape(word.lower())}", said) for word in words)
