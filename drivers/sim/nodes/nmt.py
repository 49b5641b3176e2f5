"""Network management of an emulated node: states, commands, heartbeats both ways.

References
----------
CiA 301 V4.2, sections 7.2.8 (NMT) and 7.3.2 (state machine); objects 0x1016, 0x1017.
"""

from collections.abc import Callable
from enum import IntEnum
from math import inf

from drivers.sim.nodes.object_dictionary import (
    UNSIGNED16,
    UNSIGNED32,
    Abort,
    ObjectDictionary,
    SdoAbortError,
    Variable,
)

_WATCHED = 4
"""Sub-indices of 0x1016: nodes that can be watched."""


class NmtState(IntEnum):
    """States as the heartbeat carries them."""

    INITIALISING = 0x00
    STOPPED = 0x04
    OPERATIONAL = 0x05
    PRE_OPERATIONAL = 0x7F


class NmtCommand(IntEnum):
    """Commands as the master sends them."""

    START = 0x01
    STOP = 0x02
    ENTER_PRE_OPERATIONAL = 0x80
    RESET_NODE = 0x81
    RESET_COMMUNICATION = 0x82


class HeartbeatProducer:
    """Send the state at the period in 0x1017, and at once when the state changes."""

    def __init__(
        self, dictionary: ObjectDictionary, send: Callable[[int], None], wake: Callable[[], None]
    ) -> None:
        self._send = send
        self._wake = wake
        self.due = inf
        self._period = dictionary.add(0x1017, 0, Variable(UNSIGNED16, 0, changed=self.restart))

    def reset(self) -> None:
        """Stop: the default is no heartbeat."""
        self.due = inf

    def restart(self) -> None:
        """Send one as soon as possible and the next a period later, if a period is set."""
        self.due = -inf if self._period.value else inf
        self._wake()

    def tick(self, now: float, state: NmtState) -> None:
        """Send if due; the period does not drift with the caller's step."""
        if now < self.due:
            return
        self._send(state)
        period = self._period.integer * 1e-3
        following = self.due + period
        self.due = following if following > now else now + period


class _Watch:
    """One monitored node."""

    __slots__ = ("deadline", "lost", "timeout")

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout
        self.deadline = inf  # monitoring starts with the first heartbeat
        self.lost = False


class HeartbeatConsumer:
    """Watch the nodes in 0x1016.

    Parameters
    ----------
    dictionary : ObjectDictionary
        Gets object 0x1016.
    lost : callable
        Takes the node whose heartbeat stopped.
    found : callable
        Takes the node whose heartbeat came back.
    changed : callable
        Called when other nodes are watched than before.
    """

    def __init__(
        self,
        dictionary: ObjectDictionary,
        lost: Callable[[int], None],
        found: Callable[[int], None],
        changed: Callable[[], None],
    ) -> None:
        self._lost = lost
        self._found = found
        self._changed = changed
        self._watches: dict[int, _Watch] = {}
        self.due = inf
        self._entries: list[Variable] = []
        for _ in range(_WATCHED):
            entry = Variable(UNSIGNED32, 0, changed=self.configure)
            entry.check = lambda value, entry=entry: self._check(entry, value)
            self._entries.append(entry)
        dictionary.add_array(0x1016, self._entries)

    def _check(self, entry: Variable, value: int) -> None:
        node, timeout = _split(value)
        if node > 127 or value >> 24:
            raise SdoAbortError(Abort.RANGE)
        for other in self._entries:
            if other is not entry and node and timeout and _split(other.integer)[0] == node:
                raise SdoAbortError(Abort.INCOMPATIBLE_PARAMETER)

    def configure(self) -> None:
        """Take the entries as they are now; monitoring starts anew."""
        pairs = (_split(entry.integer) for entry in self._entries)
        self._watches = {node: _Watch(ms * 1e-3) for node, ms in pairs if node and ms}
        self.due = inf
        self._changed()

    @property
    def nodes(self) -> tuple[int, ...]:
        """The nodes that are watched."""
        return tuple(self._watches)

    def receive(self, node: int, state: int, now: float) -> None:
        """Take a heartbeat or boot-up message of another node."""
        watch = self._watches.get(node)
        if watch is None:
            return
        if state == NmtState.INITIALISING:
            # It restarted: its outputs and settings are gone, which is a loss as well.
            if watch.deadline < inf:
                self._declare_lost(node, watch)
            return
        watch.deadline = now + watch.timeout
        self.due = min(self.due, watch.deadline)
        if watch.lost:
            watch.lost = False
            self._found(node)

    def tick(self, now: float) -> None:
        """Report the nodes that have been silent for too long."""
        if now < self.due:
            return
        for node, watch in self._watches.items():
            if now >= watch.deadline:
                self._declare_lost(node, watch)
        self.due = min((watch.deadline for watch in self._watches.values()), default=inf)

    def _declare_lost(self, node: int, watch: _Watch) -> None:
        watch.deadline = inf
        if not watch.lost:
            watch.lost = True
            self._lost(node)


def _split(value: int) -> tuple[int, int]:
    """Return (node, time in ms) of an entry of 0x1016."""
    return value >> 16 & 0xFF, value & 0xFFFF
