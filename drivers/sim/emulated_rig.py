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
from typing import Protocol

from drivers.sim.axis_faults import faults_by_joint
from drivers.sim.emulated_bus import EmulatedBus
from drivers.sim.faults import FaultSchedule, Faulty, ScheduledFault
from drivers.sim.frame_faults import LASTING, FrameFault, FrameFaults, kind_of
from rig.hal import Plant
from rig.hal.world import Frames


class WorldSettings(Protocol):
    """Settings of the world."""

    @property
    def seed(self) -> int:
        """Of everything random outside the plant."""

    @property
    def bus_latency(self) -> float:
        """From the master's send until the nodes act, s."""

    @property
    def frame_loss(self) -> float:
        """Probability that a frame is lost, each way."""

    @property
    def faults(self) -> Sequence[ScheduledFault]:
        """The fault schedule."""


class Timed(Faulty, Protocol):
    """Something beside the buses that lives in virtual time, as a camera does."""

    name: str

    @property
    def due(self) -> float:
        """When it acts next, s."""

    def tick(self, now: float) -> None:
        """Act if it is time; the plant is at `now`."""

    def tell(self, now: float) -> None:
        """Take the time, s."""


class EmulatedRig:
    """Plant, buses and fault schedule in one virtual time.

    Parameters
    ----------
    plant : Plant
        The physics.
    buses : sequence of EmulatedBus
        With their nodes, which hold ports to the plant. Nodes named ``device.joint`` are
        targets of faults as one device too.
    settings : WorldSettings
        Latency, losses, faults, seed.
    devices : mapping, optional
        More targets of faults by name, e.g. the plant.
    cameras : sequence of Timed
        What lives in this time beside the buses.

    Raises
    ------
    ValueError
        A scheduled fault names a device that is not there, or a fault it does not know.
    """

    def __init__(
        self,
        plant: Plant,
        buses: Sequence[EmulatedBus],
        settings: WorldSettings,
        devices: Mapping[str, Faulty] | None = None,
        cameras: Sequence[Timed] = (),
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
            self._targets |= faults_by_joint(bus.nodes)
        self._targets |= {camera.name: camera for camera in cameras}
        self._timed: tuple[Timed | EmulatedBus, ...] = (*self.buses, *cameras)
        self._schedule = FaultSchedule(settings.faults, self._targets)

    def advance(self, t: float) -> None:
        """Let time pass up to `t` (s): frames arrive, nodes answer, the plant moves."""
        for bus in self.buses:
            bus.drain(self._latency)
        self.pass_until(t)

    @property
    def due(self) -> float:
        """When something happens next of its own, s."""
        return self._next_due()

    def pass_until(self, t: float) -> None:
        """Let time pass up to `t` (s) without looking for what the master has sent."""
        while (due := self._next_due()) <= t:
            now = max(due, self.time)
            self.plant.advance(now)
            self.time = now
            while self._events and self._events[0][0] <= now:
                heapq.heappop(self._events)[2](now)
            if self._schedule.next_time <= now:
                self._tell_time()
                self._schedule.due(now)
            for part in self._timed:
                part.tick(now)
        if t > self.time:
            self.plant.advance(t)
            self.time = t

    def inject(self, device: str, fault: str, value: float | None = None) -> None:
        """Make a fault of a node, a bus or another device happen now.

        Raises
        ------
        ValueError
            There is no such device, it has no such fault, or the value does not fit.
        """
        target = self._targets.get(device)
        if target is None:
            known = ", ".join(self._targets)
            raise ValueError(f"simulation: no device {device!r} to fail; there are {known}")
        self._tell_time()
        target.inject(fault, value)

    def add_frame_fault(self, bus: str, fault: FrameFault) -> None:
        """Have something happen to chosen frames of a bus."""
        self._faults_of(bus).add(fault)

    @property
    def known_faults(self) -> dict[str, tuple[str, ...]]:
        """Names that `inject` understands, of each device, each bus and the plant."""
        return {name: tuple(target.known_faults) for name, target in self._targets.items()}

    def frames_of(self, device: str) -> Frames | None:
        """Return the identifiers of a device's frames now; None if it has no CAN frames."""
        for bus in self.buses:
            nodes = [
                node
                for node in bus.nodes
                if isinstance(bus, EmulatedBus) and node.name.partition(".")[0] == device
            ]
            if nodes:
                return Frames(
                    bus.name,
                    tuple(can_id for node in nodes for can_id in node.receive_ids),
                    tuple(can_id for node in nodes for can_id in node.transmit_ids),
                    tuple(can_id for node in nodes for can_id in node.alive_ids),
                )
        return None

    def disturb(
        self,
        bus: str,
        kind: str,
        can_id: int,
        value: float,
        changed: Callable[[], None] | None = None,
    ) -> Callable[[], None]:
        """Have something happen to every frame of an identifier; see `BreakableWorld`.

        Raises
        ------
        ValueError
            There is no such kind.
        """
        faults = self._faults_of(bus)
        fault = FrameFault(kind_of(kind), can_id, count=LASTING, value=value, changed=changed)
        faults.add(fault)
        return partial(faults.remove, fault)

    def _faults_of(self, bus: str) -> FrameFaults:
        return next(item for item in self.buses if item.name == bus).faults

    def _tell_time(self) -> None:
        """Give every node the time: a fault that lasts is counted from now."""
        for part in self._timed:
            part.tell(self.time)

    def _post(self, delay: float, action: Callable[[float], None]) -> None:
        """Have an action done `delay` (s) from now; equal times keep their order."""
        heapq.heappush(self._events, (self.time + delay, self._sequence, action))
        self._sequence += 1

    def _next_due(self) -> float:
        due = self._schedule.next_time
        for part in self._timed:
            wanted = part.due
            due = wanted if wanted < due else due
        if self._events and self._events[0][0] < due:
            return self._events[0][0]
        return due
