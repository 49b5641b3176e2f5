"""A CANopen node that exists only in memory: the part that every device profile shares.

It is written from the standard and behaves as devices built on CANopenNode were seen to:
PDOs only in OPERATIONAL, no SDO in STOPPED, EMCY 0x8130 and the reaction of 0x1029 when
the master falls silent, EMCY 0x8210 for a short RPDO. It shares no code with the drivers,
so that a mistake on one side cannot hide on the other.

References
----------
CiA 301 V4.2.
"""

from collections.abc import Callable, Sequence
from math import inf

from drivers.sim.nodes import emergency as emcy
from drivers.sim.nodes.emergency import Emergency
from drivers.sim.nodes.faults import FaultInjection, whole_number
from drivers.sim.nodes.nmt import HeartbeatConsumer, HeartbeatProducer, NmtCommand, NmtState
from drivers.sim.nodes.object_dictionary import (
    UNSIGNED8,
    UNSIGNED32,
    VISIBLE_STRING,
    Abort,
    ObjectDictionary,
    SdoAbortError,
    Variable,
)
from drivers.sim.nodes.pdo_exchange import PdoExchange
from drivers.sim.nodes.sdo_server import SdoServer

VENDOR_ID = 0x0000_0000  # the number that CiA gives to nobody

_OPERATIONAL = NmtState.OPERATIONAL  # found five times faster than an enumeration's member
_SYNC_ID = 0x080
_NMT_ID = 0x000
_COMMAND_TO_STATE = {
    NmtCommand.START: NmtState.OPERATIONAL,
    NmtCommand.STOP: NmtState.STOPPED,
    NmtCommand.ENTER_PRE_OPERATIONAL: NmtState.PRE_OPERATIONAL,
}
# What 0x1029:1 asks for when communication fails; 1 asks for no change.
_ERROR_BEHAVIOUR = {0: NmtState.PRE_OPERATIONAL, 2: NmtState.STOPPED}

Send = Callable[[int, bytes], None]


