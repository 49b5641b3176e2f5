"""Write every frame of a rig's buses to a file, as they pass.

A frame is in the kernel's hands before the program goes on: what was recorded survives a
program that is killed (a torn last line at most), and not a machine that loses power. All the
frames that one look at a bus brings are one write, and so is each frame that is sent.

Who sent a frame stands in a file beside it, a letter for each line: R received, T sent. Wireshark
reads candump's lines only without that letter.
"""

import contextlib
import os
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from drivers.can.candump import format_frame
from rig.hal import Clock, ConfigurationError, FastCanBus

WAYS: Final = ".ways"
"""Ending of the file that says who sent each frame."""
RECEIVED, SENT = b"R", b"T"
_NEW: Final = os.O_WRONLY | os.O_CREAT | os.O_EXCL


class FrameLog:
    """A file of frames from all buses of a rig, in candump's format.

    What cannot be written is not recorded and never raised: a full disk must not stop a rig.

    Attributes
    ----------
    count : int
        Frames on file.
    lost : int
        Frames that could not be written.
    """

    def __init__(self) -> None:
        self.count = 0
        self.lost = 0
        self._fd = self._ways = -1
        self._end = 0
        self._failed: OSError | None = None
        self._origin: float | None = None

    def start(self, path: Path) -> None:
        """Make the file; frames that passed before are not in it.

        Raises
        ------
        ConfigurationError
            It cannot be made.
        """
        try:
            self._fd = os.open(path, _NEW, 0o644)
            self._ways = os.open(path.with_suffix(WAYS), _NEW, 0o644)
        except OSError as error:
            raise ConfigurationError(f"cannot record frames in {path}: {error.strerror}") from error

    def tap(self, name: str, clock: Clock, bus: FastCanBus) -> FastCanBus:
        """Return a bus that records what passes through it.

        Parameters
        ----------
        name : str
            What the file calls it.
        clock : Clock
            The rig's.
        bus : FastCanBus
            Open; it is owned from now on.
        """
        return RecordedBus(name, clock, bus, self)

    def origin(self, clock: Clock) -> float:
        """Return the wall-clock time (s since the epoch) of a rig's time 0, one for all buses."""
        if self._origin is None:
            self._origin = time.time() - clock.now()
        return self._origin

    def facts(self, clock: Clock) -> dict[str, float]:
        """Return what a run's manifest says of its frames; the origin is that of `origin`."""
        return {"recorded": self.count, "lost": self.lost, "origin": self.origin(clock)}

    def write(self, text: str, frames: int, way: bytes) -> None:
        """Append whole lines of frames that went one way. Hot path."""
        if self._fd < 0 or self._failed is not None:
            self.lost += frames
            return
        data = text.encode("ascii", "replace")
        try:
            done = os.write(self._fd, data)
            if done != len(data):
                self._write_rest(data[done:])
        except OSError as error:
            self._failed = error
            self.lost += frames
            with contextlib.suppress(OSError):
                os.ftruncate(self._fd, self._end)
            return
        self._end += len(data)
        self.count += frames
        with contextlib.suppress(OSError):  # a replay will say what is missing
            os.write(self._ways, way * frames)

    def close(self) -> str | None:
        """Release the file; return what was wrong with it, if something was. Idempotent."""
        for descriptor in (self._fd, self._ways):
            if descriptor >= 0:
                os.close(descriptor)
        self._fd = self._ways = -1
        if self._failed is None:
            return None
        return (
            f"{self.lost} frames of the buses could not be written: "
            f"{self._failed.strerror or self._failed}"
        )

    def _write_rest(self, data: bytes) -> None:
        while data:
            data = data[os.write(self._fd, data) :]


class RecordedBus(FastCanBus):
    """A CAN interface whose frames are recorded.

    What is received bears the time at which it was taken from the interface, on the rig's
    clock, moved to the wall clock's origin at the opening.

    Parameters
    ----------
    name : str
        What the file calls it.
    clock : Clock
        The rig's.
    bus : FastCanBus
        The interface itself.
    log : FrameLog
        Where the frames go.
    """

    def __init__(self, name: str, clock: Clock, bus: FastCanBus, log: FrameLog) -> None:
        self._bus = bus
        self._name = name.replace(" ", "_")
        self._now = clock.now
        self._origin = log.origin(clock)
        self._write = log.write
        self._drain = bus.drain
        self._send = bus.send_data

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """Return the waiting frames, at most `limit`, as (identifier with flags, data)."""
        frames = self._drain(limit)
        if frames:
            head = f"({self._origin + self._now():.6f}) {self._name} "
            lines = [f"{head}{format_frame(i, d)}\n" for i, d in frames]
            self._write("".join(lines), len(frames), RECEIVED)
        return frames

    def send_data(self, can_id: int, data: bytes) -> None:
        """Queue a frame given by identifier (with flags) and data."""
        self._send(can_id, data)
        head = f"({self._origin + self._now():.6f}) {self._name} "
        self._write(f"{head}{format_frame(can_id, data)}\n", 1, SENT)

    def accept(self, can_ids: Iterable[int]) -> None:
        """Do nothing: what nobody here waits for belongs on file too."""

    def backlog(self) -> int:
        """Return how many frames the interface has not taken yet."""
        return self._bus.backlog()

    def count_dropped(self) -> int:
        """Return how many frames were lost since nobody took them in time."""
        return self._bus.count_dropped()

    def fileno(self) -> int:
        """Return what to wait for, or -1."""
        return self._bus.fileno()

    def shutdown(self) -> None:
        """Release the interface."""
        self._bus.shutdown()
