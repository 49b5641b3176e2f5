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
        for node in nodes:
            node.send = self._sender(node)
            self.faults.offer(node)
        self._interface = InterfaceFaults(bus) if isinstance(bus, CanLineEnd) else None

    def drain(self, latency: float) -> None:
        """Take what the master sent; it arrives `latency` (s) later."""
        while frames := self.bus.drain(_BATCH):
            for can_id, data in frames:
                if not can_id & ERROR_FLAG:
                    self._accept(can_id, data, latency)
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
        can_id = flagged_id & EXTENDED_MASK
        extended, remote = bool(flagged_id & EXTENDED_FLAG), bool(flagged_id & REMOTE_FLAG)
        if self._lost():
            return
        for delay, changed, is_foreign in self.faults.apply(can_id, data):

            def arrive(now: float, data: bytes = changed, is_foreign: bool = is_foreign) -> None:
                self._now = now
                if is_foreign:
                    self._to_master(can_id, data, now, extended=extended)
                elif self.monitor is not None:
                    self.monitor(now, can_id, data)
                for node in self.nodes:
                    node.receive(can_id, data, now, extended=extended, remote=remote)

            self._post(latency + delay, arrive)

    def _sender(self, sender: BusNode) -> Callable[[int, bytes], None]:
        others = [node for node in self.nodes if node is not sender]

        def send(can_id: int, data: bytes) -> None:
            if self._lost():
                return
            for delay, changed, _ in self.faults.apply(can_id, data):
                if delay:
                    self._post(delay, partial(self._from_node, others, can_id, changed))
                else:
                    self._from_node(others, can_id, changed, sender.now)

        return send

    def _from_node(self, others: Sequence[BusNode], can_id: int, data: bytes, now: float) -> None:
        self._to_master(can_id, data, now)
        for node in others:
            node.receive(can_id, data, now)

    def _to_master(self, can_id: int, data: bytes, now: float, *, extended: bool = False) -> None:
        if self._interface is not None and self._interface.severed:
            return
        if self.monitor is not None:
            self.monitor(now, can_id, data)
        self.bus.send_data(can_id | EXTENDED_FLAG if extended else can_id, data)
