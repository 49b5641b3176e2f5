"""The `canopen` library without threads: it configures nodes in the rig's own time.

Instead of a notifier thread, sending an SDO request receives from the bus until the answer
has come or the rig's clock says that it never will.
"""

import logging
from collections.abc import Callable
from typing import Any, Final, Protocol

import canopen

_SDO_REQUESTS: Final = range(0x601, 0x680)
_REQUEST_TO_ANSWER: Final = -0x80
_ABORT: Final = 0x80
_ATTEMPTS: Final = 3

# Its complaints reach the user as exceptions that name device, node and object.
logging.getLogger("canopen").addHandler(logging.NullHandler())


class PumpedBus(Protocol):
    """A bus that receives when it is told to."""

    def send(self, can_id: int, data: bytes) -> None:
        """Send one frame now."""

    def wait_until(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Receive until a condition holds, or for `timeout` (s); return whether it does."""


class ThreadlessNetwork(canopen.Network):
    """A `canopen.Network` that sends and receives by a bus of ours.

    Parameters
    ----------
    bus : PumpedBus
        Sends and receives for it.
    timeout : float
        How long it waits for an answer, s.
    """

    def __init__(self, bus: PumpedBus, timeout: float) -> None:
        super().__init__()
        self._pumped_bus = bus
        self._timeout = timeout
        self._answers: dict[int, int] = {}
        self._requests: dict[int, int] = {}
        self.strange = 0
        """Answers of nodes that are not connected yet."""

    def add(self, node: int) -> Any:
        """Return the SDO client of a node; its answers are taken from the bus."""
        library: Any = canopen  # typed in part only
        remote = library.RemoteNode(node, library.ObjectDictionary())
        # The answer is in the queue before the client looks for it, or it never comes.
        remote.sdo.RESPONSE_TIMEOUT = 0.0
        # A frame may get lost; every transfer here may be repeated without harm.
        remote.sdo.MAX_RETRIES = _ATTEMPTS
        remote.sdo.RETRY_DELAY = 0.0
        self.add_node(remote)
        self._answers[0x580 + node] = self._requests[0x580 + node] = 0
        return remote.sdo

    def take_answer(self, can_id: int, data: bytes, now: float) -> None:
        """Hand an SDO answer to the library.

        One of a node that nobody talks to yet is not for this program: another master's.
        """
        if can_id not in self._answers:
            self.strange += 1
            return
        if len(data) != 8:  # no SDO; the request times out if nothing better comes
            return
        self._answers[can_id] += 1
        self.notify(can_id, bytearray(data), now)

    def surplus(self, node: int) -> int:
        """Return how many more answers a node number has given than it was asked questions."""
        return self._answers[0x580 + node] - self._requests[0x580 + node]

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        """Send a frame; after an SDO request, receive until it is answered."""
        bus = self._pumped_bus
        answer = can_id + _REQUEST_TO_ANSWER
        waits = can_id in _SDO_REQUESTS and answer in self._answers and data[0] != _ABORT
        before = self._answers.get(answer, 0)
        if waits:
            self._requests[answer] += 1
        bus.send(can_id, bytes(data))
        if waits:
            bus.wait_until(lambda: self._answers[answer] != before, self._timeout)
