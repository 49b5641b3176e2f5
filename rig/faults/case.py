"""One case: a fault, or two, at a drawn place, size and moment of an experiment."""

import random
import shlex
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from math import inf
from pathlib import Path

from rig.experiment.rehearsal import CYCLES
from rig.faults.catalogue import kind_named
from rig.faults.kind import FaultKind, Place, Sizes
from rig.faults.subject import Subject
from rig.runtime.phases import Timings


class Moment(StrEnum):
    """The phase of a run in which a fault happens; or a calibration's run, from energising on."""

    REHEARSAL = "rehearsal"
    CONNECT = "connect"
    ENERGISE = "energise"
    APPROACH = "approach"
    RUN = "run"
    RELEASE = "release"
    STOP = "stop"
    CALIBRATION = "calibration"


WEIGHTS = {
    Moment.CONNECT: 1, Moment.ENERGISE: 1, Moment.APPROACH: 1, Moment.RUN: 6,
    Moment.RELEASE: 1, Moment.STOP: 1,
}  # fmt: skip
"""How often each is drawn: most of a rig's life is the run."""
CALIBRATIONS, REHEARSALS = 0.08, 0.02
"""Share of the cases that are drawn into a calibration and a rehearsal instead."""

CALIBRATION_SHARE = 20.0
"""Longest time into a calibration at which a fault is drawn, s, as `RUN_SHARE`."""

RUN_SHARE = 2.5
"""Longest time into the run at which a fault is drawn, s: a campaign has to end."""
UNIT = 1000
"""So many seeds share a simulated unit and an experiment."""
SECOND_WITHIN = 0.2
"""Longest time from a fault to the one after it, s."""


@dataclass(frozen=True, slots=True)
class Break:
    """One fault of a case.

    Parameters
    ----------
    kind : str
        Name in the catalogue.
    where : str
        Which of the kind's places.
    magnitude : float or None
        How much, in the kind's unit.
    lasts : float
        For how long, s; infinite for good.
    """

    kind: str
    where: str
    magnitude: float | None
    lasts: float

    @property
    def row(self) -> FaultKind:
        """The kind's row."""
        return kind_named(self.kind)

    @property
    def sizes(self) -> Sizes:
        """How much and for how long."""
        return Sizes(self.magnitude, self.lasts)

    def place(self, subject: Subject) -> Place:
        """Return the place on a rig.

        Raises
        ------
        ValueError
            The rig has no such place.
        """
        places = self.row.places(subject)
        for place in places:
            if place.where == self.where:
                return place
        known = ", ".join(place.where for place in places) or "no place at all"
        raise ValueError(
            f"{self.kind} cannot happen at {self.where!r} of {subject.rig}; there is {known}"
        )


@dataclass(frozen=True, slots=True)
class Case:
    """A run in which something breaks.

    Parameters
    ----------
    rig, experiment : str
        What is run: an experiment, or a procedure while it calibrates.
    seed : int
        Of the simulated unit and its noise.
    moment : Moment
        The phase in which the first fault happens.
    after : float
        How long after the phase began, s.
    first : Break
        What breaks.
    then : Break or None
        What breaks next.
    then_after : float
        How long after the first, s.
    drawn_with : int, optional
        The seed that this case is drawn with again; None if it was written by hand.
    among : tuple of str
        The experiments that it was drawn from, if they were chosen.
    source : str
        The file that it was written in.
    configs : str
        The folder of the configurations, if it was named.
    again : str
        The command that runs it again, where that is another than these tell.
    """

    rig: str
    experiment: str
    seed: int
    moment: Moment
    after: float
    first: Break
    then: Break | None = None
    then_after: float = 0.0
    drawn_with: int | None = None
    among: tuple[str, ...] = ()
    source: str = ""
    configs: str = ""
    again: str = ""

    @property
    def breaks(self) -> tuple[Break, ...]:
        """What breaks, in its order."""
        return (self.first,) if self.then is None else (self.first, self.then)

    @property
    def kinds(self) -> tuple[str, ...]:
        """Names of what breaks, in its order."""
        return tuple(item.kind for item in self.breaks)

    @property
    def stretch(self) -> str:
        """The stretch of the program in which cases may share a run."""
        alone = (Moment.CALIBRATION, Moment.REHEARSAL)
        return str(self.moment) if self.moment in alone else "run"

    @property
    def awaited(self) -> str:
        """Its faults and their moments, in words: ``wire_cut 0.2 s into run, then silent``."""
        then = "" if self.then is None else f", then {self.then.kind} {self.then_after:.3g} s later"
        return f"{self.first.kind} {self.after:.3g} s into {self.moment}{then}"

    @property
    def command(self) -> str:
        """The command that runs this case again."""
        if self.again:
            return self.again
        configs = f" --configs {shlex.quote(self.configs)}" if self.configs else ""
        if self.drawn_with is None:
            return f"rig faults run {shlex.quote(self.source)}{configs}"
        chosen = "".join(f" --experiment {shlex.quote(name)}" for name in self.among)
        kinds = "+".join(self.kinds)
        return f"rig faults run {self.rig} --only {kinds} --seed {self.drawn_with}{chosen}{configs}"

    @property
    def folder(self) -> str:
        """Name of the folder that it leaves."""
        drawn = Path(self.source).stem if self.drawn_with is None else str(self.drawn_with)
        return f"{Path(self.rig).stem}-{drawn}-{'+'.join(self.kinds)}"

    def as_json(self) -> dict[str, object]:
        """Return it as plain data."""
        return asdict(self)


