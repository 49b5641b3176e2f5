"""Who was found on a bus."""

from typing import NamedTuple


class Found(NamedTuple):
    """What one node number answers.

    Attributes
    ----------
    node : int
        The number.
    kind : str
        What it says it is: ``CiA 401 (0x000F0191)``, ``ODrive 0.6.10``; empty if it does not say.
    profile : int or None
        The number of its CiA device profile, if it has one.
    vendor, product : int or None
        As it identifies itself.
    serials : tuple of int
        Usually one; more are more devices with one number.
    state : str
        In words.
    answers : int
        Most answers that came to one question: 0 for a node that only sends of itself, and more
        than 1 for devices that share a number.
    """

    node: int
    kind: str = ""
    profile: int | None = None
    vendor: int | None = None
    product: int | None = None
    serials: tuple[int, ...] = ()
    state: str = ""
    answers: int = 1
