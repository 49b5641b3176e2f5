"""What a driver says of its nodes as data: for decoding frames, and for comparing with an EDS."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from drivers.canopen.mapping import Entry, Layout
from rig.hal.driver import Keys


class Quantity(NamedTuple):
    """The meaning of a mapped object, beyond its counts.

    Attributes
    ----------
    name : str
        E.g. ``agonist pressure``.
    unit : str
        Of SI; empty where counts are all there is.
    gain, offset : float
        ``value = gain · counts + offset``. A gain of None: the device says it, see `Told`.
    words : callable, optional
        Puts an integer into words, in the place of a number.
    """

    name: str
    unit: str = ""
    gain: float | None = 1.0
    offset: float = 0.0
    words: Callable[[int], str] | None = None


class Told(NamedTuple):
    """A gain that the device says in an object of its own.

    Attributes
    ----------
    object, sub : int
        That object.
    entry : Entry
        The mapped object whose gain it gives.
    factor : float
        ``gain = factor · (the object's counts)``.
    """

    object: int
    sub: int
    entry: Entry
    factor: float


@dataclass(frozen=True, slots=True)
class DescribedNode:
    """One CANopen node of a device.

    Parameters
    ----------
    name : str
        Device, and joint where it has several nodes.
    node : int
        Its number.
    receive, transmit : tuple of Layout
        What it receives and sends, from PDO 1 on.
    remap : bool
        Whether the driver writes this mapping; else it must be the node's own.
    quantities : mapping of Entry to Quantity
        What is mapped, or set besides.
    origins : mapping of Entry to tuple
        Which key of the device's settings asks for the object.
    told : tuple of Told
        What the node says of its scales.
    deadline : bool
        Whether `setpoint_deadline` asks for a deadline of what it receives.
    contents : tuple of str
        What it receives and what it sends, each in a word, as the bus load has it.
    """

    name: str
    node: int
    receive: tuple[Layout, ...]
    transmit: tuple[Layout, ...]
    remap: bool
    quantities: Mapping[Entry, Quantity]
    origins: Mapping[Entry, Keys] = field(default_factory=dict)
    told: tuple[Told, ...] = ()
    deadline: bool = False
    contents: tuple[str, str] = ("", "")
