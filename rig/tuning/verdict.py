"""What gains come to on the whole ensemble, on plants as fine as those that experiments run on."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from rig.config import format_quantity
from rig.hal.bench import Trial
from rig.hal.closed_loop import SENSITIVITY, ClosedLoop
from rig.tuning.ensemble import DRAWN, Member
from rig.tuning.score import QUIET, REVERSALS, score
from rig.tuning.workbench import Workbench

_AT_ONCE = 5
"""Of them are measured before somebody is told."""
_TOLD = 3
"""So many lost plants are told by name."""
ENOUGH = 0.99
"""Share of them whose loop must keep its distance from the critical point."""


class EnsembleVerdict(NamedTuple):
    """The outcome of gains on the whole ensemble.

    Parameters
    ----------
    gains : dict of str to float
        The gains.
    members : tuple of Member
        The corners of the ensemble, the nominal plant first.
    trials : tuple of Trial
        On each.
    margins : tuple of ClosedLoop
        On plants drawn from the ensemble.
    measured : bool
        Whether they were measured there; else they are a linear model's.
    cost : float
        What the search minimises.
    linear : ClosedLoop or None
        The linear model's, on the plant as told; None: nobody asked it.
    """

    gains: dict[str, float]
    members: tuple[Member, ...]
    trials: tuple[Trial, ...]
    margins: tuple[ClosedLoop, ...]
    cost: float
    measured: bool = False
    linear: ClosedLoop | None = None

    @property
    def lost(self) -> list[Member]:
        """The plants that were lost, or on which the program would have stopped."""
        both = zip(self.members, self.trials, strict=True)
        return [member for member, trial in both if trial.strayed >= 1.0]

    @property
    def losses(self) -> str:
        """The worst of them in words: the plant, and what became of it; empty: none was lost."""
        both = sorted(
            zip(self.members, self.trials, strict=True),
            key=lambda pair: (pair[1].lasted, -pair[1].strayed),
        )
        told = [
            f"{member.name or 'as told'} ({_fate(trial)})"
            for member, trial in both
            if trial.strayed >= 1.0
        ]
        return "; ".join(told[:_TOLD])

    @property
    def nominal(self) -> Trial:
        """What they did on the plant that is as told."""
        return self.trials[0]

    def worst(self, stretch: str) -> tuple[float, Member]:
        """Return the greatest error of a stretch of the motion, and on which plant it was."""
        errors = [trial.errors.get(stretch, np.inf) for trial in self.trials]
        number = int(np.argmax(errors))
        return float(errors[number]), self.members[number]

    @property
    def reversals(self) -> float:
        """The most reversals of a setpoint, 1/s."""
        return max(trial.reversals for trial in self.trials)

    @property
    def hunting(self) -> float:
        """The greatest motion in a hold, peak to peak, SI."""
        return max(trial.hunting for trial in self.trials)

    @property
    def robust(self) -> float:
        """Share of the drawn plants whose loop keeps its distance from the critical point."""
        return self.keeping / len(self.margins)

    @property
    def keeping(self) -> int:
        """How many of the drawn plants that are."""
        return sum(margin.stable and margin.sensitivity <= SENSITIVITY for margin in self.margins)

    @property
    def told(self) -> int:
        """How many of the drawn plants have a loop that is told: what is not may be anything."""
        return sum(is_told(margin) for margin in self.margins)


def is_told(margin: ClosedLoop) -> bool:
    """Return whether anything is known of a loop's distance; see `TuningBench.measured`."""
    return not margin.stable or math.isfinite(margin.sensitivity)


def _fate(trial: Trial) -> str:
    if trial.lasted < 1.0:
        return f"lost after {100 * trial.lasted:.0f} % of the motion"
    return f"{trial.strayed:.2g} times the error that stops the rig"


def _unheard(done: int) -> None:
    """Leave out how many plants are done."""


def plants_of(bench: Workbench, gains: Mapping[str, float]) -> int:
    """Return on how many plants `judge` runs gains: a linear model is asked without any."""
    drawn = 0 if bench.measured(gains, ()) is None else DRAWN
    return len(bench.ensemble.corners()) + drawn


