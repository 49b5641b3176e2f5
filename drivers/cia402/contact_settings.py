"""What a profile says of an emergency stop at a CiA 402 drive."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Interval


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactSettings:
    """An emergency stop that is wired to one of the drives.

    Parameters
    ----------
    joint : str
        Whose drive reads it.
    bit : int
        Of 0x60FD; 16 is the first of the maker's inputs.
    active_low : bool
        The contact is normally closed: the bit is 0 when the stop is pressed, or its wire cut.
    """

    joint: str
    bit: Annotated[int, Interval(ge=0, le=31)] = 16
    active_low: bool = True
