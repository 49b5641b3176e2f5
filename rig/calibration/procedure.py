"""What a procedure is: an excitation within the rig's limits, and what its log says."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from rig.calibration.estimates import Estimate
from rig.calibration.recording import Recording
from rig.config import Profile
from rig.hal.motion import Motion

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rig.calibration.instruments import Instrument

Readings = Mapping[str, Mapping[str, float]]
"""Of reference instruments: by quantity, then by stretch; SI."""


class Panel(NamedTuple):
    """Data, fit, residuals and what was believed before, for the page of a calibration.

    Parameters
    ----------
    title, x_label, y_label, residual_label : str
        With units, as printed.
    x, y : ndarray, shape (n,)
        The data, in the printed units.
    fit, before : ndarray, shape (n,)
        What the new and the old calibration make of `x`.
    residual_scale : float
        From the unit of the data to that of the residuals, e.g. 1e3 from mm to µm.
    curve : tuple of ndarray, shape (m,), optional
        x and what the old calibration makes of it, where straight lines between the data would
        tell something else.
    """

    title: str
    x_label: str
    y_label: str
    residual_label: str
    x: "NDArray[np.float64]"
    y: "NDArray[np.float64]"
    fit: "NDArray[np.float64]"
    before: "NDArray[np.float64]"
    residual_scale: float = 1.0
    curve: "tuple[NDArray[np.float64], NDArray[np.float64]] | None" = None


class Finding(NamedTuple):
    """What a recording says of one device or of the mechanism.

    Parameters
    ----------
    target : str
        The device, or the mechanism's name: the calibration file to write.
    values : mapping
        What to lay over its settings, quantities as texts with units.
    estimates : sequence of Estimate
        Everything that was measured, with its uncertainty.
    residuals : ndarray, shape (n,)
        Measured less fitted, SI.
    unit : str
        Of the residuals.
    bound : float
        The rms of the residuals above which this is not to be used.
    blocks : int
        Independent repetitions that it rests on.
    panels : sequence of Panel
        For the page.
    notes : sequence of str
        What was not found and why, for people.
    """

    target: str
    values: Mapping[str, Any]
    estimates: Sequence[Estimate]
    residuals: "NDArray[np.float64]"
    unit: str
    bound: float
    blocks: int
    panels: Sequence[Panel]
    notes: Sequence[str] = ()


class Excitation(NamedTuple):
    """What moves, and who moves it.

    Parameters
    ----------
    settings : object
        Dataclass of the reference, for the run folder.
    motion : Motion
        What is followed.
    controller : object
        Who follows it.
    controller_name : str
        For the run folder.
    profile : Profile
        The rig's, with what this excitation needs otherwise.
    notes : sequence of str
        What is otherwise, for the preview.
    approach : float
        Time to go where it starts, s.
    placing : str
        What somebody has to do by hand before it; there may be more of it after.
    """

    settings: Any
    motion: Motion[Any]
    controller: Any
    controller_name: str
    profile: Profile
    notes: Sequence[str] = ()
    approach: float = 2.0
    placing: str = ""


class Procedure(Protocol):
    """One procedure of a mechanism."""

    @property
    def name(self) -> str:
        """What the command line calls it."""
        ...

    @property
    def title(self) -> str:
        """What it finds, for people."""
        ...

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the files that it writes: devices, or the mechanism."""
        ...

    def instruments(self, profile: Profile) -> "Sequence[Instrument]":
        """Return the reference instruments that somebody has to read."""
        ...

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return what is to be done, without the stretches that are done."""
        ...

    def identify(
        self, profile: Profile, recording: Recording, readings: Readings
    ) -> Sequence[Finding]:
        """Return what a recording says.

        Parameters
        ----------
        profile : Profile
            The one that it was recorded under.
        recording : Recording
            Without the simulation's truth.
        readings : mapping
            Of the reference instruments.

        Raises
        ------
        CalibrationRefused
            What was recorded does not suffice; says what is missing.
        """
        ...


def quantity(value: float, unit: str) -> str:
    """Write a number with its unit for a calibration file, to nine digits."""
    return f"{value:.9g}" if unit == "1" else f"{value:.9g} {unit}"
