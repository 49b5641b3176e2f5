"""What a frame says, in the words of a profile."""

from typing import NamedTuple


class Value(NamedTuple):
    """One quantity of a frame.

    Attributes
    ----------
    name : str
        What it is, e.g. ``agonist pressure``.
    value : float, int or str
        SI where `unit` names one, else as the wire has it, or in words.
    unit : str
        Of SI; empty for counts and words.
    object : str
        The object or field that holds it, e.g. ``0x6401:01``.
    """

    name: str
    value: float | int | str
    unit: str = ""
    object: str = ""


class Decoded(NamedTuple):
    """One frame.

    Attributes
    ----------
    device : str
        Whose frame it is, by the profile's name; empty for the whole bus's.
    service : str
        What kind of frame it is: ``TPDO1``, ``heartbeat``, ``Set_Input_Pos``.
    values : tuple of Value
        What is in it.
    text : str
        What else there is to say.
    known : bool
        False for a frame of which the profile knows nothing.
    """

    device: str
    service: str
    values: tuple[Value, ...] = ()
    text: str = ""
    known: bool = True


UNKNOWN = Decoded("", "unknown", known=False)
"""A frame that nothing in the profile explains."""
