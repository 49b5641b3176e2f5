"""The world of `--on virtual`: emulated nodes, their buses and the plant, in lock-step.

Virtual time stands still while the rig's program computes; `EmulatedRig.advance` lets it
pass, in the order of events: frames that arrive, timers of nodes, faults of the schedule.
Nothing here reads a wall clock or an unseeded random number, so the same program and seed
give the same frames.
"""

import heapq
import random
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Protocol, cast

from drivers.sim.frame_faults import FrameFault, FrameFaults
from drivers.sim.nodes.base import EmulatedNode
from rig.hal.bus import CanBus, Frame


class Plant(Protocol):
    """What the world needs of the physics."""

    def advance(self, t: float) -> None:
        """Integrate up to time `t`, s."""
        ...


class ScheduledFault(Protocol):
    """One line of a fault schedule."""

    @property
    def at(self) -> float:
        """When, s since the start."""
        ...

    @property
    def device(self) -> str:
        """Name of the node or bus."""
        ...

    @property
    def fault(self) -> str:
        """Name of the fault."""
        ...

    @property
    def value(self) -> float | None:
        """What the fault's description says."""
        ...


class Simulation(Protocol):
    """Settings of the world."""

    @property
    def seed(self) -> int:
        """Of everything random outside the plant."""
        ...

    @property
    def bus_latency(self) -> float:
        """From the master's send until the nodes act, s."""
        ...

    @property
    def frame_loss(self) -> float:
        """Probability that a frame is lost, each way."""
        ...

    @property
    def faults(self) -> Sequence[ScheduledFault]:
        """The fault schedule."""
        ...


