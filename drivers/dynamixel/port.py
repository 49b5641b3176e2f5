"""Serial ports, as the bus uses them: bytes out and in, never waiting."""

import contextlib
import errno
import os
from pathlib import Path
from typing import Final, Protocol

from drivers.dynamixel.settings import SerialBusSettings
from drivers.terminal import check_terminal
from rig.hal import ConnectionFailed
from rig.hal.device_files import device_trouble

_IN_USE: Final = (errno.EAGAIN, errno.EBUSY)


class SerialPort(Protocol):
    """A serial port, or something that behaves like one."""

    def read(self, size: int) -> bytes:
        """Return what has come, at most `size` bytes; empty if nothing has.

        Raises
        ------
        OSError
            The port is gone.
        """

    def write(self, data: bytes) -> int:
        """Take bytes to be sent; return how many were taken.

        Raises
        ------
        OSError
            The port is gone.
        """

    def close(self) -> None:
        """Release the port. Idempotent."""


class TtyPort:
    """A terminal device: a USB adapter, a UART or a pseudo-terminal.

    pyserial opens and configures it. Bytes then go straight to the file, because pyserial
    spins in `write` for as long as a full buffer refuses them.

    Parameters
    ----------
    path : str
        Such as ``/dev/ttyUSB0``.
    baudrate : int
        bit/s.
    low_latency : bool
        Ask the driver for it; not every one can.

    Raises
    ------
    OSError, ValueError
        It is not there, in use, or does not know the baud rate.
    """

    def __init__(self, path: str, baudrate: int, *, low_latency: bool = True) -> None:
        import serial

        check_terminal(path)
        self._serial = serial.Serial(path, baudrate, timeout=0, exclusive=True)
        self._file: int = self._serial.fileno()
        if low_latency:
            with contextlib.suppress(OSError, ValueError, AttributeError):
                self._serial.set_low_latency_mode(True)
        self._serial.reset_input_buffer()

    def read(self, size: int) -> bytes:
        """Return what has come, at most `size` bytes."""
        try:
            return os.read(self._file, size)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> int:
        """Take bytes to be sent; return how many were taken."""
        try:
            return os.write(self._file, data)
        except BlockingIOError:
            return 0

    def close(self) -> None:
        """Release the port. Idempotent."""
        self._file = -1
        self._serial.close()


def open_port(settings: SerialBusSettings) -> SerialPort:
    """Open the adapter that a profile names.

    Raises
    ------
    ConnectionFailed
        It is not there, in use, not permitted, or does not know the baud rate.
    """
    try:
        return TtyPort(settings.port, settings.baudrate, low_latency=settings.low_latency)
    except (OSError, ValueError, OverflowError) as error:
        raise ConnectionFailed(
            settings.port,
            f"the serial port cannot be opened: {_trouble(settings.port, error)}",
            value=f"{settings.baudrate} bit/s",
        ) from error


def _trouble(port: str, error: Exception) -> str:
    """Return why a port cannot be opened, and what mends that."""
    number = error.errno if isinstance(error, OSError) else None
    if number is None:
        return str(error)
    if number in _IN_USE:
        return f"another program has it open; which one says: fuser -v {port}"
    return device_trouble(Path(port)) or str(error)
