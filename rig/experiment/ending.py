"""How a run ends, and what its folder says of it, whatever ended it."""

import contextlib
import re
from types import TracebackType
from typing import NamedTuple

from rig.assembly.contract_check import said, whose_bug
from rig.hal import ConfigurationError, ContractBroken, DeviceError, RigError
from rig.installation import missing_package
from rig.run_facts import RunStatus
from rig.run_folder import RunFolder
from rig.runtime.recorder import RecorderError
from rig.runtime.stop import StopRequests

EXIT_OK, EXIT_MISSED, EXIT_USAGE, EXIT_PREFLIGHT, EXIT_FAULT = 0, 1, 2, 3, 4
EXIT_BUG, EXIT_INTERRUPTED = 70, 130

_COMMAND = re.compile(r"(`rig \w+ )RIG\b")
"""A command in a message of what knows no rig's name."""


class Ending(NamedTuple):
    """The end of a run as its manifest tells it.

    Parameters
    ----------
    status : RunStatus
        How it ended.
    code : int
        Of the process.
    message : str or None
        What ended it early.
    bug : BaseException or None
        What is raised once the books are closed, for its traceback.
    flaw : str
        What its log shows to hunt, or to stick and slip, or what moved off when it was released: no
        such run ends well, even if it has no bound to miss.
    """

    status: RunStatus
    code: int
    message: str | None = None
    bug: BaseException | None = None
    flaw: str = ""

    def losing(self, trouble: str) -> "Ending":
        """Return the ending of a run part of whose results cannot be kept."""
        message = trouble if self.message is None else f"{self.message}; besides, {trouble}"
        if self.status in (RunStatus.OK, RunStatus.FAILED):
            return Ending(RunStatus.FAULTED, EXIT_FAULT, message)
        return self._replace(message=message)

    def judged(self, *, passed: bool) -> "Ending":
        """Return the ending of a run of which is known whether its metrics keep their bounds."""
        if self.status is RunStatus.OK and (self.flaw or not passed):
            return Ending(RunStatus.FAILED, EXIT_MISSED, self.flaw or None)
        return self

    def for_rig(self, argument: str) -> "Ending":
        """Return the same ending with a rig's name in the commands that its message gives.

        Parameters
        ----------
        argument : str
            What names the rig on a command line.
        """
        if self.message is None:
            return self
        return self._replace(message=say_for_rig(self.message, argument))


def say_for_rig(message: str, argument: str) -> str:
    """Return a message with a rig's name in the commands that it gives.

    Alarms know no name, and say `rig calibrate RIG friction`: that is to be copied.

    Parameters
    ----------
    message : str
        Of a fault, or a remark.
    argument : str
        What names the rig on a command line.
    """
    return _COMMAND.sub(lambda of: f"{of[1]}{argument}", message)


def ending_of(error: BaseException) -> Ending:
    """Return the ending of a run that an error has ended, before or after its loop."""
    if isinstance(error, KeyboardInterrupt) and whose_bug(error) is None:
        return Ending(RunStatus.ABORTED, EXIT_INTERRUPTED, "interrupted outside of the loop")
    if isinstance(error, RigError):
        code = EXIT_PREFLIGHT if isinstance(error, DeviceError) else EXIT_FAULT
        code = EXIT_USAGE if isinstance(error, ConfigurationError) else code
        return Ending(RunStatus.FAULTED, code, str(error))
    return bug_of(error)


def bug_of(error: BaseException, t: float | None = None) -> Ending:
    """Return the ending of a run that a bug has ended, of ours or of another package.

    Parameters
    ----------
    error : BaseException
        The bug.
    t : float, optional
        When it came, s after the run began.
    """
    lacking = missing_package(error)
    if lacking is not None:
        return Ending(RunStatus.CRASHED, EXIT_USAGE, lacking, error)
    what = said(error)
    place = whose_bug(error)
    if place is None:
        return Ending(RunStatus.CRASHED, EXIT_BUG, what, error)
    if not isinstance(error, Exception):  # it would end the program as it likes
        error = ContractBroken(f"{place} wants to end the program: {what}").with_traceback(
            error.__traceback__
        )
    when = "" if t is None else f" at {t:.3f} s of the log"
    return Ending(RunStatus.CRASHED, EXIT_USAGE, f"{place}{when}: {what}", error)


def broken_contract(sentence: str) -> Ending:
    """Return the ending of a run that failed by what another package's code returned."""
    return Ending(RunStatus.CRASHED, EXIT_USAGE, sentence, ContractBroken(sentence))


def fault_of(fault: Exception, t: float | None) -> Ending:
    """Return the ending of a run whose loop ended with a fault at `t` (s)."""
    if isinstance(fault, RecorderError):
        until = "" if t is None else f"; it ends before {t:.3f} s, what came then is lost"
        return Ending(RunStatus.FAULTED, EXIT_FAULT, f"{fault}{until}")
    if isinstance(fault, ContractBroken):
        return broken_contract(str(fault))
    if isinstance(fault, RigError | OSError):
        return Ending(RunStatus.FAULTED, EXIT_FAULT, str(fault))
    return bug_of(fault, t)


class ClosedBooks:
    """A context that closes a run's folder when an error leaves it, with what the error says.

    Parameters
    ----------
    folder : RunFolder
        Of a run that goes on.
    stop : StopRequests
        Shielded meanwhile: this is not to be torn.
    """

    def __init__(self, folder: RunFolder, stop: StopRequests) -> None:
        self._folder = folder
        self._stop = stop

    def __enter__(self) -> None:
        """Nothing is to be prepared."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is None:
            return
        self._stop.shield()
        status, code, message, *_ = ending_of(error)
        with contextlib.suppress(RigError):  # the disk may be what failed
            self._folder.record_event(None, "fault", str(message), type=type(error).__name__)
        with contextlib.suppress(RigError):
            self._folder.finish(status, code, message)
