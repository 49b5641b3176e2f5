"""A rig that has been built: buses, devices and mechanism on one backend."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from enum import StrEnum
from math import inf
from pathlib import Path
from typing import Any

from rig.assembly.watchful_clock import WatchfulClock
from rig.config import Profile
from rig.hal import Clock, Column, CyclicBus, Device, EmergencyStop, EmergencyStopInput, Mechanism

LISTEN = 0.12
"""How long another master is listened for, s: two heartbeats of one with a shipped profile."""


class Backend(StrEnum):
    """The world that a run runs on."""

    SIM = "sim"
    VIRTUAL = "virtual"
    VCAN = "vcan"
    HARDWARE = "hardware"

    @property
    def is_simulated(self) -> bool:
        """Whether time is virtual and the plant is in this process."""
        return self in (Backend.SIM, Backend.VIRTUAL)


class Rig:
    """Buses, devices and mechanism of one profile on one backend; a context manager.

    Entering opens the buses and connects every device; leaving makes everything safe and
    closes it, whatever happened in between.

    Parameters
    ----------
    profile : Profile
        What it was built from.
    backend : Backend
        What it runs on.
    clock : Clock
        Virtual or real.
    buses, devices : mapping
        By name.
    mechanism : Mechanism
        The loop's view of it.
    truth_columns : sequence of Column
        In simulation: what `truth` returns.
    truth : callable
        In simulation: the plant's true values.
    waits : WatchfulClock, optional
        The clock by which buses and devices wait, if they take any time to be connected.

    Attributes
    ----------
    closing : callable
        Returns the context in which it is closed: whoever hears signals holds them back there.
    """

    def __init__(
        self,
        profile: Profile,
        backend: Backend,
        *,
        clock: Clock,
        buses: Mapping[str, CyclicBus],
        devices: Mapping[str, Device],
        mechanism: Mechanism[Any, Any, Any, Any],
        truth_columns: Sequence[Column] = (),
        truth: Callable[[], tuple[float, ...]] = tuple,
        take: Callable[[], None] = lambda: None,
        release: Callable[[], None] = lambda: None,
        waits: WatchfulClock | None = None,
    ) -> None:
        self.profile = profile
        self.backend = backend
        self.clock = clock
        self.buses = buses
        self.devices = devices
        self.mechanism = mechanism
        self.truth_columns = tuple(truth_columns)
        self.truth = truth
        self._take = take
        self._release = release
        self._stop = mechanism.stop_input()
        self._waits = waits or WatchfulClock(clock)
        self.closing: Callable[[], AbstractContextManager[None]] = nullcontext

    def __enter__(self) -> "Rig":
        try:
            self._open()
            for name, device in self.devices.items():
                stop = self._stop if self._reads_stop(name) else None
                if stop is not None and stop.looks_alone:
                    self._watch_stop(stop, name)
                device.connect()
                if stop is not None:
                    self._watch_stop(stop, name)
                self._waits.look()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def show_in(self, folder: Path) -> None:
        """Let whoever looks on see what the devices see, by files of the run's folder."""
        for device in self.devices.values():
            device.show_in(folder)

    def arm(self, *, torque: bool = True) -> None:
        """Make every device follow its setpoints, which are the safe ones until the loop runs.

        Parameters
        ----------
        torque : bool
            Without it servos are only listened to.

        Raises
        ------
        EmergencyStop
            The emergency stop is pressed, or was since the rig was connected.
        """
        # A camera waits for its first image; what hangs on a bus would grow stale meanwhile.
        waits = {name: self.profile.devices[name].bus is None for name in self.devices}
        # Who reads the emergency stop comes before whoever is energised by being armed.
        order = sorted(self.devices, key=lambda name: (not waits[name], not self._reads_stop(name)))
        for name in order:
            device = self.devices[name]
            device.arm() if torque else device.listen()
            if self._reads_stop(name):
                self._check_stop()
        # Arming the last device may have taken longer than a reading may be old.
        now = self.clock.now()
        for bus in self.buses.values():
            bus.transmit(now)
        if self.buses:
            self.clock.sleep_until(now + self.profile.loop.period)
        self._waits.rest()
        self._check_stop()

    @contextmanager
    def watching_stop(self) -> Iterator[Callable[[], bool | None]]:
        """Connect who reads the emergency stop, if need be; yield what tells its state.

        Nothing is armed. The state is that of the look before; None: nobody has told it yet.

        Raises
        ------
        ConnectionFailed
            It does not answer.
        """
        stop = self._stop
        assert stop is not None, "the rig has a contact"

        def is_pressed() -> bool | None:
            now = self.clock.now()
            for bus in self.buses.values():
                bus.receive(now)
            stop.look()
            pressed, t = stop.emergency_stop()
            return pressed if t > -inf else None

        try:
            self._open()
            for name, device in self.devices.items():
                if self._reads_stop(name) and not stop.looks_alone:
                    device.connect()
            stop.wake()
            yield is_pressed
        finally:
            self.close()

    def _open(self) -> None:
        self._take()
        for bus in self.buses.values():
            bus.open()
        if not self.backend.is_simulated:  # nobody else can be on an emulated bus
            for bus in self.buses.values():
                bus.expect_alone(LISTEN)

    def _watch_stop(self, stop: EmergencyStopInput, name: str) -> None:
        """Look at the contact whenever anything is waited for, until the loop does."""
        bus = self.buses.get(self.profile.devices[name].bus or "")

        def look() -> None:
            if bus is not None:  # while another bus is waited on, nobody else takes the answers
                bus.receive(self.clock.now())
            stop.look()

        self._waits.watch(look)

    def _reads_stop(self, name: str) -> bool:
        device: object = self.devices[name]
        return device is self._stop

    def _check_stop(self) -> None:
        """Refuse to energise unless the circuit of the emergency stop is closed, and was."""
        stop = self._stop
        if stop is None:
            return
        if stop.emergency_stop().value:
            raise EmergencyStop.open_at(stop.stop_place())
        if stop.was_pressed():
            raise EmergencyStop(
                "the emergency stop was pressed while connecting, and released; its contact is "
                f"read by {stop.stop_place()}"
            )

    def close(self) -> None:
        """Make safe and release everything; idempotent.

        A step that raises keeps no other from being taken; what it raised comes after them.
        """
        devices, buses = self.devices.values(), self.buses.values()
        steps = [
            *[device.make_safe for device in devices],
            *[bus.make_safe for bus in buses],
            *[device.close for device in devices],
            *[bus.close for bus in buses],
            self._release,
        ]
        with self.closing(), ExitStack() as stack:
            for step in reversed(steps):
                stack.callback(step)

    def statistics(self) -> dict[str, dict[str, float]]:
        """Return the counters of every bus, for the manifest."""
        return {name: bus.statistics() for name, bus in self.buses.items()}
