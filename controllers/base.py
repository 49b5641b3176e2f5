"""What every law is: a pure function of its state, reference and own memory.

A profile names a `Law`, which is made from settings and a model; a law that plans a whole motion
before it starts is a `PlanningLaw`. Their methods have defaults, so that nobody has to look for
what a law may lack.
"""

import math
from abc import ABC, abstractmethod
from typing import Any, ClassVar, Generic, NamedTuple, Self, TypeVar

State = TypeVar("State", contravariant=True)
Reference = TypeVar("Reference", contravariant=True)
Command = TypeVar("Command", covariant=True)
Motion = TypeVar("Motion", contravariant=True)
Plan = TypeVar("Plan", covariant=True)
Chosen = TypeVar("Chosen")
Model = TypeVar("Model")


class Tunable(NamedTuple):
    """A number among a law's settings that a search may change, or a person while it runs.

    Parameters
    ----------
    key : str
        Its name in the settings, ``"feedforward.gain"``.
    low, high : float
        Bounds, in the unit of the setting. A search goes in equal ratios.
    """

    key: str
    low: float
    high: float


class Law(ABC, Generic[Chosen, Model, Reference, State, Command]):
    """A controller with a fixed period, that a profile may name.

    No I/O, no clock, no log, no randomness: the same sequence of states and references
    gives the same sequence of commands.

    Parameters
    ----------
    settings : dataclass
        An instance of `Settings`.
    model : object
        What the mechanism tells its laws of the mechanics.
    period : float
        The loop's period, s.

    Attributes
    ----------
    Settings : type
        Dataclass of the law's entries in a profile.
    tunables : tuple of Tunable
        What `rig tune` may change of the settings; empty: nothing.
    online : tuple of Tunable
        What `retune` may change while the law runs; empty: nothing.
    settings, model, period
        As given.
    """

    Settings: ClassVar[type]
    tunables: ClassVar[tuple[Tunable, ...]] = ()
    online: ClassVar[tuple[Tunable, ...]] = ()

    def __init__(self, settings: Chosen, model: Model, period: float) -> None:
        self.settings = settings
        self.model = model
        self.period = period

    def compile(self) -> None:
        """Compile what is slow in Python; called once, by who puts the law into a loop."""

    def retune(self, settings: Chosen) -> None:
        """Go on with settings that differ in `online` gains alone; what is remembered stays."""
        raise ValueError(f"{type(self).__name__} has no gains that change while it runs")

    @abstractmethod
    def reset(self, state: State) -> None:
        """Forget the past and start bumplessly from the measured `state`."""

    @abstractmethod
    def update(self, state: State, reference: Reference) -> Command:
        """Return the command for this period."""


AnyLaw = Law[Any, Any, Any, Any, Any]
"""A law of any mechanism."""


class PlanningLaw(
    Law[Chosen, Model, Reference, State, Command],
    Generic[Chosen, Model, Reference, State, Command, Motion, Plan],
):
    """A law that works out a whole motion before it starts, and follows it online.

    Attributes
    ----------
    longest : float
        A motion that takes longer is refused, s; who makes the law says it.
    """

    longest: float = math.inf

    def at_period(self, period: float) -> Self:
        """Return the same law for a loop of another period, s."""
        other = type(self)(self.settings, self.model, period)
        other.longest = self.longest
        return other

    @abstractmethod
    def prepare(self, motion: Motion) -> Plan:
        """Return the plan of a motion, which `update` then follows.

        Raises
        ------
        InfeasibleMotion
            It cannot be done; nothing has moved.
        """
