"""The cyclic reading of a chain: who answered, who did not, and why."""

from collections.abc import Iterable
from typing import Final

from drivers.dynamixel.codec import (
    BROADCAST_ID,
    Status,
    compute_fast_length,
    decode_fast_status,
    decode_status,
    encode_sync_read,
)
from drivers.dynamixel.parser import StatusParser
from drivers.dynamixel.registers import ALERT, describe_status_error
from rig.hal import DeviceFault

_SILENT: Final = "silent"
_DAMAGED: Final = "damaged"


class ServoLink:
    """A record of one servo's answers.

    Attributes
    ----------
    data : bytes
        What it answered last.
    fresh : bool
        Whether that was in this cycle.
    alert : bool
        Whether it then said that it has a hardware error.
    missed : int
        Cycles in a row without a good answer.
    doubled : int
        Cycles in a row with more than one.
    """

    __slots__ = ("alert", "cause", "data", "device", "doubled", "fresh", "id", "joint", "missed")

    def __init__(self, servo: int, device: str, joint: str) -> None:
        self.id = servo
        self.device = device
        self.joint = joint
        self.restart()

    def restart(self) -> None:
        """Know nothing of it yet."""
        self.data = b""
        self.fresh = False
        self.alert = False
        self.missed = 0
        self.doubled = 0
        self.cause = _SILENT


