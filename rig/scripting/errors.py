"""How a run may end from Python, as exceptions: the exit codes of the command line."""

from typing import TYPE_CHECKING

from rig.hal import ConfigurationError, RigError

if TYPE_CHECKING:
    from rig.scripting.recorded import Run


class RunError(RigError):
    """A run did not come to its end.

    Attributes
    ----------
    run : Run
        What there is of it: its folder is closed, and the rig is safe unless the message says
        otherwise.
    """

    def __init__(self, run: "Run", what: str | None = None) -> None:
        self.run = run
        super().__init__(f"{what or run.message or run.status} ({run.path})")


class BoundMissed(RunError):
    """It came to its end with a bound missed or a flaw (exit 1); asked for by ``strict=True``."""


class NotEnergised(RunError):
    """A device or the preflight refused: the rig was never energised (exit 3)."""


class RunFaulted(RunError):
    """A fault ended it (exit 4)."""


class MeasureFailed(RunError):
    """A measure given in Python raised, or returned no number; the run itself ended as it says."""


class CodeFailed(RunError, ConfigurationError):
    """Code that was given, or is of a package, raised or returned what it must not (exit 2)."""


class RunInterrupted(RunError, KeyboardInterrupt):
    """Somebody stopped it, and the rig was made safe (exit 130)."""


_BY_CODE: dict[int, type[RunError]] = {
    1: BoundMissed, 2: CodeFailed, 3: NotEnergised, 4: RunFaulted, 130: RunInterrupted,
}  # fmt: skip


def error_of(run: "Run", code: int, *, strict: bool) -> RunError | None:
    """Return the exception of an exit code; None if the run is to be handed over."""
    if code == 0 or (code == 1 and not strict):
        return None
    return _BY_CODE.get(code, RunError)(run)
