"""What decoders and surveys of a bus return, in the words of a profile."""

from typing import NamedTuple, Protocol


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


class Decoder(Protocol):
    """Reads the frames of one bus, in their order."""

    def decode(self, can_id: int, data: bytes) -> Decoded:
        """Return what a frame says; `UNKNOWN` if nothing in the profile explains it.

        Parameters
        ----------
        can_id : int
            With SocketCAN's flags for extended, remote and error frames.
        data : bytes
            Its content.
        """


class LoggedFrame(NamedTuple):
    """A frame and where and when it was seen.

    Attributes
    ----------
    time : float
        Seconds since the epoch, or since whatever its recorder chose.
    channel : str
        The bus.
    can_id : int
        With SocketCAN's flags for extended, remote and error frames.
    data : bytes
        0 … 8 bytes.
    is_sent : bool, optional
        By this program, or received; None: the file does not say.
    """

    time: float
    channel: str
    can_id: int
    data: bytes
    is_sent: bool | None = None


class Found(NamedTuple):
    """The answers of one node number.

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
