"""A fault on hardware that outlives the process: no run until an operator has reset it.

One small file per rig in the user's state folder (``$XDG_STATE_HOME/rig``, by default
``~/.local/state/rig``), so that other run folders, other working folders and a reboot of the host
change nothing; another profile of the same wires meets it as well. It is written before a rig is
energised and removed when its run has ended without a fault: a program that was killed leaves it
behind too.
"""

import json
import os
from collections.abc import Collection
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from rig.assembly import Backend
from rig.assembly.on_interfaces import parse_interfaces
from rig.config import Profile
from rig.experiment.ending import EXIT_PREFLIGHT, Ending
from rig.hal import ConfigurationError, DeviceError
from rig.hal.files import read_regular, users_folder
from rig.run_facts import RunStatus

_DIED = "the program ended while the rig was energised, and did not say why"
_HARMLESS = (RunStatus.OK, RunStatus.FAILED, RunStatus.ABORTED)

_UNREADABLE = (ConfigurationError, OSError, ValueError, KeyError, TypeError, RecursionError)

_MOST = 1 << 16
"""Bytes of a file with a fault."""


class FaultLatched(DeviceError):
    """The rig had a fault that nobody has reset, or one that is on its wires had.

    Parameters
    ----------
    rig : str
        Which does not run.
    what : str
        Is latched, why, and since when.
    remedy : str
        The command that resets it.
    """

    def __init__(self, rig: str, what: str, remedy: str) -> None:
        super().__init__(rig, f"{what}; find the cause and mend it, then: {remedy}")
        self.told = what
        self.remedy = remedy


class FaultLatch:
    """The latched fault of one rig.

    Parameters
    ----------
    rig : str
        Its profile's name.
    argument : str, optional
        What a command line names it by; default: the name.
    wires : collection of str
        The interfaces that it is on: whatever else is on one of them is latched, too.
    """

    def __init__(self, rig: str, argument: str | None = None, wires: Collection[str] = ()) -> None:
        self.rig = rig
        self._argument = argument or rig
        self._wires = sorted(wires)
        self.path = users_folder("XDG_STATE_HOME", ".local", "state") / "rig" / f"{rig}.fault"

    @classmethod
    def of(cls, profile: Profile, on: str | None = None) -> "FaultLatch":
        """Return the latch of a profile, or of its devices on other interfaces.

        Parameters
        ----------
        profile : Profile
            On hardware.
        on : str, optional
            The interfaces that its CAN buses are on instead; see `parse_interfaces`.

        Raises
        ------
        ConfigurationError
            `on` does not fit the profile's buses.
        """
        others = {} if on is None or on in list(Backend) else parse_interfaces(on, profile)
        ends = [
            replace(entry.settings, **others.get(name, {})).endpoint()
            for name, entry in profile.buses.items()
        ]
        wires = {f"{end.interface} {end.channel}" for end in ends}
        return cls(profile.name, profile.argument, wires)

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
        except _UNREADABLE as error:
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
            what = f"its last fault is latched: {reason}"
            raise FaultLatched(self.rig, what, f"rig reset {self._argument}")
        for path in sorted(self.path.parent.glob("*.fault")):
            self._check_beside(path)

    def _check_beside(self, path: Path) -> None:
        """Raise if another rig of the same wires has latched a fault."""
        try:
            kept = json.loads(read_regular(path, _MOST).decode())
            shared = sorted(set(kept["wires"]) & set(self._wires))
            told = f"{kept['fault']} ({kept['since']}, {kept['run']})"
            remedy = f"rig reset {kept['argument']}"
        except _UNREADABLE:
            return  # it latches its own rig; nobody knows which wires it is on
        if shared:
            what = f"{path.stem} is on {shared[0]} as well, and its last fault is latched: {told}"
            raise FaultLatched(self.rig, what, remedy)

    def set(self, run: Path, fault: str = _DIED) -> None:
        """Latch a fault; it is on the disk when this returns.

        Raises
        ------
        DeviceError
            It cannot be kept.
        """
        since = datetime.now(UTC).isoformat(timespec="seconds")
        whose = {"argument": self._argument, "wires": self._wires}
        text = json.dumps(
            {"fault": fault, "since": since, "run": str(run), **whose}, ensure_ascii=False
        )
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
