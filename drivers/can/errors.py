"""What a CAN interface says of itself: error frames, refused frames, a link that is down.

References
----------
``linux/can/error.h``: classes in the identifier of an error frame, controller state in its
second data byte. Other interfaces of python-can send error frames without a class.
"""

import errno
from typing import Final

from rig.hal import DeviceFault

_BUS_OFF: Final = 0x040
_CONTROLLER: Final = 0x004
_RESTARTED: Final = 0x100
_OVERFLOW: Final = 0x03  # of the second data byte: receive 0x01, transmit 0x02
_PASSIVE: Final = 0x30  # of the second data byte: receiver 0x10, transmitter 0x20
_QUEUE_FULL: Final = (errno.ENOBUFS, errno.EAGAIN)
_LINK_DOWN: Final = (errno.ENETDOWN, errno.ENODEV, errno.ENXIO)


class BusErrors:
    """Counters of a bus's errors, and the first of those that are a fault.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    max_refused : int
        Cycles in a row in which a frame may be refused.

    Attributes
    ----------
    error_frames, refused, lost : int
        How many there were; `lost` are the error frames that say that frames were.
    """

    __slots__ = (
        "_max_refused",
        "_name",
        "_refused_in_a_row",
        "_trouble",
        "error_frames",
        "lost",
        "refused",
    )

    def __init__(self, name: str, max_refused: int) -> None:
        self._name = name
        self._max_refused = max_refused
        self._trouble: DeviceFault | None = None
        self._refused_in_a_row = 0
        self.error_frames = 0
        self.refused = 0
        self.lost = 0

    def receive(self, classes: int, data: bytes) -> None:
        """Take an error frame: its classes and data."""
        self.error_frames += 1
        if classes & _CONTROLLER and len(data) > 1 and data[1] & _OVERFLOW:
            self.lost += 1
        if classes & _BUS_OFF:
            self._latch("the controller went bus-off", "bus-off")
        elif classes & _RESTARTED:
            self._latch(
                "the controller restarted after bus-off; the nodes may have missed anything, "
                "so they must be connected and armed again",
                "restarted",
            )
        elif classes & _CONTROLLER and len(data) > 1 and data[1] & _PASSIVE:
            self._latch(
                "the controller is error passive; look at cable and termination, and whether all "
                "devices run at the interface's bit rate (ip -details link show)",
                "passive",
            )

    def refuse(self, error: Exception) -> None:
        """Take an error of sending: this cycle's frames are not tried again."""
        self.refused += 1
        self._refused_in_a_row += 1
        code = error_number(error)
        if code in _LINK_DOWN:
            self.lose(error)
        elif code not in _QUEUE_FULL:
            self._latch(f"the interface refused a frame: {error}", None)
        elif self._refused_in_a_row > self._max_refused:
            self._latch(
                "the interface's transmit queue is full: nobody acknowledges the frames (cable, "
                "power, bit rate), or the queue is too short (sudo ip link set … txqueuelen 100)",
                f"{self._refused_in_a_row} cycles refused",
                f"{self._max_refused} cycles in a row",
            )

    def lose(self, error: Exception) -> None:
        """Take an error of receiving."""
        if error_number(error) in _LINK_DOWN:
            self._latch("the interface went down while in use", "link down")
        else:
            self._latch(f"the interface failed while receiving: {error}", None)

    def share(self, what: str) -> None:
        """Take note that somebody else sends what only this program is to send."""
        self._latch(f"another master is on the bus: {what}", None)

    def sent(self) -> None:
        """Take a cycle whose frames were all accepted."""
        self._refused_in_a_row = 0

    def check(self) -> None:
        """Raise the first fault, if there was one.

        Raises
        ------
        DeviceFault
            Bus-off, restarted, error passive, link down, or frames refused for too long.
        """
        if self._trouble is not None:
            raise self._trouble

    @property
    def fault(self) -> DeviceFault | None:
        """The first fault, if there was one."""
        return self._trouble

    @property
    def latched(self) -> bool:
        """Whether there was a fault; from then on only what is safe is sent."""
        return self._trouble is not None

    def _latch(self, what: str, value: str | None, bound: str | None = None) -> None:
        if self._trouble is None:
            self._trouble = DeviceFault(self._name, what, value=value, bound=bound)


def error_number(error: Exception) -> int | None:
    """Return the errno of an error; python-can keeps it under a name of its own."""
    if isinstance(error, OSError):
        return error.errno
    from can import CanError

    return error.error_code if isinstance(error, CanError) else None
