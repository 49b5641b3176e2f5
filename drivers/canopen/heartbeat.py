"""Heartbeats both ways: the master's, and a watch on each node's.

References
----------
CiA 301 V4.2, section 7.2.8.3.2.
"""

from enum import IntEnum
from math import inf
from typing import Final

from rig.hal import DeviceFault


class NmtState(IntEnum):
    """States as a heartbeat carries them."""

    BOOT_UP = 0x00
    STOPPED = 0x04
    OPERATIONAL = 0x05
    PRE_OPERATIONAL = 0x7F


_BOOT_UP: Final = int(NmtState.BOOT_UP)  # plain numbers: the cycle compares them, and a look-up
_OPERATIONAL: Final = int(NmtState.OPERATIONAL)  # of an enumeration's member takes 70 ns

_NAMES: Final = {
    NmtState.BOOT_UP: "booting",
    NmtState.STOPPED: "STOPPED",
    NmtState.OPERATIONAL: "OPERATIONAL",
    NmtState.PRE_OPERATIONAL: "PRE-OPERATIONAL",
}


def describe_state(state: int | None) -> str:
    """Return an NMT state in words."""
    if state is None:
        return "unknown"
    return _NAMES[NmtState(state)] if state in _NAMES else f"unknown state 0x{state:02X}"


class HeartbeatProducer:
    """Say when the master's heartbeat is due.

    It is asked from the cycle: a loop that stalls falls silent, and the nodes take their
    safe state.

    Parameters
    ----------
    period : float
        s.
    """

    __slots__ = ("due", "period")

    def __init__(self, period: float) -> None:
        self.period = period
        self.due = -inf

    def restart(self) -> None:
        """Have the next one sent at once."""
        self.due = -inf

    def sent(self, now: float) -> None:
        """Plan the next one; the period does not drift with the cycle."""
        following = self.due + self.period
        self.due = following if following > now else now + self.period


class HeartbeatWatch:
    """Watches a node's heartbeats: what they say, and that they come.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    node : int
        Its number.
    timeout : float
        After this silence it is lost, s.

    Attributes
    ----------
    state : int or None
        The last state that it reported.
    last : float
        When that was, s.
    boots : int
        How many boot-up messages came.
    good_until : float
        Up to when all is well if nothing else comes, s: while this is ahead, `check` has nothing
        to say and need not be called.
    """

    __slots__ = (
        "_armed",
        "_boots_at_arm",
        "boots",
        "good_until",
        "last",
        "name",
        "node",
        "state",
        "timeout",
    )

    def __init__(self, name: str, node: int, timeout: float) -> None:
        self.name = name
        self.node = node
        self.timeout = timeout
        self.state: int | None = None
        self.last = -inf
        self.boots = 0
        self.good_until = inf
        self._armed = False
        self._boots_at_arm: int

    def receive(self, data: bytes, now: float) -> None:
        """Take a frame with the node's error-control identifier."""
        if len(data) != 1:
            return
        state = data[0] & 0x7F  # bit 7 is the toggle bit of node guarding
        if state == _BOOT_UP:
            self.boots += 1
        self.state = state
        self.last = now
        self._judge()

    def forget(self) -> None:
        """Not know the state until the next heartbeat says it."""
        self.state = None
        self._judge()

    def arm(self) -> None:
        """Expect OPERATIONAL from now on."""
        self._boots_at_arm = self.boots
        self._armed = True
        self._judge()

    def disarm(self) -> None:
        """Expect nothing."""
        self._armed = False
        self._judge()

    def check(self, now: float) -> None:
        """Raise if an armed node is not in OPERATIONAL.

        Raises
        ------
        DeviceFault
            It rebooted, left OPERATIONAL, or fell silent.
        """
        if not self._armed:
            return
        if self.boots != self._boots_at_arm:
            raise DeviceFault(
                self.name,
                "the node rebooted while running; it has lost its configuration and stays "
                "out of use until it is connected and armed again",
                node=self.node,
            )
        if self.state != _OPERATIONAL:
            raise DeviceFault(
                self.name,
                "the node left OPERATIONAL by itself",
                node=self.node,
                value=describe_state(self.state),
                bound="OPERATIONAL",
            )
        if now - self.last > self.timeout:
            raise DeviceFault(
                self.name,
                "the node's heartbeat is lost",
                node=self.node,
                value=f"{now - self.last:.3f} s of silence",
                bound=f"{self.timeout:g} s",
            )

    def _judge(self) -> None:
        if not self._armed:
            self.good_until = inf
        elif self.state == _OPERATIONAL and self.boots == self._boots_at_arm:
            self.good_until = self.last + self.timeout
        else:
            self.good_until = -inf
