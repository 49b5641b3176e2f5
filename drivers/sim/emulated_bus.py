"""The simulated end of a CAN bus: takes frames to the emulated nodes and back."""

from collections.abc import Callable, Sequence
from functools import partial
from math import inf

from drivers.can.frame import ERROR_FLAG, EXTENDED_FLAG, EXTENDED_MASK, REMOTE_FLAG
from drivers.sim.can_line import CanLineEnd
from drivers.sim.frame_faults import FrameFaults
from drivers.sim.interface_faults import InterfaceFaults
from drivers.sim.nodes.bus_node import BusNode
from drivers.sim.simulated_bus import LossyBus
from rig.hal import FastCanBus

_BATCH = 256
"""Frames that are taken from the bus at a time."""
_FRAME_TIME = 125e-6
"""What a frame of 8 bytes takes at 1 Mbit/s, s."""
_LAST_STANDARD_ID = 0x7FF


class EmulatedBus(LossyBus):
    """The simulated end of one CAN bus, with the nodes on it.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    bus : FastCanBus
        The simulated end.
    nodes : sequence of BusNode
        With different node numbers.

    Attributes
    ----------
    faults : FrameFaults
        What happens to chosen frames.
    monitor : callable or None
        Takes time (s), CAN id and data of every frame that arrives, both ways.

    Raises
    ------
    ValueError
        Two nodes have the same number or name.
    """

    def __init__(self, name: str, bus: FastCanBus, nodes: Sequence[BusNode]) -> None:
        for what, values in (
            ("node_id", [node.node_id for node in nodes]),
            ("name", [node.name for node in nodes]),
        ):
            if len(set(values)) != len(values):
                raise ValueError(f"bus {name}: two nodes have the same {what}: {values}")
        super().__init__(name)
        self.bus = bus
        self.nodes = tuple(nodes)
        self.faults = FrameFaults()
        self.monitor: Callable[[float, int, bytes], None] | None = None
        self._listeners: dict[int, tuple[BusNode, ...]] = {}
        for node in nodes:
            node.send = partial(self._send, node)
            node.listens_anew = self._listeners.clear
            self.faults.offer(node)
        self._interface = InterfaceFaults(bus) if isinstance(bus, CanLineEnd) else None

    def drain(self, latency: float) -> None:
        """Take what the master sent; it arrives `latency` (s) later."""
        while frames := self.bus.drain(_BATCH):
            if self.frame_loss or self.faults.by_id:
                for can_id, data in frames:
                    if not can_id & ERROR_FLAG:
                        self._accept(can_id, data, latency)
            else:  # they stay together
                self._post(latency, partial(self._arrive_together, frames))
            if len(frames) < _BATCH:
                break

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` accepts."""
        interface = InterfaceFaults.known if self._interface is not None else ()
        return (*super().known_faults, "foreign_frame", "flood", *interface)

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault of the bus itself happen, one of `LossyBus` or another.

        ``foreign_frame`` (value: CAN id, default 0x7E5) sends one that belongs to nobody;
        ``flood`` (value: frames, default 64) sends so many of them, one every 125 µs, as many
        as 1 Mbit/s carries. What else `known_faults` has is in `InterfaceFaults`.
        """
        if fault == "foreign_frame":
            self.send_foreign(0x7E5 if value is None else int(value), bytes(8))
        elif fault == "flood":
            for k in range(64 if value is None else int(value)):
                self._post(k * _FRAME_TIME, lambda _: self.send_foreign(0x7E5, bytes(8)))
        elif self._interface is not None and fault in InterfaceFaults.known:
            end = self._interface.inject(fault)
            if value is not None:
                self._post(value, lambda _: end())
        else:
            super().inject(fault, value)

    def send_foreign(self, can_id: int, data: bytes, *, extended: bool = False) -> None:
        """Send a frame to the master as if another device were on the bus."""
        self._to_master(can_id, data, self._now, extended=extended or can_id > 0x7FF)

    def tell(self, now: float) -> None:
        """Give every node the time even if nothing is due: a lasting fault starts now."""
        self._now = now
        for node in self.nodes:
            node.tick(now)

    def tick(self, now: float) -> None:
        """Give the nodes the time."""
        self._now = now
        for node in self.nodes:
            if node.due <= now:
                node.tick(now)

    @property
    def due(self) -> float:
        """When the first node has something to do, s."""
        due = inf
        for node in self.nodes:  # compared, because min() takes twice as long
            due = node.due if node.due < due else due
        return due

    def _accept(self, flagged_id: int, data: bytes, latency: float) -> None:
        """Have what becomes of a frame of the master's arrive."""
        if self._lost():
            return
        for delay, changed, is_foreign in self.faults.apply(flagged_id & EXTENDED_MASK, data):
            arrival = self._arrive_foreign if is_foreign else self._arrive
            self._post(latency + delay, partial(arrival, flagged_id, changed))

    def _arrive_together(self, frames: Sequence[tuple[int, bytes]], now: float) -> None:
        for flagged_id, data in frames:
            if not flagged_id & ERROR_FLAG:
                self._arrive(flagged_id, data, now)

    def _arrive(self, flagged_id: int, data: bytes, now: float) -> None:
        """Give a frame of the master's to the nodes."""
        self._now = now
        if self.monitor is not None:
            self.monitor(now, flagged_id & EXTENDED_MASK, data)
        self._give(flagged_id, data, now)

    def _arrive_foreign(self, flagged_id: int, data: bytes, now: float) -> None:
        """Give a frame to everybody that looks as if the master had sent it."""
        self._now = now
        extended = bool(flagged_id & EXTENDED_FLAG)
        self._to_master(flagged_id & EXTENDED_MASK, data, now, extended=extended)
        self._give(flagged_id, data, now)

    def _give(self, flagged_id: int, data: bytes, now: float) -> None:
        if flagged_id <= _LAST_STANDARD_ID:
            listeners = self._listeners.get(flagged_id)
            for node in self._find_listeners(flagged_id) if listeners is None else listeners:
                node.receive(flagged_id, data, now)
            return
        can_id = flagged_id & EXTENDED_MASK
        extended, remote = bool(flagged_id & EXTENDED_FLAG), bool(flagged_id & REMOTE_FLAG)
        for node in self.nodes:
            node.receive(can_id, data, now, extended=extended, remote=remote)

    def _find_listeners(self, can_id: int) -> tuple[BusNode, ...]:
        found = self._listeners[can_id] = tuple(node for node in self.nodes if node.hears(can_id))
        return found

    def _send(self, sender: BusNode, can_id: int, data: bytes) -> None:
        """Take a frame of a node's to the master and to the other nodes."""
        if not self.frame_loss and not self.faults.by_id:
            self._from_node(sender, can_id, data, sender.now)
        elif not self._lost():
            for delay, changed, _ in self.faults.apply(can_id, data):
                if delay:
                    self._post(delay, partial(self._from_node, sender, can_id, changed))
                else:
                    self._from_node(sender, can_id, changed, sender.now)

    def _from_node(self, sender: BusNode, can_id: int, data: bytes, now: float) -> None:
        self._to_master(can_id, data, now)
        listeners = self._listeners.get(can_id)
        for node in self._find_listeners(can_id) if listeners is None else listeners:
            if node is not sender:
                node.receive(can_id, data, now)

    def _to_master(self, can_id: int, data: bytes, now: float, *, extended: bool = False) -> None:
        if self._interface is not None and self._interface.severed:
            return
        if self.monitor is not None:
            self.monitor(now, can_id, data)
        self.bus.send_data(can_id | EXTENDED_FLAG if extended else can_id, data)
