"""A CAN bus with CANopen devices as the cycle sees it: one place for all its I/O."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from drivers.can.cyclic import CyclicCanBus
from drivers.canopen.answers import SyncTrain
from drivers.canopen.heartbeat import HeartbeatProducer, NmtState
from drivers.canopen.misses import RecentMisses
from drivers.canopen.settings import CanBusSettings
from rig.hal import Clock, FastCanBus

if TYPE_CHECKING:
    from drivers.canopen.network import ThreadlessNetwork

SYNC_ID: Final = 0x080
_SYNC: Final = (SYNC_ID, b"")
_NMT_ID: Final = 0x000
_NMT_STOP_ALL: Final = bytes((0x02, 0x00))
_NMT_PRE_OPERATIONAL: Final = 0x80
_OPERATIONAL: Final = bytes((NmtState.OPERATIONAL,))


class CanopenBus(CyclicCanBus):
    """The CANopen master of one CAN interface; satisfies `rig.hal.CyclicBus`.

    Its cyclic frames are PDOs. Closing it stops all nodes: from then on they ignore PDOs and SDOs,
    so setpoints must be safe already, and what the nodes do when stopped was written to them
    before they were armed. Parameters are those of `CyclicCanBus`; the period is that of SYNC too.

    Attributes
    ----------
    syncs : SyncTrain
        Those so far.
    misses : RecentMisses
        Of the samples that devices owe.
    late_samples : list of callable
        Each returns how many samples of a device came in another cycle than that of their SYNC.
    held_samples : list of callable
        Each returns in how many cycles a device's last sample was held for want of a new one.
    lost_setpoints : list of callable
        Each returns how many setpoints a device was sent and did not get.
    """

    _farewell = (_NMT_ID, _NMT_STOP_ALL)

    def __init__(
        self,
        name: str,
        settings: CanBusSettings,
        open_bus: Callable[[], FastCanBus],
        clock: Clock,
        period: float | None = None,
    ) -> None:
        super().__init__(name, settings, open_bus, clock, period)
        self.settings = settings
        self.syncs = SyncTrain(can_omit=settings.sync)
        self.misses = RecentMisses(self.syncs)
        self.late_samples: list[Callable[[], int]] = []
        self.held_samples: list[Callable[[], int]] = []
        self.lost_setpoints: list[Callable[[], int]] = []
        self._now = clock.now
        self._heartbeat = HeartbeatProducer(settings.heartbeat)
        self._heartbeat_id = 0x700 + settings.master_id
        self._network: ThreadlessNetwork | None = None
        if settings.sync:
            self.claim(SYNC_ID, "SYNC")
        else:
            self.subscribe(SYNC_ID, self._on_foreign_sync)
        self.claim(self._heartbeat_id, "the master's heartbeat")

    @property
    def network(self) -> "ThreadlessNetwork":
        """The `canopen` network for configuration; imported on first use."""
        if self._network is None:
            from drivers.canopen.network import ThreadlessNetwork

            self._network = ThreadlessNetwork(self, self.settings.sdo_timeout)
        return self._network

    def open(self) -> None:
        """Open the interface; see `CyclicCanBus.open`."""
        super().open()
        self._heartbeat.restart()

    def transmit(self, now: float) -> None:
        """Send this cycle's setpoints, SYNC, and the heartbeat if it is due. Hot path."""
        exchanged = self._leave_sync_out() if self.syncs.wanted else self._exchange()
        if exchanged and now >= self._heartbeat.due:
            try:
                self._send(self._heartbeat_id, _OPERATIONAL)
            except Exception as error:
                self._errors.refuse(error)
            else:
                self._frames_out += 1
                self._heartbeat.sent(now)

    def synchronise(self) -> None:
        """Send setpoints and SYNC, but no heartbeat: for first readings while arming.

        Nodes watch the master from its first heartbeat on, which the running loop sends.
        """
        self._exchange()
        self.syncs.settle()

    def wake(self, node: int) -> None:
        """Have a node that may be stopped answer SDO; it is not reset, and keeps what it holds."""
        self.send(_NMT_ID, bytes((_NMT_PRE_OPERATIONAL, node)))

    def make_safe(self) -> None:
        """Send the safe setpoints of every driver now. Never raises."""
        for pdo in self._cyclic:
            pdo.data = pdo.safe
        if self.has_spoken:
            self._exchange()

    def statistics(self) -> dict[str, float]:
        """Return counters for the run's manifest."""
        strange = 0 if self._network is None else self._network.strange
        found = {
            **super().statistics(),
            "syncs": self.syncs.count - self.syncs.omissions,
            "omitted_syncs": self.syncs.omissions,
            "late_samples": sum(late() for late in self.late_samples),
            "held_samples": sum(held() for held in self.held_samples),
            "strange_answers": strange,
        }
        if self.lost_setpoints:
            found["lost_setpoints"] = sum(lost() for lost in self.lost_setpoints)
        return found

    def _exchange(self) -> bool:
        if not self.settings.sync:
            return self._send_cyclic()
        if not self._send_cyclic(_SYNC):
            return False
        self.syncs.send(self._now())
        return True

    def _leave_sync_out(self) -> bool:
        if not self._send_cyclic():
            return False
        self.syncs.leave_out()
        return True

    def _owners(self, can_id: int) -> str:
        return f"devices have node number 0x{can_id & 0x7F:02X}"

    def _on_foreign_sync(self, data: bytes, now: float) -> None:
        self.syncs.send(now)