def judge(
    bench: Workbench, gains: Mapping[str, float], tell: Callable[[int], None] = _unheard
) -> EnsembleVerdict:
    """Run gains on every corner of the ensemble, and look at the margins of drawn plants.

    Of those the few that may miss the bound cost nothing.

    Parameters
    ----------
    bench : Workbench
        Of the request.
    gains : mapping of str to float
        The gains.
    tell : callable
        Is told how many plants more are done.
    """
    members = tuple(bench.ensemble.corners())
    trials = []
    for member in members:
        trials.append(bench.trial(gains, member, coarse=False))
        tell(1)
    drawn = bench.ensemble.draw()
    measured = _measured(bench, gains, drawn, tell)
    linear, *margins = bench.margins(gains, [bench.ensemble.nominal, *(() if measured else drawn)])
    margins = measured or margins
    far = sorted(margins, key=lambda margin: margin.sensitivity)[: math.ceil(ENOUGH * len(margins))]
    cost = score(trials, far).cost
    kept = tuple(trials), tuple(margins)
    return EnsembleVerdict(dict(gains), members, *kept, cost, bool(measured), linear)


def _measured(
    bench: Workbench, gains: Mapping[str, float], drawn: Sequence[Member],
    tell: Callable[[int], None],
) -> list[ClosedLoop]:  # fmt: skip
    """Return the margins that are measured on drawn plants, a few at a time; empty: none are."""
    found: list[ClosedLoop] = []
    for first in range(0, len(drawn), _AT_ONCE):
        few = drawn[first : first + _AT_ONCE]
        measured = bench.measured(gains, few)
        if measured is None:
            break
        found += measured
        tell(len(few))
    return found


def objections(now: EnsembleVerdict, before: EnsembleVerdict, unit: str) -> Sequence[str]:
    """Return why gains are not to be put in force; empty: nothing speaks against them.

    Less error pays for no bound: gains that miss one, and by more than those in force do, are left
    to who asks for them, as are those that lose more plants. Gains in force that lose a plant are
    no measure of the rest: it ended before it could swing.

    Parameters
    ----------
    now, before : EnsembleVerdict
        The gains that were found, and those in force.
    unit : str
        Of motion in a hold, SI.
    """
    found = []
    if len(now.lost) > len(before.lost):
        found.append(_lost(now, before))
    if now.robust < ENOUGH and now.robust <= before.robust:
        found.append(f"bound missed: {_margin(now, before)}")
    if now.cost >= before.cost:
        found.append(f"they cost {now.cost:.3f}, those in force {before.cost:.3f}")
    if not before.lost:
        found += [f"worse than before, {bound}" for bound in _missed(now, before, unit, worse=True)]
    return found


def _lost(now: EnsembleVerdict, before: EnsembleVerdict) -> str:
    return (
        f"they lose {len(now.lost)} of {len(now.trials)} plants, or would be stopped there "
        f"(before: {len(before.lost)}), the worst of them: {now.losses}"
    )


def _margin(now: EnsembleVerdict, before: EnsembleVerdict) -> str:
    asked = math.ceil(ENOUGH * len(now.margins))
    return f"{_keeping(now)}, and {asked} are asked for (before: {_counted(before)})"


def _keeping(verdict: EnsembleVerdict) -> str:
    """Return in words how many drawn plants keep their distance, and how many were told."""
    count, bound = len(verdict.margins), f"keep a sensitivity of at most {SENSITIVITY:g}"
    if verdict.told == count:
        return f"only {verdict.keeping} of {count} drawn plants {bound}"
    return (
        f"of {count} drawn plants {verdict.told} were told, of which {verdict.keeping} {bound} "
        "(the others catch, or swing by themselves, while they are shaken)"
    )


def _counted(verdict: EnsembleVerdict) -> str:
    told, count = verdict.told, len(verdict.margins)
    return f"{verdict.keeping}" if told == count else f"{verdict.keeping} of {told} that were told"


def other_levers(now: EnsembleVerdict) -> str:
    """Return what helps where gains alone do not keep the bound; empty: they do."""
    if now.robust >= ENOUGH:
        return ""
    return (
        "where no gains keep it, more of the rig than its gains has to change: less dead time "
        "(shorter tubes, quicker regulators), a lower base pressure of a joint, other seals; "
        "rig/tuning/README.md, 'Where no gains do it', says what each is worth"
    )


