"""What a mechanism makes of a log once its run has ended: part of `rig.hal.Mechanism`."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeVar

from rig.hal.motion import Note

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Logged = Callable[[str], NDArray[np.float64]]

HUNTS, STICKS, STRAYED = "hunts", "sticks", "strayed"
"""Kinds of remarks: it swings about a reference that rests; it sticks and slips; it was farther off
than is permitted, for less than a fault."""
FLAWS = (HUNTS, STICKS)
"""No run of which one of these is said has ended well; who strays may lag behind a quick motion."""

Settings = TypeVar("Settings", contravariant=True)


class Suspect(NamedTuple):
    """A likely cause of a fault.

    Parameters
    ----------
    cause : str
        One word, for programs.
    of : str
        What it is about: a channel, or empty.
    value : float
        What it comes to, SI.
    unit : str
        Of SI, empty for a ratio.
    gain : float
        How much better than health it explains the log.
    sentence : str
        All of it, for people.
    """

    cause: str
    of: str
    value: float
    unit: str
    gain: float
    sentence: str


class Hindsight(Protocol[Settings]):
    """The questions that a mechanism is asked about a log. Inherit it: each has a default."""

    @classmethod
    def constants_of(cls, settings: Settings) -> Mapping[str, float]:
        """Return what measures need to know of the rig beside its log: names and SI numbers."""
        return {}

    def diagnose(self, fault: Exception, logged: "Logged") -> tuple[Suspect, ...]:
        """Return what explains the end of a log best; two if neither is clearly better.

        Called once, after the rig was made safe.

        Parameters
        ----------
        fault : Exception
            What ended the run.
        logged : callable
            Returns a column of the log by its name, shape (n,), up to the fault.
        """
        return ()

    def remarks(self, logged: "Logged") -> tuple[Note, ...]:
        """Return what else a log tells that somebody should know, however the run has ended.

        A run that ended well counts as one that missed a bound after a remark of one of the kinds
        `FLAWS`.
        """
        return ()
