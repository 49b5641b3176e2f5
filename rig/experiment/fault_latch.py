"""A fault on hardware that outlives the process: no run until an operator has reset it.

One small file per rig in the user's state folder (``$XDG_STATE_HOME/rig``, by default
``~/.local/state/rig``), so that other run folders, other working folders and a reboot of the host
change nothing. It is written before a rig is energised and removed when its run has ended without a
fault: a program that was killed leaves it behind too.
"""

import json
import os
from datetime import UTC, datetime
from pathlib import Path

from rig.experiment.ending import EXIT_PREFLIGHT, Ending
from rig.hal import ConfigurationError, DeviceError
from rig.hal.files import read_regular, users_folder
from rig.run_facts import RunStatus

_DIED = "the program ended while the rig was energised, and did not say why"
_HARMLESS = (RunStatus.OK, RunStatus.FAILED, RunStatus.ABORTED)

_MOST = 1 << 16
"""Bytes of a file with a fault."""


class FaultLatched(DeviceError):
    """The rig had a fault that nobody has reset."""


class FaultLatch:
    """The latched fault of one rig.

    Parameters
    ----------
    rig : str
        Its profile's name.
    argument : str, optional
        What a command line names it by; default: the name.
    """

    def __init__(self, rig: str, argument: str | None = None) -> None:
        self.rig = rig
        self._argument = argument or rig
        self.path = users_folder("XDG_STATE_HOME", ".local", "state") / "rig" / f"{rig}.fault"

    def reason(self) -> str | None:
        """Return what latched it, and when; None: nothing did.

        A file that cannot be read latches as well: it may hold a fault.
        """
        try:
            self.path.lstat()  # what cannot be looked at may hold a fault, too
            kept = json.loads(read_regular(self.path, _MOST).decode())
            return f"{kept['fault']} ({kept['since']}, {kept['run']})"
        except FileNotFoundError:
            return None
        except (
            ConfigurationError, OSError, ValueError, KeyError, TypeError, RecursionError,
        ) as error:  # fmt: skip
            return f"{self.path} cannot be read: {error}"

    def check(self) -> None:
        """Raise if there is a fault that nobody has reset.

        Raises
        ------
        FaultLatched
            With the command that resets it.
        """
        reason = self.reason()
        if reason is not None:
            raise FaultLatched(
                self.rig,
                f"its last fault is latched: {reason}; find the cause and mend it, "
                f"then: rig reset {self._argument}",
            )

    def set(self, run: Path, fault: str = _DIED) -> None:
        """Latch a fault; it is on the disk when this returns.

        Raises
        ------
        DeviceError
            It cannot be kept.
        """
        since = datetime.now(UTC).isoformat(timespec="seconds")
        text = json.dumps({"fault": fault, "since": since, "run": str(run)}, ensure_ascii=False)
        temporary = self.path.with_suffix(f".{os.getpid()}")
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with temporary.open("w", encoding="utf-8") as stream:
                stream.write(text + "\n")
                stream.flush()
                os.fsync(stream.fileno())
            temporary.replace(self.path)
        except OSError as error:
            raise DeviceError(
                self.rig, f"a fault could not be latched in {self.path}: {error.strerror or error}"
            ) from error

    def clear(self) -> None:
        """Forget it.

        Raises
        ------
        DeviceError
            It stays.
        """
        try:
            self.path.unlink(missing_ok=True)
        except OSError as error:
            raise DeviceError(
                self.rig, f"{self.path} cannot be removed: {error.strerror or error}"
            ) from error

    def settle(self, run: Path, ending: Ending) -> str | None:
        """Keep a run's fault, or forget that it ran; return what the operator has to know."""
        try:
            if ending.status in _HARMLESS or ending.code == EXIT_PREFLIGHT:
                self.clear()
                return None
            self.set(run, str(ending.message))
        except DeviceError as error:  # what was written before the rig was energised still latches
            return str(error)
        remedy = f"rig reset {self._argument}"
        return f"{self.rig} is latched: find the cause and mend it, then: {remedy}"
