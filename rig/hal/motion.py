"""What the loop follows, and the stretches of it that metrics look at."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple, Protocol, TypeVar

from rig.hal.devices import Device

Followed = TypeVar("Followed", covariant=True)


class Segment(NamedTuple):
    """A named stretch of time, settling already left out.

    Parameters
    ----------
    name : str
        What happens in it, e.g. ``"0.2 Hz"`` or ``"hold +4 mm"``.
    start, end : float
        Seconds since the reference started.
    """

    name: str
    start: float
    end: float


class Fact(NamedTuple):
    """A number that is known of a motion before it is done: it may be a metric like a measured one.

    Parameters
    ----------
    value : float
        SI.
    unit : str
        SI unit, empty for a ratio.
    description : str
        For reports.
    """

    value: float
    unit: str
    description: str


class FactKind(NamedTuple):
    """Unit and description of a fact, whatever the motion."""

    unit: str
    description: str


def facts_of(kinds: Mapping[str, FactKind], values: Mapping[str, float]) -> dict[str, Fact]:
    """Return numbers (SI) with what they are."""
    return {name: Fact(float(value), *kinds[name]) for name, value in values.items()}


class Note(NamedTuple):
    """Something that a motion wants written among the run's events: its kind, and a sentence."""

    kind: str
    message: str


class Motion(Protocol[Followed]):
    """A desired motion, from rest to rest. Inherit it: what has a default need not be written."""

    waits: bool = False
    """Whether a late cycle holds the motion, so that nothing of it is left out."""

    has_torque: bool = True
    """Whether servo drives are energised for it; without torque they are only listened to."""

    facts: Mapping[str, Fact] = MappingProxyType({})
    """What is known of it before it is done."""

    remarks: Sequence["Note"] = ()
    """What is known of it before it is done, in words: what was chosen, and why."""

    watches: bool = False
    """Whether it depends on what is measured: `see` is called, and its end may come at any time."""

    stands: bool = False
    """Whether the rig is meant to stay where it is though nothing controls it."""

    real_time: bool = False
    """Whether somebody steers it as it goes: a simulation runs no faster than they live."""

    @property
    @abstractmethod
    def duration(self) -> float:
        """How long it takes, s."""

    @property
    @abstractmethod
    def segments(self) -> tuple[Segment, ...]:
        """The stretches that metrics look at."""

    @abstractmethod
    def at(self, t: float) -> Followed:
        """Return the reference at `t` seconds, 0 … `duration`."""

    @property
    def foreseen(self) -> "Motion[Followed]":
        """What is known of it beforehand: itself, unless it depends on what is measured."""
        return self

    def see(self, t: float, state: object, here: object) -> Sequence[Note]:
        """Take what was measured, right before `at` is asked for the same instant.

        Parameters
        ----------
        t : float
            Since the reference started, s.
        state : State
            What the controller will be told.
        here : Reference
            The reference that the rig fulfils as it stands.
        """
        return ()

    def attach(self, devices: Mapping[str, Device]) -> None:
        """Take the rig's devices by name; for a motion that works valves beside the setpoints."""
        return
