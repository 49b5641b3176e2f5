"""A kind of fault: what may break, where, by how much, and what must come of it."""

import math
import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rig.faults.stage import Stage
from rig.faults.subject import Subject


class Must(StrEnum):
    """The outcome that a fault must have."""

    RIDE = "ride"
    """The run goes on as if nothing had been."""
    SAFE = "safe"
    """It is seen, named, and the rig made safe."""
    EITHER = "either"
    """It is harmless: going on is as good as stopping, for a stated reason."""


class Place(NamedTuple):
    """A part of a rig in which a fault happens.

    Parameters
    ----------
    target : str
        Device, bus or ``plant``; what the world is told.
    where : str
        What a reader is told: ``regulators agonist``.
    names : tuple of str
        Words of which one at least must be in what the operator is told.
    number : float, optional
        The channel or axis where the target wants a number.
    axis : str
        The axis of a device that has several; empty if it has not.
    """

    target: str
    where: str
    names: tuple[str, ...]
    number: float | None = None
    axis: str = ""


class Magnitudes(NamedTuple):
    """The range that a magnitude is drawn from, every decade as likely as another.

    Parameters
    ----------
    low, high : float
        Both positive, SI.
    unit : str
        Of both.
    signed : bool
        Whether either sign is as likely.
    """

    low: float
    high: float
    unit: str
    signed: bool = False

    def draw(self, chance: random.Random) -> float:
        """Return one."""
        size = math.exp(chance.uniform(math.log(self.low), math.log(self.high)))
        return -size if self.signed and chance.random() < 0.5 else size

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{'±' if self.signed else ''}{self.low:g} … {self.high:g}{unit}"


class Sizes(NamedTuple):
    """The drawn size of one fault: how much, and for how long (s; infinite for good)."""

    magnitude: float | None
    lasts: float


Expect = Callable[[Sizes, Subject], Must]


class Plight(NamedTuple):
    """The state of a rig when a fault befalls it.

    Parameters
    ----------
    subject : Subject
        The rig.
    place : Place
        What breaks.
    sizes : Sizes
        How much of it.
    truth : mapping
        What is true of the plant, by its columns.
    left : float
        For how long the program's loop is still there, s; negative where it is not.
    moved : float
        How far the axis moves in that time, rad.
    limp : bool
        Whether the axis' drive has no torque at some time from then on.
    """

    subject: Subject
    place: Place
    sizes: Sizes
    truth: Mapping[str, float]
    left: float
    moved: float
    limp: bool = False


Excuse = Callable[[Plight], frozenset[str]]
Samples = NDArray[np.float64]
Shows = Callable[[Sizes, Samples, Samples], float | None]
"""Takes sizes, times (s, ascending, shape (n,)) and what is true then of the columns that may show
it, shape (n, m), from the fault to the end of control; returns when they first do, s."""


_LOW_PRESSURE = 100e3
"""Pa gauge: what leaves a chamber that holds less is fed sooner, and moves its rod later."""


def at_once(sizes: Sizes, times: Samples, truth: Samples) -> float | None:
    """Have a fault show from its beginning."""
    return float(times[0])


def no_excuse(plight: Plight) -> frozenset[str]:
    """Forgive nothing."""
    return frozenset()


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultKind:
    """One row of the reaction table.

    Parameters
    ----------
    name : str
        ``wire_cut``.
    what : str
        What breaks, one sentence.
    places : callable
        Where it may happen on a rig; nowhere if the rig has nothing of the kind.
    apply : callable
        Makes it happen; returns what ends it, if anything does.
    must : callable
        What must come of it while the rig runs, from its size.
    within : float
        How soon it must be seen, s, where it must.
    filling : float
        How soon while chambers fill and drives are enabled, s, if that takes longer: what moves
        little shows little.
    in_motion : bool
        Whether only motion shows it: the orderly stop, which moves everything, counts for it.
    shows : callable
        Returns when the truth first shows it; it is felt from then on.
    shown_by : tuple of str
        How the columns of the truth begin that it is shown: ``{axis}`` is the place's, and
        ``{opposite}`` what pulls against it.
    why : str
        Why it is harmless where it need not be seen, or what limits its being seen.
    magnitude : Magnitudes, optional
        How much of it there may be.
    lasts : Magnitudes, optional
        How long it may last; for good without.
    forgives : frozenset of str
        Hazards that no controller could prevent, and that the mechanism must bear.
    excuses : callable
        Returns more of these, where the plant shows that it could not be helped.
    is_sudden : bool
        Whether those are forgiven as well that the emergency stop would not have kept off.
    spoils_law : bool
        Whether it is felt only when the controller is followed, and is counted from then on.
    stalls : bool
        Whether the program sees nothing for as long as its size says.
    in_setpoints : bool
        Whether setpoints show it: not those of drives that rest.
    is_rehearsable : bool
        Whether it may happen in a rehearsal, which touches no bus and no device.
    """

    name: str
    what: str
    places: Callable[[Subject], Sequence[Place]]
    apply: Callable[[Stage, Place, Sizes], Callable[[], None] | None]
    must: Expect
    within: float = 0.1
    filling: float = 0.0
    in_motion: bool = False
    shows: Shows = at_once
    shown_by: tuple[str, ...] = ("pressure_{axis}",)
    why: str = ""
    magnitude: Magnitudes | None = None
    lasts: Magnitudes | None = None
    forgives: frozenset[str] = frozenset()
    excuses: Excuse = no_excuse
    is_sudden: bool = False
    spoils_law: bool = False
    stalls: bool = False
    in_setpoints: bool = False
    is_rehearsable: bool = False


def ride(sizes: Sizes, subject: Subject) -> Must:
    """Expect that the run goes on."""
    return Must.RIDE


def safe(sizes: Sizes, subject: Subject) -> Must:
    """Expect that the fault is seen."""
    return Must.SAFE


def either(sizes: Sizes, subject: Subject) -> Must:
    """Expect nothing but that no harm is done."""
    return Must.EITHER


def is_felt(least: float, at_low: float | None = None) -> Expect:
    """Expect that what is at least so large is seen, and that less does no harm.

    Parameters
    ----------
    least : float
        In the unit of the magnitude.
    at_low : float, optional
        The same for a rig whose chambers hold less than 100 kPa at rest; as `least` if not given.
    """

    def must(sizes: Sizes, subject: Subject) -> Must:
        is_low = subject.base_pressure < _LOW_PRESSURE
        bound = at_low if is_low and at_low is not None else least
        return Must.SAFE if abs(sizes.magnitude or 0.0) >= bound else Must.EITHER

    return must