def _missed(
    now: EnsembleVerdict, before: EnsembleVerdict, unit: str, *, worse: bool
) -> Sequence[str]:
    """Return the bounds that gains miss by more than those before did, or by no more."""
    found = []
    if now.hunting > QUIET and (now.hunting > before.hunting) is worse:
        hunting, most, then = (
            format_quantity(value, unit) for value in (now.hunting, QUIET, before.hunting)
        )
        found.append(
            f"bound missed: {hunting} of hunting on the worst plant, and at most "
            f"{most} is asked for (before: {then})"
        )
    if now.reversals > REVERSALS and (now.reversals > before.reversals) is worse:
        found.append(
            f"bound missed: {now.reversals:.1f} reversals a second on the worst plant, and at most "
            f"{REVERSALS:g} are asked for (before: {before.reversals:.1f})"
        )
    return found


def trades(now: EnsembleVerdict, before: EnsembleVerdict, unit: str) -> Sequence[str]:
    """Return which bounds gains miss as those before did, and what is worse with them.

    The cost weighs all of it; neither speaks against gains whose cost is less.

    Parameters
    ----------
    now, before : EnsembleVerdict
        The gains that were found, and those in force.
    unit : str
        Of errors and of motion in a hold, SI.
    """

    def text(value: float) -> str:
        return format_quantity(value, unit)

    found = [
        *_missed(now, before, unit, worse=False),
        *(_missed(now, before, unit, worse=True) if before.lost else ()),
    ]
    if now.lost and len(now.lost) <= len(before.lost):
        found.insert(0, f"no more than before, {_lost(now, before)}")
    if before.robust < now.robust < ENOUGH:
        found.insert(0, f"bound missed, though by less than before: {_margin(now, before)}")
    worse = [
        f"{name} {text(old)} to {text(new)}"
        for name, old, new in _compared(now, before)
        if new > old
    ]
    if before.keeping > now.keeping:
        worse.append(
            f"drawn plants with margin {before.keeping} to {now.keeping} of {len(now.margins)}"
        )
    if before.told > now.told:
        worse.append(f"drawn plants that were told {before.told} to {now.told}")
    if worse and now.cost < before.cost:
        found.append(f"traded for a lower cost, worse than before: {', '.join(worse)}")
    return found


def _compared(now: EnsembleVerdict, before: EnsembleVerdict) -> Sequence[tuple[str, float, float]]:
    """Return what both were measured by: its name, before, and now; all but what was lost."""
    rows = [("worst hunting", before.hunting, now.hunting)]
    for name in now.nominal.errors:
        rows += [
            (f"error as told, {name}", before.nominal.errors.get(name, np.inf),
             now.nominal.errors[name]),
            (f"worst error, {name}", before.worst(name)[0], now.worst(name)[0]),
        ]  # fmt: skip
    return [row for row in rows if np.isfinite(row[1:]).all()]


def in_short(now: EnsembleVerdict, before: EnsembleVerdict, unit: str) -> str:
    """Return in one line at what gains are better than those in force, and at what worse.

    Parameters
    ----------
    now, before : EnsembleVerdict
        The gains that were found, and those in force.
    unit : str
        Of motion in a hold, SI.
    """
    rows = [
        (before.keeping, now.keeping,
         f"margin ({before.keeping} to {now.keeping} of {len(now.margins)} drawn plants)", -1),
        (before.told, now.told, f"drawn plants that were told {before.told} to {now.told}", -1),
        (len(before.lost), len(now.lost), f"lost plants {len(before.lost)} to {len(now.lost)}", 1),
        (before.hunting, now.hunting, "hunting "
         + " to ".join(format_quantity(v.hunting, unit) for v in (before, now)), 1),
        (before.reversals, now.reversals,
         f"reversals {before.reversals:.1f} to {now.reversals:.1f} a second", 1),
    ]  # fmt: skip
    better = [told for old, new, told, sign in rows if sign * (new - old) < 0.0]
    worse = [told for old, new, told, sign in rows if sign * (new - old) > 0.0]
    errors = [(old, new) for name, old, new in _compared(now, before) if "error" in name]
    for found, count in (
        (better, sum(new < old for old, new in errors)),
        (worse, sum(new > old for old, new in errors)),
    ):
        if count:
            found.append(f"{count} of {len(errors)} errors")
    said = [f"better in {', '.join(better)}"] if better else []
    said += [f"worse in {', '.join(worse)}"] if worse else []
    cost = f"cost {before.cost:.3f} to {now.cost:.3f}"
    return "; ".join([*said, cost]) if said else f"neither better nor worse; {cost}"