class CyclicRead:
    """The one sync read of a cycle, and its answers.

    A servo that stays silent is asked last in the next cycle: each servo speaks when it has
    heard the one before it, so that a silent one at the end hides nobody else.

    Parameters
    ----------
    fast : bool
        All servos answer in one packet.
    fault_after : int
        Answers missed, damaged or doubled in a row that are a fault.
    """

    def __init__(self, *, fast: bool, fault_after: int) -> None:
        self._fast = fast
        self._fault_after = fault_after
        self._links: dict[int, ServoLink] = {}
        self._active: list[int] = []
        self._address = 0
        self._size = 0
        self._registers = ""
        self._request = b""
        self.silence = 0
        self.missed = 0
        self.damaged = 0
        self.doubled = 0
        self.late = 0

    @property
    def request(self) -> bytes:
        """Return the packet that asks; empty if nobody is to be asked."""
        return self._request

    def join(self, servo: int, device: str, joint: str) -> ServoLink:
        """Make a servo known; it is not asked yet.

        Raises
        ------
        ValueError
            Its id is taken.
        """
        other = self._links.get(servo)
        if other is not None:
            raise ValueError(
                f"{other.device} {other.joint} and {device} {joint} have the same id, {servo}, "
                "on the same bus"
            )
        link = self._links[servo] = ServoLink(servo, device, joint)
        return link

    def start(self, links: Iterable[ServoLink], address: int, size: int, registers: str) -> None:
        """Ask servos from now on.

        Parameters
        ----------
        links : iterable of ServoLink
            Whom.
        address, size : int
            For which registers, bytes.
        registers : str
            What those are called.

        Raises
        ------
        ValueError
            Others are asked for other registers; one packet cannot do both.
        """
        if self._active and (address, size) != (self._address, self._size):
            raise ValueError(
                f"{registers} at {address} cannot be read together with {self._registers} at "
                f"{self._address}; put the devices on different buses or set health alike"
            )
        self._address, self._size, self._registers = address, size, registers
        for link in links:
            link.restart()
            if link.id not in self._active:
                self._active.append(link.id)
        self._encode()

    def stop(self, links: Iterable[ServoLink]) -> None:
        """Do not ask servos any more."""
        gone = {link.id for link in links}
        self._active = [servo for servo in self._active if servo not in gone]
        self._encode()

    def settle(self, data: bytes, parser: StatusParser, *, in_time: bool = True) -> None:
        """Take the answer to the last request: what is not in these bytes is missing.

        Nothing counts as missed of a request that was not sent in time for its answer.
        """
        corrupt = parser.corrupt
        packets = parser.feed(data)
        links = self._links
        active = self._active
        for servo in active:
            link = links[servo]
            link.fresh = False
            link.cause = _SILENT
        if parser.pending:
            more, part = parser.finish()
            packets += more
            if part:
                packets.append(part)
        seen = self._take_fast(packets) if self._fast else self._take_each(packets)
        if seen == len(active) and parser.corrupt == corrupt:
            self.silence = 0
            return
        if not in_time:
            return
        self._count(data, was_damaged=parser.corrupt != corrupt)

    def check(self, link: ServoLink) -> None:
        """Raise if a servo does not answer as it should.

        Raises
        ------
        DeviceFault
            Its answers are missing, damaged or doubled too many times in a row.
        """
        limit = self._fault_after
        if link.missed < limit and link.doubled < limit:
            return
        if self.silence >= limit and len(self._active) > 1:
            raise DeviceFault(
                link.device,
                "no servo answers any more; look at their power and at the cable",
                object=self._registers,
                value=f"{self.silence} requests in a row",
                bound=f"fewer than {limit}",
            )
        who = f"{link.joint} (id {link.id})"
        if link.doubled >= limit:
            what = f"{who} answers twice; there are two servos with this id"
        elif link.cause is _SILENT:
            what = f"{who} does not answer any more"
        elif link.cause is _DAMAGED:
            what = (
                f"the status packets of {who} are corrupted or cut off; a bad cable, or two "
                "servos with this id"
            )
        else:
            what = f"{who} refuses to be read: {link.cause}"
        raise DeviceFault(
            link.device,
            what,
            node=link.id,
            object=self._registers,
            value=f"{max(link.missed, link.doubled)} requests in a row",
            bound=f"fewer than {limit}",
        )

    def statistics(self) -> dict[str, float]:
        """Return the counters."""
        return {
            "missed": self.missed,
            "damaged": self.damaged,
            "doubled": self.doubled,
            "late": self.late,
        }

    # Inside ---------------------------------------------------------------------------

    def _encode(self) -> None:
        self._request = (
            encode_sync_read(self._address, self._size, self._active, fast=self._fast)
            if self._active
            else b""
        )

    def _take_fast(self, packets: list[bytes]) -> int:
        """Take common packets, of which the last belongs to the last request."""
        packets = [packet for packet in packets if packet[4] == BROADCAST_ID]
        if not packets:
            return 0
        self.late += len(packets) - 1
        seen = 0
        links, size, packet = self._links, self._size, packets[-1]
        blocks = decode_fast_status(packet, size)
        for servo, status in zip(self._active, blocks, strict=False):
            link = links[servo]
            if status is None or status.id != servo:
                link.cause = _DAMAGED
                self.damaged += 1
            elif self._accept(link, status):
                seen += 1
        count = len(blocks)
        if count < len(self._active) and len(packet) > compute_fast_length(size, count):
            links[self._active[count]].cause = _DAMAGED  # cut off within its block
            self.damaged += 1
        return seen

    def _take_each(self, packets: list[bytes]) -> int:
        """Take packets of one servo each."""
        seen = 0
        twice: list[ServoLink] = []
        links = self._links
        for packet in packets:
            if packet[4] == BROADCAST_ID:  # no one servo's
                continue
            status = decode_status(packet)
            link = links.get(status.id)
            if link is None or status.id not in self._active:
                continue
            if link.fresh:
                twice.append(link)
            elif self._accept(link, status):
                seen += 1
        if len(twice) == len(self._active) > 1:
            self.late += 1
        else:
            self.doubled += len(twice)
            for servo in self._active:
                link = links[servo]
                link.doubled = link.doubled + 1 if link in twice else 0
        return seen

    def _accept(self, link: ServoLink, status: Status) -> bool:
        error = status.error
        link.alert = error & ALERT != 0
        if error & ~ALERT:
            link.cause = describe_status_error(error)
            return False
        if len(status.data) != self._size:
            link.cause = _DAMAGED
            self.damaged += 1
            return False
        link.data = status.data
        link.fresh = True
        link.missed = 0
        return True

    def _count(self, data: bytes, *, was_damaged: bool) -> None:
        """Count who is missing, and have the one that hid the others asked last."""
        self.silence = 0 if data else self.silence + 1
        missing = [self._links[servo] for servo in self._active if not self._links[servo].fresh]
        for link in missing:
            link.missed += 1
        self.missed += len(missing)
        if not missing:
            return
        first = missing[0]
        if was_damaged and first.cause is _SILENT:
            first.cause = _DAMAGED
            self.damaged += 1
        if first.cause is _SILENT and len(self._active) > 1:
            self._active.remove(first.id)
            self._active.append(first.id)
            self._encode()
