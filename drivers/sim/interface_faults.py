"""What the master's CAN interface may suffer: its queue full, its controller off, its link down."""

import errno
from collections.abc import Callable
from typing import Final

from drivers.can.frame import ERROR_FLAG
from drivers.sim.can_line import CanLineEnd

_BUS_OFF: Final = ERROR_FLAG | 0x040
_CONTROLLER: Final = ERROR_FLAG | 0x004
_PASSIVE: Final = bytes((0, 0x30, 0, 0, 0, 0, 0, 0))

_FULL: Final = OSError(errno.ENOBUFS, "No buffer space available")
_DOWN: Final = OSError(errno.ENETDOWN, "Network is down")


class InterfaceFaults:
    """The faults of the interface by which the master is on an emulated bus.

    ``no_buffers``
        What it sends is refused, as where nobody acknowledges frames and its queue is full.
    ``bus_off``
        Its controller has left the bus: an error frame says so, and nothing passes either way.
    ``error_passive``
        An error frame says that its controller counts too many errors; frames still pass.
    ``link_down``
        The interface was taken down.

    Each but ``error_passive`` has a value: how long it lasts, s; for ever if there is none.

    Parameters
    ----------
    end : CanLineEnd
        The nodes' end of the line.
    """

    known = ("no_buffers", "bus_off", "error_passive", "link_down")

    def __init__(self, end: CanLineEnd) -> None:
        self._end = end
        self.severed = False
        """Whether no frame passes either way."""

    def inject(self, fault: str) -> Callable[[], None]:
        """Make one of `known` happen now; return what ends it."""
        if fault == "error_passive":
            self._end.send_data(_CONTROLLER, _PASSIVE)
        else:
            if fault == "bus_off":
                self._end.send_data(_BUS_OFF, bytes(8))
            self._end.trouble_other(_DOWN if fault == "link_down" else _FULL)
            self.severed = fault != "no_buffers"
        return self._end_trouble

    def _end_trouble(self) -> None:
        self._end.trouble_other(None)
        self.severed = False
