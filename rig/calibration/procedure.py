"""The contract of a procedure: an excitation within the rig's limits, and an identification."""

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol, TypeVar

from rig.calibration.arrays import Array
from rig.calibration.estimates import Estimate
from rig.calibration.instruments import Instrument, Readings
from rig.calibration.recording import NoFiles
from rig.config import Profile
from rig.hal.motion import Motion


class Panel(NamedTuple):
    """Data, fit, residuals and the belief before, for the page of a calibration.

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
    x: Array
    y: Array
    fit: Array
    before: Array
    residual_scale: float = 1.0
    curve: tuple[Array, Array] | None = None


class Finding(NamedTuple):
    """A result for one device or for the mechanism.

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
    reasons : mapping of str to str
        Why a value is another one than its estimates, by its dotted name; kept in the file.
    """

    target: str
    values: Mapping[str, object]
    estimates: Sequence[Estimate]
    residuals: Array
    unit: str
    bound: float
    blocks: int
    panels: Sequence[Panel]
    notes: Sequence[str] = ()
    reasons: Mapping[str, str] = MappingProxyType({})


class Excitation(NamedTuple):
    """A motion to be recorded, and the controller that follows it.

    Parameters
    ----------
    settings : object
        Dataclass of the reference, for the run folder.
    motion : Motion
        What is followed.
    controller : Controller
        Who follows it; a script follows itself.
    controller_name : str
        For the run folder.
    profile : Profile
        The rig's, with what this excitation needs otherwise.
    describe : callable
        Yields what moves and how far, for the preview.
    notes : sequence of str
        What is otherwise, for the preview.
    approach : float
        Time to go where it starts, s.
    placing : str
        What somebody has to do by hand before it; there may be more of it after.
    """

    settings: object
    motion: Motion[object]
    controller: object
    controller_name: str
    profile: Profile
    describe: Callable[[], Iterator[str]]
    notes: Sequence[str] = ()
    approach: float = 2.0
    placing: str = ""


class Evidence(Protocol):
    """The files that a calibration rests on: a recording, or images."""

    @property
    def paths(self) -> tuple[Path, ...]:
        """The files."""

    @property
    def samples(self) -> int:
        """How much is in them."""

    def sha256(self) -> str:
        """Return the digest of the files."""


class FilesOffered(NamedTuple):
    """Files that somebody hands over to a procedure without a motion.

    Parameters
    ----------
    source : Path or None
        A folder or a file; None if there is none.
    board : str
        The board that images show, as in ``"10x7x8mm"``.
    simulated : bool
        Whether the rig is simulated, so that the procedure may make its own files.
    out : Path
        Where run folders live.
    """

    source: Path | None
    board: str
    simulated: bool
    out: Path


Data = TypeVar("Data", bound=Evidence)


class Procedure(Protocol[Data]):
    """One procedure of a mechanism. Inherit it: what has a default need not be written.

    It either moves the rig (`excite`), and its data are a `Recording`; or it moves nothing, and
    reads its data from files (`read_files`).
    """

    @property
    @abstractmethod
    def name(self) -> str:
        """What the command line calls it."""

    @property
    @abstractmethod
    def title(self) -> str:
        """What it finds, for people."""

    @property
    def shares(self) -> tuple[str, ...]:
        """Procedures that find the same of a target that both write; default: none."""
        return ()

    @property
    def rests_on_dimensions(self) -> bool:
        """Whether what it finds of a device holds for these dimensions of the mechanism only.

        Default: it does not. What it finds of the mechanism does in any case.
        """
        return False

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the files that it writes, devices or the mechanism; default: the mechanism."""
        return (profile.mechanism,)

    def instruments(self, profile: Profile) -> "Sequence[Instrument]":
        """Return the reference instruments that somebody has to read; default: none."""
        return ()

    def check_rig(self, profile: Profile) -> None:
        """Refuse a rig that has not what the procedure takes, before any motion is made.

        Raises
        ------
        RigLacks
            It has not; says what it takes. Default: any rig has.
        """
        return

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation | None:
        """Return what is to be done without the stretches that are done; None: nothing moves.

        Raises
        ------
        RigLacks
            The rig has not what it takes.
        """
        return None

    def describe_files(self, files: FilesOffered) -> Iterator[str]:
        """Yield what a procedure without a motion will read."""
        return iter(())

    def read_files(self, profile: Profile, files: FilesOffered) -> tuple[Data, Path]:
        """Return what a procedure without a motion rests on, and its run folder.

        Raises
        ------
        NoFiles
            There are none.
        CalibrationRefused
            They do not suffice.
        """
        raise NoFiles(f"{self.name} reads no files")

    @abstractmethod
    def identify(self, profile: Profile, data: Data, readings: Readings) -> Sequence[Finding]:
        """Return what the data say.

        Parameters
        ----------
        profile : Profile
            The one that they were recorded under.
        data : Recording or other Evidence
            Without the simulation's truth.
        readings : mapping
            Of the reference instruments.

        Raises
        ------
        CalibrationRefused
            They do not suffice; says what is missing.
        """


AnyProcedure = Procedure[Any]
"""A procedure, whatever its data are."""


def quantity(value: float, unit: str) -> str:
    """Write a number with its unit for a calibration file, to nine digits."""
    return f"{value:.9g}" if unit == "1" else f"{value:.9g} {unit}"
