"""All PDOs of an emulated node at work: what comes in, what SYNC and time make it send."""

from collections.abc import Callable, Sequence
from math import inf
from typing import Protocol

from drivers.sim.nodes import emergency as emcy
from drivers.sim.nodes.emergency import Emergency
from drivers.sim.nodes.pdo import (
    LAST_SYNCHRONOUS,
    NO_RTR,
    NOT_VALID,
    PdoHost,
    ReceivePdo,
    TransmitPdo,
)

PDO_COUNT = 4
Handler = Callable[[bytes, float], None]


class Process(PdoHost, Protocol):
    """The application side of a node, as its PDOs need it."""

    def sample_inputs(self, now: float) -> None:
        """Bring the input objects up to date."""

    def apply_outputs(self, now: float) -> None:
        """Act on the output objects."""

    def wake(self) -> None:
        """Have the node look at what is due."""

    def deadline_moved(self) -> None:
        """Take it that a receive PDO is waited for anew."""

    def communication_failed(self) -> None:
        """Do what the node is told to do when its communication fails."""


class PdoExchange:
    """Four PDOs each way.

    Parameters
    ----------
    node_id : int
        For the default COB-IDs.
    emergency : Emergency
        Told of bad lengths and missed deadlines.
    process : Process
        Has the PDOs, samples and applies.
    """

    def __init__(self, node_id: int, emergency: Emergency, process: Process) -> None:
        self._node_id = node_id
        self._emergency = emergency
        self._process = process
        self.receive: list[ReceivePdo] = []
        self.transmit: list[TransmitPdo] = []
        self._on_sync: list[TransmitPdo] = []
        self._on_events: list[TransmitPdo] = []

    def add(self, receive: Sequence[Sequence[int]], transmit: Sequence[Sequence[int]]) -> None:
        """Add the PDOs with their default mappings; those without one are not valid."""
        for number in range(PDO_COUNT):
            entries = receive[number] if number < len(receive) else ()
            cob_id = 0x200 + 0x100 * number + self._node_id | (0 if entries else NOT_VALID)
            self.receive.append(ReceivePdo(self._process, number, cob_id, entries))
        for number in range(PDO_COUNT):
            entries = transmit[number] if number < len(transmit) else ()
            cob_id = 0x180 + 0x100 * number + self._node_id | NO_RTR
            cob_id |= 0 if entries else NOT_VALID
            self.transmit.append(TransmitPdo(self._process, number, cob_id, entries))

    def configure(self) -> None:
        """Take all parameters as they are now."""
        for pdo in (*self.receive, *self.transmit):
            pdo.configure()
        self.stop()

    def start(self) -> None:
        """Begin exchanging: the node became OPERATIONAL."""
        for pdo in self.transmit:
            pdo.restart()

    def stop(self) -> None:
        """Expect nothing and forget what waits for SYNC."""
        for pdo in self.receive:
            pdo.stop_watching()

    def arrange(self) -> dict[int, Handler]:
        """Sort the PDOs by what moves them; return the handler of each CAN id consumed."""
        valid = [pdo for pdo in self.transmit if pdo.can_id is not None]
        self._on_sync = [pdo for pdo in valid if pdo.transmission_type <= LAST_SYNCHRONOUS]
        self._on_events = [pdo for pdo in valid if pdo.event_driven]
        return {pdo.can_id: self._receiver(pdo) for pdo in self.receive if pdo.can_id is not None}

    @property
    def due(self) -> float:
        """When `tick` has something to do, s."""
        due = inf
        for late in self.receive:
            due = late.due if late.due < due else due
        for event in self._on_events:
            due = min(event.due, due)
        return due

    def synchronise(self, now: float) -> None:
        """Act on a SYNC: sample and send what it asks for, apply what waited for it."""
        wanted = [pdo for pdo in self._on_sync if pdo.wants_sync()]
        if wanted:
            self._process.sample_inputs(now)
            for pdo in wanted:
                pdo.transmit(now)
        written = False
        for receive in self.receive:
            if receive.waiting is not None:
                receive.synchronise()
                written = True
        if written:
            self._process.apply_outputs(now)

    def tick(self, now: float) -> None:
        """Act on setpoints that are late; send what events and timers ask for."""
        late = [pdo for pdo in self.receive if now >= pdo.due]
        for pdo in late:
            pdo.due = inf
            self._emergency.raise_error(
                f"rpdo{pdo.number} late", emcy.RPDO_TIMEOUT, emcy.COMMUNICATION
            )
        if late:
            self._process.communication_failed()
            return
        wanted = [pdo for pdo in self._on_events if now >= pdo.due]
        if wanted:
            self._process.sample_inputs(now)
            for transmit in wanted:
                transmit.transmit(now)

    def _receiver(self, pdo: ReceivePdo) -> Handler:
        size = pdo.layout.size
        bad_length, late = f"rpdo{pdo.number} length", f"rpdo{pdo.number} late"
        emergency, process = self._emergency, self._process

        def receive(data: bytes, now: float) -> None:
            length = len(data)
            if length != size:
                code = emcy.RPDO_TOO_SHORT if length < size else emcy.RPDO_TOO_LONG
                emergency.raise_error(bad_length, code, emcy.COMMUNICATION)
                process.wake()
                if length < size:
                    return
            elif emergency.present:
                emergency.clear_error(bad_length)
                emergency.clear_error(late)
                process.wake()
            if pdo.receive(data, now):
                process.apply_outputs(now)
            if pdo.due < inf:
                process.deadline_moved()

        return receive
