"""The emergency producer of an emulated node, with error register and history.

References
----------
CiA 301 V4.2, section 7.2.7 (emergency object) and objects 0x1001, 0x1003, 0x1014, 0x1015.
"""

from collections import deque
from collections.abc import Callable
from functools import partial
from math import inf

from drivers.sim.nodes.object_dictionary import (
    UNSIGNED8,
    UNSIGNED16,
    UNSIGNED32,
    Abort,
    ObjectDictionary,
    SdoAbortError,
    Variable,
)

HISTORY_LENGTH = 8

# Bits of the error register 0x1001.
GENERIC, COMMUNICATION, PROFILE = 0x01, 0x10, 0x20

# Error codes (CiA 301 table 26).
NO_ERROR = 0x0000
SENSOR_FAULT = 0x7300
HEARTBEAT_ERROR = 0x8130
RPDO_TOO_SHORT = 0x8210
RPDO_TOO_LONG = 0x8220
SYNC_LENGTH = 0x8240
RPDO_TIMEOUT = 0x8250


class Emergency:
    """Keep the errors that are present and tell the bus when they come and go.

    A condition is reported once when it appears and once, with code 0, when it is gone;
    that is what CANopenNode does, and what keeps a persistent error from filling the bus.

    Parameters
    ----------
    dictionary : ObjectDictionary
        Gets the objects of this service.
    node_id : int
        Of the node, 1 … 127.
    send : callable
        Takes a CAN id and 8 bytes.
    """

    def __init__(
        self, dictionary: ObjectDictionary, node_id: int, send: Callable[[int, bytes], None]
    ) -> None:
        self._send = send
        self._present: dict[str, tuple[int, int]] = {}
        self._queue: deque[bytes] = deque(maxlen=16)
        self.due = inf
        self._blocked_until = -inf
        self._register = dictionary.add(0x1001, 0, Variable(UNSIGNED8, 0, "ro", mapping="t"))
        self._count = dictionary.add(0x1003, 0, Variable(UNSIGNED8, 0, check=_only_zero))
        self._count.changed = self._clear_history
        self._history = [
            dictionary.add(
                0x1003,
                sub,
                Variable(UNSIGNED32, 0, "ro", refresh=partial(self._check_stored, sub)),
            )
            for sub in range(1, HISTORY_LENGTH + 1)
        ]
        self._cob_id = dictionary.add(
            0x1014, 0, Variable(UNSIGNED32, 0x80 + node_id, check=_check_cob_id)
        )
        self._inhibit = dictionary.add(0x1015, 0, Variable(UNSIGNED16, 0))

    def reset(self) -> None:
        """Forget all errors, as a restart does; the objects themselves are restored elsewhere."""
        self._present.clear()
        self._queue.clear()
        self._blocked_until = -inf
        self.due = inf

    def raise_error(self, condition: str, code: int, register: int, info: bytes = b"") -> None:
        """Report that a condition is present, unless it is known already."""
        if condition in self._present:
            return
        self._present[condition] = (code, register | GENERIC)
        self._update_register()
        self._remember(code)
        self._report(code, info)

    def clear_error(self, condition: str) -> None:
        """Report that a condition is gone, if it was present."""
        if self._present.pop(condition, None) is not None:
            self._update_register()
            self._report(NO_ERROR, b"")

    def clear_injected(self) -> None:
        """Report that all errors made by fault injection are gone."""
        for condition in [name for name in self._present if name.startswith("injected")]:
            self.clear_error(condition)

    def tick(self, now: float, *, allowed: bool) -> None:
        """Send what waits, where the NMT state allows it and the inhibit time has passed."""
        while self._queue and allowed and now >= self._blocked_until:
            data = self._queue.popleft()
            if not self._cob_id.integer >> 31:
                self._send(self._cob_id.integer & 0x7FF, data)
                self._blocked_until = now + self._inhibit.integer * 1e-4
        self.due = self._blocked_until if self._queue and allowed else inf

    @property
    def present(self) -> bool:
        """Whether any error is present."""
        return bool(self._present)

    def _update_register(self) -> None:
        register = 0
        for _, bits in self._present.values():
            register |= bits
        self._register.value = register

    def _report(self, code: int, info: bytes) -> None:
        self._queue.append(
            code.to_bytes(2, "little") + bytes((self._register.integer,)) + info[:5].ljust(5, b"\0")
        )

    def _remember(self, code: int) -> None:
        for older, newer in zip(self._history[:0:-1], self._history[-2::-1], strict=True):
            older.value = newer.value
        self._history[0].value = code
        self._count.value = min(self._count.integer + 1, HISTORY_LENGTH)

    def _clear_history(self) -> None:
        for entry in self._history:
            entry.value = 0

    def _check_stored(self, sub: int) -> None:
        if sub > self._count.integer:
            raise SdoAbortError(Abort.NO_DATA)


def _only_zero(value: int) -> None:
    if value != 0:
        raise SdoAbortError(Abort.RANGE)


def _check_cob_id(value: int) -> None:
    if value & 0x7FFFF800:
        raise SdoAbortError(Abort.RANGE)
