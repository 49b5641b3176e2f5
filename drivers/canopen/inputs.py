"""What a node sends each cycle: its length, completeness and punctuality."""

import struct
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from drivers.canopen.answers import Answers
from drivers.canopen.mapping import STRUCT_CODES, Layout, layout_size
from rig.hal import ConnectionFailed, DeviceFault

if TYPE_CHECKING:
    from drivers.canopen.bus import CanopenBus

_ATTEMPTS = 3

Take = Callable[[tuple[Any, ...], float], None]


def layout_struct(layout: Layout) -> struct.Struct:
    """Return the precompiled struct of a PDO."""
    return struct.Struct("<" + "".join(STRUCT_CODES[entry.type] for entry in layout))


class CyclicInputs:
    """The transmit PDOs of one node, which it samples at each SYNC.

    A sample counts when all its PDOs have come, and is stamped with the time of the SYNC
    that triggered the oldest of them. Of two in one cycle (the first was late, or it came twice)
    the newer one is taken.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    node : int
        Its number.
    bus : CanopenBus
        It is subscribed there.
    layouts : sequence of Layout
        What is mapped, PDO by PDO from TPDO1 on.
    take : callable
        ``take(values, t)`` receives each sample: all mapped values in order, as the wire
        has them, and its time, s.
    hold_after, fault_after : int
        Samples missed in a row that are counted as held, and that are a fault.
    """

    def __init__(
        self,
        name: str,
        node: int,
        bus: "CanopenBus",
        layouts: Sequence[Layout],
        take: Take,
        *,
        hold_after: int,
        fault_after: int,
    ) -> None:
        self.name = name
        self.node = node
        self.can_ids = tuple(0x080 + 0x100 * n + node for n in range(1, len(layouts) + 1))
        self._bus = bus
        self._take = take
        self._hold_after = hold_after
        self._fault_after = fault_after
        self._complete = (1 << len(layouts)) - 1
        self._seen = 0
        self._seen_sync = -1
        self._parts: list[tuple[Any, ...]] = [()] * len(layouts)
        self._sampled = [0.0] * len(layouts)
        self._taken_sync = 0
        self._answers = tuple(Answers(bus.syncs) for _ in layouts)
        bus.late_samples.append(self._count_late)
        bus.held_samples.append(lambda: self._held)
        self._wrong_in_a_row = 0
        self._wrong: tuple[int, int, int] = (0, 0, 0)
        self._held = 0
        self._last = [b""] * len(layouts)
        self._heard_sync = [-1] * len(layouts)
        self._doubled_sync = -1
        self._doubled_in_a_row = 0
        self._doubled = 0
        single = len(layouts) == 1
        for number, layout in enumerate(layouts):
            handler = self._single(layout) if single else self._part(number, layout)
            bus.subscribe(self.can_ids[number], handler)

    def arm(self) -> None:
        """Expect samples from now on."""
        self._taken_sync = self._bus.syncs.count
        self._wrong_in_a_row = self._doubled_in_a_row = 0
        for answers in self._answers:
            answers.arm()

    def take_first(self) -> None:
        """Send SYNC and wait for the sample that answers it.

        Raises
        ------
        ConnectionFailed
            None comes, three times over.
        """
        self.arm()
        bus = self._bus
        for _ in range(_ATTEMPTS):
            bus.synchronise()
            if bus.wait_until(self.is_current, bus.settings.sdo_timeout):
                return
        raise ConnectionFailed(
            self.name,
            "it is OPERATIONAL but does not answer SYNC",
            node=self.node,
            object=self._identifiers(),
        )

    def is_current(self) -> bool:
        """Return whether the sample of the last SYNC has come."""
        return self._taken_sync == self._bus.syncs.count

    def check(self, now: float) -> None:
        """Count what is missing, and raise if it is too much.

        Raises
        ------
        DeviceFault
            Samples are missing, their length is wrong, or there are two, too many times in a row.
        """
        if self._doubled_in_a_row > self._fault_after:
            raise DeviceFault(
                self.name,
                "somebody else sends under its identifier: after each SYNC two frames come, and "
                "they differ",
                node=self.node,
                object=f"PDO 0x{self.can_ids[self._doubled]:03X}",
                value=f"{self._doubled_in_a_row} cycles in a row",
                bound=f"at most {self._fault_after}",
            )
        missed = self._bus.syncs.count - self._taken_sync
        if not missed:
            return
        if missed >= self._hold_after:
            self._held += 1
            self._bus.misses.note(self.name)
        if self._wrong_in_a_row >= self._fault_after:
            can_id, size, expected = self._wrong
            raise DeviceFault(
                self.name,
                f"{self._wrong_in_a_row} frames in a row had the wrong length; "
                "its mapping is not what was configured",
                node=self.node,
                object=f"PDO 0x{can_id:03X}",
                value=f"{size} bytes",
                bound=f"{expected} bytes",
            )
        if missed >= self._fault_after:
            raise DeviceFault(
                self.name,
                f"it does not answer SYNC any more{self._bus.misses.of_others(self.name)}",
                node=self.node,
                object=self._identifiers(),
                value=f"{missed} missed in a row",
                bound=f"fewer than {self._fault_after}",
            )

    def _identifiers(self) -> str:
        return " or ".join(f"PDO 0x{can_id:03X}" for can_id in self.can_ids)

    def _hear_again(self, number: int, data: bytes) -> None:
        """Count a second frame of a cycle that says something else.

        A late frame is one that was missing before, so that two come now and then; in cycle after
        cycle they are of two senders.
        """
        count = self._bus.syncs.count
        if data == self._last[number] or count == self._doubled_sync:
            return
        in_a_row = count == self._doubled_sync + 1
        self._doubled_in_a_row = self._doubled_in_a_row + 1 if in_a_row else 1
        self._doubled_sync, self._doubled = count, number

    def _single(self, layout: Layout) -> Callable[[bytes, float], None]:
        size, unpack = layout_size(layout), layout_struct(layout).unpack
        take, syncs, can_id = self._take, self._bus.syncs, self.can_ids[0]
        answer, last, heard = self._answers[0].take, self._last, self._heard_sync

        def receive(data: bytes, now: float) -> None:
            if len(data) != size:
                self._count_wrong(can_id, len(data), size)
                return
            if heard[0] == syncs.count:
                self._hear_again(0, data)
            heard[0], last[0] = syncs.count, data
            self._taken_sync = syncs.count
            self._wrong_in_a_row = 0
            take(unpack(data), answer())

        return receive

    def _part(self, number: int, layout: Layout) -> Callable[[bytes, float], None]:
        size, unpack = layout_size(layout), layout_struct(layout).unpack
        can_id, bit = self.can_ids[number], 1 << number
        syncs, answer, sampled = self._bus.syncs, self._answers[number].take, self._sampled
        last, heard = self._last, self._heard_sync

        def receive(data: bytes, now: float) -> None:
            if len(data) != size:
                self._count_wrong(can_id, len(data), size)
                return
            if heard[number] == syncs.count:
                self._hear_again(number, data)
            heard[number], last[number] = syncs.count, data
            if self._seen_sync != syncs.count:
                self._seen_sync, self._seen = syncs.count, 0
            self._parts[number] = unpack(data)
            sampled[number] = answer()
            self._seen |= bit
            if self._seen == self._complete:
                self._taken_sync = syncs.count
                self._wrong_in_a_row = 0
                self._take(tuple([v for part in self._parts for v in part]), min(sampled))

        return receive

    def _count_late(self) -> int:
        return max(answers.late for answers in self._answers)

    def _count_wrong(self, can_id: int, size: int, expected: int) -> None:
        self._wrong_in_a_row += 1
        self._wrong = (can_id, size, expected)