class EmulatedNode(FaultInjection):
    """A CANopen slave; a device profile adds its objects and its hooks.

    A subclass adds objects in its constructor, then calls `add_pdos` and `power_on`, and
    overrides `sample_inputs`, `apply_outputs`, `leave_operational` and `restore_process`.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    node_id : int
        1 … 127.
    device_type : int
        Object 0x1000.
    vendor, product_code, revision, serial : int
        Objects 0x1018:1 … 4.

    Attributes
    ----------
    send : callable
        Takes CAN id and data of each frame that leaves the node; the bus sets it.
    listens_anew : callable
        Called when the node hears other identifiers than before; the bus sets it.
    due : float
        When `tick` has something to do at the latest, s.
    now : float
        The time that the node was last told, s.
    """

    def __init__(
        self,
        name: str,
        node_id: int,
        *,
        device_type: int,
        vendor: int = VENDOR_ID,
        product_code: int = 0,
        revision: int = 0x0001_0000,
        serial: int = 0,
    ) -> None:
        super().__init__()
        if not 1 <= node_id <= 127:
            raise ValueError(f"{name}: node {node_id} is outside 1 … 127")
        self.name = name
        self.node_id = node_id
        self.send: Send = lambda can_id, data: None
        self.listens_anew: Callable[[], None] = lambda: None
        self.now = 0.0
        self.due = 0.0
        self.state = NmtState.INITIALISING
        self.dictionary = ObjectDictionary()
        self._routes: dict[int, Callable[[bytes, float], None]] = {}

        add = self.dictionary.add
        self.device_type = add(0x1000, 0, Variable(UNSIGNED32, device_type, "ro"))
        self._sync = add(
            0x1005, 0, Variable(UNSIGNED32, _SYNC_ID, check=_check_sync, changed=self.route)
        )
        add(0x1008, 0, Variable(VISIBLE_STRING, f"emulated {name}".encode(), "const"))
        self._error_behaviour = self.dictionary.add_array(
            0x1029, [Variable(UNSIGNED8, 0, low=0, high=2)]
        )[0]
        self.dictionary.add_array(
            0x1018,
            [
                Variable(UNSIGNED32, value, "ro")
                for value in (vendor, product_code, revision, serial)
            ],
        )
        self.dictionary.add_array(
            0x1200,
            [
                Variable(UNSIGNED32, 0x600 + node_id, "ro"),
                Variable(UNSIGNED32, 0x580 + node_id, "ro"),
            ],
        )
        self.emergency = Emergency(self.dictionary, node_id, self.transmit)
        self.pdos = PdoExchange(node_id, self.emergency, self)
        self._producer = HeartbeatProducer(self.dictionary, self._send_heartbeat, self.wake)
        self._consumer = HeartbeatConsumer(
            self.dictionary, self._heartbeat_lost, self._heartbeat_found, self.route
        )
        self._server = SdoServer(self.dictionary, lambda data: self.transmit(0x580 + node_id, data))
        self._parts = (self._server, self._consumer, self._producer, self.emergency)
        self._add_faults()

    def _add_faults(self) -> None:
        self.add_fault("reboot", lambda _: self.power_on())
        self.add_fault("wrong_state", self._fault_wrong_state)
        self.offer_faults(self.device_type, self._server.refused, self.emergency)

    def _fault_wrong_state(self, value: float | None) -> None:
        state = whole_number(self.name, "wrong_state", value, NmtState.STOPPED, 0x7F)
        if state not in _COMMAND_TO_STATE.values():
            raise ValueError(f"{self.name}: wrong_state takes 4, 5 or 127, not {state}")
        self.enter_state(NmtState(state))

    # What a device profile overrides -------------------------------------------------

    def sample_inputs(self, now: float) -> None:
        """Bring the input objects up to date; called just before they are sent or read."""

    def apply_outputs(self, now: float) -> None:
        """Act on the output objects, which an RPDO or an SDO has just written."""

    def leave_operational(self, now: float) -> None:
        """Take the error state of the outputs."""

    def enter_operational(self, now: float) -> None:
        """Let the outputs follow their objects again."""

    def restore_process(self) -> None:
        """Take the power-on state of everything that is not an object."""

    def watch_inputs(self, now: float) -> None:
        """Look for changes that trigger event-driven PDOs; called in OPERATIONAL."""

    def process_due(self) -> float:
        """Return when `watch_inputs` wants to be called, s."""
        return inf

    # Construction ---------------------------------------------------------------------

    def add_pdos(self, receive: Sequence[Sequence[int]], transmit: Sequence[Sequence[int]]) -> None:
        """Add four PDOs each way with their default mappings; those without are not valid."""
        self.pdos.add(receive, transmit)

    def power_on(self) -> None:
        """Start as after a power cycle; the boot-up message follows at the next tick."""
        self._restart(communication_only=False)

    @property
    def transmit_ids(self) -> tuple[int, ...]:
        """CAN ids of the transmit PDOs that are valid now."""
        return tuple(pdo.can_id for pdo in self.pdos.transmit if pdo.can_id is not None)

    @property
    def receive_ids(self) -> tuple[int, ...]:
        """CAN ids of the receive PDOs that are valid now."""
        return tuple(pdo.can_id for pdo in self.pdos.receive if pdo.can_id is not None)

    @property
    def alive_ids(self) -> tuple[int, ...]:
        """CAN id of the heartbeat."""
        return (0x700 + self.node_id,)

    # Time and frames ------------------------------------------------------------------

    def hears(self, can_id: int) -> bool:
        """Return whether frames of this identifier do anything here now."""
        return can_id in self._routes

    def receive(
        self,
        can_id: int,
        data: bytes,
        now: float,
        *,
        extended: bool = False,
        remote: bool = False,
    ) -> None:
        """Take a frame from the bus; what is not for this node is ignored."""
        handler = self._routes.get(can_id)
        if handler is None or extended or remote or "silent" in self.lasting:
            return
        if now >= self.due:
            self.tick(now)
        self.now = now
        handler(data, now)
        if now >= self.due:
            self.tick(now)

    def tick(self, now: float) -> None:
        """Do what is due at time `now` (s)."""
        self.now = now
        if now < self.due:
            return
        self.expire_faults(now)
        if self.state is NmtState.INITIALISING:
            self.transmit(0x700 + self.node_id, bytes((NmtState.INITIALISING,)))
            self.state = NmtState.PRE_OPERATIONAL
        self._server.tick(now)
        self._consumer.tick(now)
        self._producer.tick(now, self.state)
        if self.state is NmtState.OPERATIONAL:
            self.watch_inputs(now)
            self.pdos.tick(now)
        self.emergency.tick(now, allowed=self.state is not NmtState.STOPPED)
        self._plan()

    def _plan(self) -> None:
        """Work out when the next tick has something to do."""
        due = self.fault_due
        for part in self._parts:  # compared, because min() takes twice as long
            due = part.due if part.due < due else due
        if self.state is _OPERATIONAL:
            for wanted in (self.process_due(), self.pdos.due):
                due = wanted if wanted < due else due
        self.due = due

    def deadline_moved(self) -> None:
        """Take it that a receive PDO is waited for anew; nothing else has changed."""
        self._plan()

    def wake(self) -> None:
        """Have `tick` look at everything as soon as it is called."""
        self.due = -inf

    def transmit(self, can_id: int, data: bytes) -> None:
        """Send a frame, unless the node is silent."""
        if "silent" not in self.lasting:
            self.send(can_id, data)

    def _send_heartbeat(self, state: int) -> None:
        if "heartbeat_silent" not in self.lasting:
            self.transmit(0x700 + self.node_id, bytes((state,)))

    # Routing --------------------------------------------------------------------------

    def route(self) -> None:
        """Build the table from CAN id to handler; NMT is always heard, SDO unless stopped."""
        routes: dict[int, Callable[[bytes, float], None]] = {}
        if self.state is NmtState.OPERATIONAL:
            routes |= self.pdos.arrange()
            routes[self._sync.integer & 0x7FF] = self._on_sync
        if self.state is not NmtState.STOPPED:
            routes[0x600 + self.node_id] = self._on_sdo
        for node in self._consumer.nodes:
            routes[0x700 + node] = self._heartbeat_receiver(node)
        routes[_NMT_ID] = self._on_nmt
        self._routes = routes
        self.listens_anew()
        self.wake()

    def _heartbeat_receiver(self, node: int) -> Callable[[bytes, float], None]:
        def on_heartbeat(data: bytes, now: float) -> None:
            if len(data) == 1:
                self._consumer.receive(node, data[0] & 0x7F, now)
                self.wake()

        return on_heartbeat

    # Services -------------------------------------------------------------------------

    def _on_sync(self, data: bytes, now: float) -> None:
        if data:
            self.emergency.raise_error("sync length", emcy.SYNC_LENGTH, emcy.COMMUNICATION)
            self.wake()
            return
        self.pdos.synchronise(now)

    def _on_sdo(self, data: bytes, now: float) -> None:
        if "sdo_silent" not in self.lasting:
            self._server.receive(data, now)
            self.wake()

    def _on_nmt(self, data: bytes, now: float) -> None:
        if len(data) != 2 or data[1] not in (0, self.node_id):
            return
        command = data[0]
        if command in _COMMAND_TO_STATE:
            self.enter_state(_COMMAND_TO_STATE[NmtCommand(command)])
        elif command == NmtCommand.RESET_NODE:
            self._restart(communication_only=False)
        elif command == NmtCommand.RESET_COMMUNICATION:
            self._restart(communication_only=True)
        self.wake()

    def _heartbeat_lost(self, node: int) -> None:
        self.emergency.raise_error(
            f"heartbeat {node}", emcy.HEARTBEAT_ERROR, emcy.COMMUNICATION, bytes((node,))
        )
        self.communication_failed()

    def communication_failed(self) -> None:
        """Leave OPERATIONAL as 0x1029:1 says; the emergency goes out first.

        In STOPPED it could not.
        """
        self.emergency.tick(self.now, allowed=self.state is not NmtState.STOPPED)
        reaction = _ERROR_BEHAVIOUR.get(self._error_behaviour.integer)
        if self.state is NmtState.OPERATIONAL and reaction is not None:
            self.enter_state(reaction)

    def _heartbeat_found(self, node: int) -> None:
        self.emergency.clear_error(f"heartbeat {node}")

    # States ---------------------------------------------------------------------------

    def enter_state(self, state: NmtState) -> None:
        """Change the NMT state with all that belongs to it."""
        before = self.state
        if state is before:
            return
        self.state = state
        if before is NmtState.OPERATIONAL:
            self.pdos.stop()
            self.leave_operational(self.now)
        if state is NmtState.OPERATIONAL:
            self.pdos.start()
            self.enter_operational(self.now)
        if state is NmtState.STOPPED:
            self._server.reset()
        self._producer.restart()
        self.route()

    def _restart(self, *, communication_only: bool) -> None:
        if self.state is NmtState.OPERATIONAL:
            self.leave_operational(self.now)
        self.state = NmtState.INITIALISING
        self.dictionary.restore(communication_only=communication_only)
        self.emergency.reset()
        self._server.reset()
        self._producer.reset()
        self._consumer.configure()
        self.pdos.configure()
        if not communication_only:
            self.restore_process()
        self.route()


def _check_sync(value: int) -> None:
    if value & 0x7FFFF800:  # neither a SYNC producer (bit 30) nor extended identifiers
        raise SdoAbortError(Abort.RANGE)