class EmulatedBus:
    """The simulated end of one CAN bus, with the nodes on it.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    bus : CanBus
        The simulated end.
    nodes : sequence of EmulatedNode
        With different node numbers.

    Attributes
    ----------
    frame_loss : float
        Probability that a frame is lost, each way.
    faults : FrameFaults
        What happens to chosen frames.
    monitor : callable or None
        Takes time (s), CAN id and data of every frame that arrives, both ways.

    Raises
    ------
    ValueError
        Two nodes have the same number or name.
    """

    def __init__(self, name: str, bus: CanBus, nodes: Sequence[EmulatedNode]) -> None:
        import can

        for attribute in ("node_id", "name"):
            values = [getattr(node, attribute) for node in nodes]
            if len(set(values)) != len(values):
                raise ValueError(f"bus {name}: two nodes have the same {attribute}: {values}")
        self.name = name
        self.bus = bus
        self.nodes = tuple(nodes)
        self.frame_loss = 0.0
        self.faults = FrameFaults()
        self.monitor: Callable[[float, int, bytes], None] | None = None
        # A Message's `data` is a bytearray, narrower than the seam's attribute.
        self._message = cast("Callable[..., Frame]", can.Message)
        for node in nodes:
            node.send = self._sender(node)
        self._post: Callable[[float, Callable[[float], None]], None]
        self._random = random.Random(0)
        self._now = 0.0

    def attach(
        self,
        post: Callable[[float, Callable[[float], None]], None],
        generator: random.Random,
    ) -> None:
        """Join a world: `post(delay, action)` has an action done later, at its time."""
        self._post = post
        self._random = generator

    def drain(self, latency: float) -> None:
        """Take what the master sent; it arrives `latency` (s) later."""
        recv = self.bus.recv
        while (frame := recv(0.0)) is not None:
            if not frame.is_error_frame:
                self._accept(frame, latency)

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault of the bus itself happen.

        ``frame_loss`` (value: probability, default 1) loses frames at random from now on;
        ``foreign_frame`` (value: CAN id, default 0x7E5) sends one that belongs to nobody.

        Raises
        ------
        ValueError
            The fault is not known here, or the value does not fit it.
        """
        if fault == "frame_loss":
            probability = 1.0 if value is None else value
            if not 0.0 <= probability <= 1.0:
                raise ValueError(f"bus {self.name}: frame_loss is 0 … 1, not {probability:g}")
            self.frame_loss = probability
        elif fault == "foreign_frame":
            self.send_foreign(0x7E5 if value is None else int(value), bytes(8))
        else:
            raise ValueError(
                f"bus {self.name}: no fault {fault!r}; known are frame_loss, foreign_frame"
            )

    def send_foreign(self, can_id: int, data: bytes, *, extended: bool = False) -> None:
        """Send a frame to the master as if another device were on the bus."""
        self._to_master(can_id, data, self._now, extended=extended or can_id > 0x7FF)

    def tick(self, now: float) -> None:
        """Give the nodes the time."""
        self._now = now
        for node in self.nodes:
            if node.due <= now:
                node.tick(now)

    @property
    def due(self) -> float:
        """When the first node has something to do, s."""
        return min([node.due for node in self.nodes])

    def _accept(self, frame: Frame, latency: float) -> None:
        can_id, data = frame.arbitration_id, bytes(frame.data)
        extended, remote = frame.is_extended_id, frame.is_remote_frame
        if self._lost():
            return
        for delay, changed in self.faults.apply(can_id, data):

            def arrive(now: float, data: bytes = changed) -> None:
                self._now = now
                if self.monitor is not None:
                    self.monitor(now, can_id, data)
                for node in self.nodes:
                    node.receive(can_id, data, now, extended=extended, remote=remote)

            self._post(latency + delay, arrive)

    def _sender(self, sender: EmulatedNode) -> Callable[[int, bytes], None]:
        others = [node for node in self.nodes if node is not sender]

        def send(can_id: int, data: bytes) -> None:
            if self._lost():
                return
            for delay, changed in self.faults.apply(can_id, data):
                if delay:
                    self._post(delay, partial(self._from_node, others, can_id, changed))
                else:
                    self._from_node(others, can_id, changed, sender.now)

        return send

    def _from_node(
        self, others: Sequence[EmulatedNode], can_id: int, data: bytes, now: float
    ) -> None:
        self._to_master(can_id, data, now)
        for node in others:
            node.receive(can_id, data, now)

    def _to_master(self, can_id: int, data: bytes, now: float, *, extended: bool = False) -> None:
        if self.monitor is not None:
            self.monitor(now, can_id, data)
        self.bus.send(
            self._message(arbitration_id=can_id, data=data, is_extended_id=extended, timestamp=now)
        )

    def _lost(self) -> bool:
        return self.frame_loss > 0.0 and self._random.random() < self.frame_loss


class EmulatedRig:
    """Plant, buses and fault schedule in one virtual time.

    Parameters
    ----------
    plant : Plant
        The physics.
    buses : sequence of EmulatedBus
        With their nodes, which hold ports to the plant.
    settings : Simulation
        Latency, losses, faults, seed.
    devices : mapping, optional
        More targets of scheduled faults by name, each with `inject(fault, value)`.

    Raises
    ------
    ValueError
        A scheduled fault names a device that is not there.
    """

    def __init__(
        self,
        plant: Plant,
        buses: Sequence[EmulatedBus],
        settings: Simulation,
        devices: Mapping[str, "Faulty"] | None = None,
    ) -> None:
        self.plant = plant
        self.buses = tuple(buses)
        self.time = 0.0
        self._latency = settings.bus_latency
        self._events: list[tuple[float, int, Callable[[float], None]]] = []
        self._sequence = 0
        generator = random.Random(settings.seed)
        self._targets: dict[str, Faulty] = dict(devices or {})
        for bus in self.buses:
            bus.attach(self._post, generator)
            bus.frame_loss = settings.frame_loss
            self._targets[bus.name] = bus
            self._targets |= {node.name: node for node in bus.nodes}
        for entry in settings.faults:
            self._target(entry.device)
            self._push(entry.at, self._injection(entry))

    def advance(self, t: float) -> None:
        """Let time pass up to `t` (s): frames arrive, nodes answer, the plant moves."""
        for bus in self.buses:
            bus.drain(self._latency)
        while (due := self._next_due()) <= t:
            now = max(due, self.time)
            self.plant.advance(now)
            self.time = now
            while self._events and self._events[0][0] <= now:
                heapq.heappop(self._events)[2](now)
            for bus in self.buses:
                bus.tick(now)
        if t > self.time:
            self.plant.advance(t)
            self.time = t

    def inject(self, device: str, fault: str, value: float | None = None) -> None:
        """Make a fault of a node or bus happen now.

        A node also knows the faults of its frames: ``drop_frames``, ``delay_frames``,
        ``duplicate_frames``, ``truncate_frames`` and ``corrupt_frames``; see
        `drivers.sim.frame_faults`.

        Raises
        ------
        ValueError
            There is no such device, it has no such fault, or the value does not fit.
        """
        target = self._target(device)
        for bus in self.buses:
            if target in bus.nodes:
                node = next(item for item in bus.nodes if item is target)
                node.tick(self.time)
                if bus.faults.inject(node, fault, value):
                    return
        target.inject(fault, value)

    def add_frame_fault(self, bus: str, fault: FrameFault) -> None:
        """Have something happen to chosen frames of a bus."""
        next(item for item in self.buses if item.name == bus).faults.add(fault)

    def _target(self, device: str) -> "Faulty":
        target = self._targets.get(device)
        if target is None:
            known = ", ".join(self._targets)
            raise ValueError(f"simulation: no device {device!r} to fail; there are {known}")
        return target

    def _injection(self, entry: ScheduledFault) -> Callable[[float], None]:
        return lambda now: self.inject(entry.device, entry.fault, entry.value)

    def _post(self, delay: float, action: Callable[[float], None]) -> None:
        self._push(self.time + delay, action)

    def _push(self, due: float, action: Callable[[float], None]) -> None:
        heapq.heappush(self._events, (due, self._sequence, action))
        self._sequence += 1

    def _next_due(self) -> float:
        due = min([bus.due for bus in self.buses])
        if self._events and self._events[0][0] < due:
            due = self._events[0][0]
        return due


class Faulty(Protocol):
    """Something that faults can be injected into."""

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now."""
        ...