def draw_case(subject: Subject, kinds: tuple[str, ...], seed: int) -> Case:
    """Draw where, when and how much of one fault, or of two.

    Parameters
    ----------
    subject : Subject
        The rig.
    kinds : tuple of str
        One or two names.
    seed : int
        The same seed gives the same case. Seeds of the same thousand share experiment and unit,
        so that they can share a run.
    """
    unit = random.Random(f"{subject.rig} unit {seed // UNIT}")
    experiment, unit_seed = unit.choice(subject.experiments), unit.randrange(1_000_000)
    chance = random.Random(f"{subject.rig} {'+'.join(kinds)} {seed}")
    moment = chance.choices(list(WEIGHTS), list(WEIGHTS.values()))[0]
    timings = Timings()
    lengths = {
        Moment.CONNECT: subject.connecting, Moment.ENERGISE: timings.energise,
        Moment.APPROACH: timings.approach, Moment.RUN: RUN_SHARE,
        Moment.RELEASE: timings.release, Moment.STOP: 0.05,
    }  # fmt: skip
    breaks = [_draw_break(subject, name, chance) for name in kinds]
    case = Case(
        subject.rig,
        experiment,
        unit_seed,
        moment,
        chance.uniform(0.0, lengths[moment]),
        breaks[0],
        breaks[1] if len(breaks) > 1 else None,
        chance.uniform(0.0, SECOND_WITHIN) if len(breaks) > 1 else 0.0,
        seed,
        subject.chosen,
        configs=subject.configs,
    )
    return _elsewhere(case, subject, unit, random.Random(f"{chance.random()} elsewhere"))


def _elsewhere(case: Case, subject: Subject, unit: random.Random, chance: random.Random) -> Case:
    """Return the case, now and then as one of a calibration or of the rehearsal of a run."""
    share = chance.random()
    if share < CALIBRATIONS and subject.procedures and not subject.chosen:
        procedure = unit.choice(list(subject.procedures))
        length = min(subject.procedures[procedure], CALIBRATION_SHARE)
        after = chance.uniform(0.0, length)
        return replace(case, experiment=procedure, moment=Moment.CALIBRATION, after=after)
    is_rehearsable = case.then is None and case.first.row.is_rehearsable
    if CALIBRATIONS <= share < CALIBRATIONS + REHEARSALS and is_rehearsable:
        after = chance.uniform(0.0, 0.8 * CYCLES * subject.period)
        return replace(case, moment=Moment.REHEARSAL, after=after)
    return case


def _draw_break(subject: Subject, name: str, chance: random.Random) -> Break:
    kind = kind_named(name)
    place = chance.choice(list(kind.places(subject)))
    return Break(
        name,
        place.where,
        None if kind.magnitude is None else kind.magnitude.draw(chance),
        inf if kind.lasts is None else kind.lasts.draw(chance),
    )
